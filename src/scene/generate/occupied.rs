//! Which places are taken already: bounding capsules in hash grids, one grid a size class.

use crate::shape::Shape;
use glam::{DQuat, DVec3, I64Vec3};
use std::collections::{BTreeMap, HashMap};

/// A capsule that holds a body: all points within `radius` of the segment `centre - half .. centre + half`.
///
/// It is the body itself for spheres and spherocylinders. For an ellipsoid it has the longest radius for its half length and the middle
/// one for its radius, which holds the ellipsoid because the end's radius of curvature, at most `b^2 / c`, is not above `b`.
/// For a ring it is the bounding sphere, so that rings do not interlock by chance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capsule {
    pub centre: DVec3,
    pub half: DVec3,
    pub radius: f64,
}

impl Capsule {
    /// The capsule of a shape placed in space.
    pub fn of(shape: &Shape, position: DVec3, orientation: DQuat) -> Self {
        let (half, radius) = Self::body(shape);
        Capsule { centre: position, half: orientation * half, radius }
    }

    /// Half axis in body axes, and radius.
    pub fn body(shape: &Shape) -> (DVec3, f64) {
        match *shape {
            Shape::Sphere { radius } => (DVec3::ZERO, radius),
            Shape::Spherocylinder { diameter, length } => (DVec3::Z * (0.5 * (length - diameter)), 0.5 * diameter),
            Shape::Ellipsoid { radii } => {
                let mut order = [0, 1, 2];
                order.sort_by(|&i, &j| radii[i].total_cmp(&radii[j]));
                let [_, middle, longest] = order;
                (DVec3::AXES[longest] * (radii[longest] - radii[middle]), radii[middle])
            }
            Shape::Torus { major_radius, minor_radius } => (DVec3::ZERO, major_radius + minor_radius),
        }
    }

    /// Radius of the sphere about the centre that holds the capsule.
    pub fn reach(&self) -> f64 {
        self.half.length() + self.radius
    }

    fn overlaps(&self, other: &Capsule) -> bool {
        let limit = self.radius + other.radius;
        let apart = other.centre - self.centre;
        let reach = self.reach() + other.reach();
        apart.length_squared() < reach * reach && segment_distance_squared(apart, self.half, other.half) < limit * limit
    }
}

/// Squared distance of the segments `-u .. u` and `d - v .. d + v`.
///
/// The squared distance is a convex quadratic of the two parameters in the square `[-1, 1]^2`, so its least value is at the free minimum
/// if that is inside, else on one of the four sides. Parallel segments have no single free minimum; a side holds one of theirs.
fn segment_distance_squared(d: DVec3, u: DVec3, v: DVec3) -> f64 {
    let on_side = |fixed: DVec3, along: DVec3| {
        let square = along.length_squared();
        let t = if square > 0.0 { (fixed.dot(along) / square).clamp(-1.0, 1.0) } else { 0.0 };
        (fixed - t * along).length_squared()
    };
    let sides = on_side(d + v, u).min(on_side(d - v, u)).min(on_side(u - d, v)).min(on_side(-u - d, v));
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let determinant = uu * vv - uv * uv;
    if determinant <= f64::EPSILON * uu * vv {
        return sides;
    }
    let (s, t) = ((vv * u.dot(d) - uv * v.dot(d)) / determinant, (uv * u.dot(d) - uu * v.dot(d)) / determinant);
    if s.abs() > 1.0 || t.abs() > 1.0 { sides } else { sides.min((d + t * v - s * u).length_squared()) }
}

/// Capsules of about one size: each in the cell of its centre.
#[derive(Default)]
struct Grid {
    side: f64,
    first: HashMap<I64Vec3, u32>,
    /// The next capsule in the same cell; `u32::MAX` ends.
    next: Vec<u32>,
    capsules: Vec<Capsule>,
}

const END: u32 = u32::MAX;

impl Grid {
    fn cell(&self, point: DVec3) -> I64Vec3 {
        (point / self.side).floor().as_i64vec3()
    }

    fn insert(&mut self, capsule: Capsule) {
        let index = self.capsules.len() as u32;
        let before = self.first.insert(self.cell(capsule.centre), index).unwrap_or(END);
        self.next.push(before);
        self.capsules.push(capsule);
    }

    fn overlaps(&self, capsule: &Capsule) -> bool {
        // A grid's capsules reach at most half a side from their centres.
        let reach = DVec3::splat(capsule.reach() + 0.5 * self.side);
        let (low, high) = (self.cell(capsule.centre - reach), self.cell(capsule.centre + reach));
        let cells = (high - low).as_dvec3() + DVec3::ONE;
        if cells.element_product() > self.capsules.len() as f64 {
            return self.capsules.iter().any(|other| capsule.overlaps(other));
        }
        (low.x..=high.x).any(|x| {
            (low.y..=high.y).any(|y| (low.z..=high.z).any(|z| self.cell_overlaps(I64Vec3::new(x, y, z), capsule)))
        })
    }

    fn cell_overlaps(&self, cell: I64Vec3, capsule: &Capsule) -> bool {
        let mut index = self.first.get(&cell).copied().unwrap_or(END);
        while index != END {
            if capsule.overlaps(&self.capsules[index as usize]) {
                return true;
            }
            index = self.next[index as usize];
        }
        false
    }
}

/// All capsules placed so far.
#[derive(Default)]
pub(super) struct Occupied {
    /// By the power of two at or above twice the reach, which is the cells' side.
    grids: BTreeMap<i32, Grid>,
}

impl Occupied {
    /// Takes the capsule's place.
    pub fn insert(&mut self, capsule: Capsule) {
        let class = (2.0 * capsule.reach()).log2().ceil() as i32;
        let grid = self.grids.entry(class).or_insert_with(|| Grid { side: f64::from(class).exp2(), ..Grid::default() });
        grid.insert(capsule);
    }

    /// Whether the capsule overlaps one of those placed.
    pub fn overlaps(&self, capsule: &Capsule) -> bool {
        self.grids.values().any(|grid| grid.overlaps(capsule))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn vector(random: &mut ChaCha8Rng) -> DVec3 {
        DVec3::from_array(random.random::<[f64; 3]>()) * 2.0 - 1.0
    }

    #[test]
    fn segment_distances_match_a_fine_sample() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for trial in 0..200 {
            let (d, u) = (2.0 * vector(&mut random), vector(&mut random));
            let v = if trial % 5 == 0 { -0.7 * u } else { vector(&mut random) };
            let mut least = f64::INFINITY;
            for i in -100..=100 {
                for j in -100..=100 {
                    least = least.min((d + f64::from(j) / 100.0 * v - f64::from(i) / 100.0 * u).length_squared());
                }
            }
            let distance = segment_distance_squared(d, u, v).sqrt();
            assert!(distance <= least.sqrt() + 1e-12 && distance > least.sqrt() - 0.03, "{distance} {}", least.sqrt());
        }
        assert_eq!(segment_distance_squared(DVec3::X, DVec3::ZERO, DVec3::ZERO), 1.0);
    }

    #[test]
    fn grids_agree_with_all_pairs() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut occupied = Occupied::default();
        let mut all: Vec<Capsule> = Vec::new();
        for i in 0..600 {
            let size = if i % 50 == 0 { 2.0 } else { 0.02 + 0.2 * random.random::<f64>() };
            let capsule =
                Capsule { centre: 5.0 * vector(&mut random), half: size * vector(&mut random), radius: 0.3 * size };
            assert_eq!(occupied.overlaps(&capsule), all.iter().any(|other| capsule.overlaps(other)));
            occupied.insert(capsule);
            all.push(capsule);
        }
    }
}
