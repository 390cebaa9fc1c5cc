//! Occupied space: bounding capsules in hash grids, one grid for each size class.

use crate::periodic::Periods;
use crate::separation::{Placed, separation};
use crate::shape::{Centreline, Geometry, Shape};
use glam::{DQuat, DVec3, I64Vec3};
use std::collections::{BTreeMap, HashMap};

/// The bounding capsule of a shape, for the search of free positions, and its axis in body axes.
///
/// It is the body itself for spheres and spherocylinders. For an ellipsoid its half length is the longest radius and
/// its radius the middle one; it contains the ellipsoid because the end's radius of curvature, at most `b^2 / c`, is
/// not above `b`. For a ring or a custom shape it is the bounding sphere, so that rings do not interlock by chance.
pub(super) fn capsule_of(shape: &Shape) -> (Shape, DVec3) {
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Point | Centreline::Segment { .. }, .. } => (*shape, DVec3::Z),
        Geometry::Ellipsoid { radii } => {
            let mut order = [0, 1, 2];
            order.sort_by(|&i, &j| radii[i].total_cmp(&radii[j]));
            let [_, middle, longest] = order;
            let [diameter, length] = [2.0 * radii[middle], 2.0 * radii[longest]];
            (Shape::Spherocylinder { diameter, length }, DVec3::AXES[longest])
        }
        Geometry::Centreline { curve: Centreline::Circle { .. }, .. } | Geometry::Convex(_) => {
            (Shape::Sphere { radius: shape.bounding_radius() }, DVec3::Z)
        }
    }
}

/// The capsule of a shape placed in space.
pub(super) fn capsule(shape: &Shape, position: DVec3, orientation: DQuat) -> Placed {
    let (shape, axis) = capsule_of(shape);
    Placed { shape, position, orientation: orientation * DQuat::from_rotation_arc(DVec3::Z, axis) }
}

fn overlap(a: &Placed, b: &Placed) -> bool {
    let reach = a.shape.bounding_radius() + b.shape.bounding_radius();
    (b.position - a.position).length_squared() < reach * reach
        && separation(a, b, None).is_some_and(|found| found.separation < 0.0)
}

/// Capsules of one size class, each in the cell of its centre.
#[derive(Default)]
struct Grid {
    side: f64,
    first: HashMap<I64Vec3, u32>,
    /// The next capsule in the same cell; `u32::MAX` ends.
    next: Vec<u32>,
    capsules: Vec<Placed>,
}

const END: u32 = u32::MAX;

impl Grid {
    fn cell(&self, point: DVec3) -> I64Vec3 {
        (point / self.side).floor().as_i64vec3()
    }

    fn insert(&mut self, capsule: Placed) {
        let index = self.capsules.len() as u32;
        let before = self.first.insert(self.cell(capsule.position), index).unwrap_or(END);
        self.next.push(before);
        self.capsules.push(capsule);
    }

    /// Removes the capsule that was inserted last.
    fn remove_last(&mut self) {
        let (Some(capsule), Some(before)) = (self.capsules.pop(), self.next.pop()) else { return };
        let cell = self.cell(capsule.position);
        if before == END {
            self.first.remove(&cell);
        } else {
            self.first.insert(cell, before);
        }
    }

    fn overlaps(&self, capsule: &Placed) -> bool {
        // A grid's capsules reach at most half a side from their centres.
        let reach = DVec3::splat(capsule.shape.bounding_radius() + 0.5 * self.side);
        let (low, high) = (self.cell(capsule.position - reach), self.cell(capsule.position + reach));
        // In floats: for a grid far finer than the capsule, the number of cells would overflow an integer.
        let cells = high.as_dvec3() - low.as_dvec3() + DVec3::ONE;
        if cells.element_product() > self.capsules.len() as f64 {
            return self.capsules.iter().any(|other| overlap(capsule, other));
        }
        (low.x..=high.x).any(|x| {
            (low.y..=high.y).any(|y| (low.z..=high.z).any(|z| self.cell_overlaps(I64Vec3::new(x, y, z), capsule)))
        })
    }

    fn cell_overlaps(&self, cell: I64Vec3, capsule: &Placed) -> bool {
        let mut index = self.first.get(&cell).copied().unwrap_or(END);
        while index != END {
            if overlap(capsule, &self.capsules[index as usize]) {
                return true;
            }
            index = self.next[index as usize];
        }
        false
    }
}

/// The exponent of the side of a capsule's grid.
fn size_class(capsule: &Placed) -> i32 {
    (2.0 * capsule.shape.bounding_radius()).log2().ceil() as i32
}

/// All capsules placed so far.
#[derive(Default)]
pub(super) struct Occupied {
    /// By the exponent of the cells' side, the smallest power of two that is at least twice the reach.
    grids: BTreeMap<i32, Grid>,
    periods: Periods,
    /// The largest reach of a capsule from its centre.
    reach: f64,
}

impl Occupied {
    /// No capsules, in the space of `periods`.
    pub fn new(periods: Periods) -> Self {
        Occupied { periods, ..Occupied::default() }
    }

    /// Adds a capsule.
    pub fn insert(&mut self, capsule: Placed) {
        let capsule = Placed { position: self.periods.wrapped(capsule.position).0, ..capsule };
        self.reach = self.reach.max(capsule.shape.bounding_radius());
        let class = size_class(&capsule);
        let grid = self.grids.entry(class).or_insert_with(|| Grid { side: f64::from(class).exp2(), ..Grid::default() });
        grid.insert(capsule);
    }

    /// Removes a capsule that was inserted last of all of its size.
    pub fn remove_last(&mut self, capsule: &Placed) {
        if let Some(grid) = self.grids.get_mut(&size_class(capsule)) {
            grid.remove_last();
        }
    }

    /// Whether the capsule overlaps an earlier one, or an image of one.
    pub fn overlaps(&self, capsule: &Placed) -> bool {
        let overlaps = |capsule: &Placed| self.grids.values().any(|grid| grid.overlaps(capsule));
        if self.periods.is_none() {
            return overlaps(capsule);
        }
        let (position, length) = (self.periods.wrapped(capsule.position).0, self.periods.length());
        // The centres of earlier capsules are in the cell about the origin.
        let reach = 0.5 * length + self.reach + capsule.shape.bounding_radius();
        let near = |axis: usize, here: f64| {
            let images = [0.0, -length[axis], length[axis]].map(|by| here + by);
            images
                .into_iter()
                .take(if length[axis] > 0.0 { 3 } else { 1 })
                .filter(move |x| *x == here || x.abs() <= reach[axis])
        };
        // In a sheared cell images across the gradient are displaced along an axis before it.
        let placed = |x: f64, y: f64, z: f64| {
            let here = DVec3::new(x, y, z);
            let Some(tilt) = self.periods.tilt() else { return here };
            let across = tilt.gradient.index();
            let image = ((here - position)[across] / length[across]).round();
            here + image * tilt.offset * tilt.direction.unit()
        };
        near(2, position.z).any(|z| {
            near(1, placed(0.0, position.y, z).y).any(|y| {
                near(0, placed(position.x, y, z).x)
                    .any(|x| overlaps(&Placed { position: DVec3::new(x, y, z), ..*capsule }))
            })
        })
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
    fn grids_agree_with_all_pairs() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let mut occupied = Occupied::default();
        let mut all: Vec<Placed> = Vec::new();
        for i in 0..600 {
            let size = if i % 50 == 0 { 2.0 } else { 0.02 + 0.2 * random.random::<f64>() };
            let axis = vector(&mut random);
            let shape = Shape::Spherocylinder { diameter: 0.6 * size, length: size * (0.6 + 2.0 * axis.length()) };
            let orientation = DQuat::from_rotation_arc(DVec3::Z, axis.normalize());
            let capsule = Placed { shape, position: 5.0 * vector(&mut random), orientation };
            assert_eq!(occupied.overlaps(&capsule), all.iter().any(|other| overlap(&capsule, other)));
            // One that is taken back leaves no trace.
            occupied.insert(Placed { position: 5.0 * vector(&mut random), ..capsule });
            occupied.remove_last(&capsule);
            occupied.insert(capsule);
            all.push(capsule);
        }
    }
}
