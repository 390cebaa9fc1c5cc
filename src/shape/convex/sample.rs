//! The normals that a support function is looked at with, and what they tell of the body.
//!
//! The normals are those of points spread over the box-fitting ellipsoid, `n ~ u / e` with `e` the body's half widths
//! along its axes and `u` on an octahedron's grid, blown up to the sphere: so the points of a slender body are as
//! evenly spread as a round one's.

use super::{ConvexError, SupportFunction};
use glam::{DVec2, DVec3};

/// Intervals along an edge of the octahedron's grid; even, for the half as fine grid. 9,800 points in all.
pub(super) const FREQUENCY: usize = 48;
/// The same of the grid whose points are all compared with one another: 360.
const COARSE: usize = 8;
/// By how much of the body's size a point may lie farther than the one whose normal it is: rounding of a function of
/// some ten operations is under 1e-14.
const FARTHER: f64 = 1e-11;
/// Halvings of the angle between two normals that a jump is looked for with: it is then 3e-14.
const HALVINGS: usize = 40;
/// A jump, as a part of the size. After the halvings the point of a superellipsoid of degree 4, whose curvature is zero
/// where it meets the axes, has moved by 3e-5, that of any body with a greater curvature by less.
const JUMP: f64 = 1e-3;
/// A radius of curvature between neighbouring normals, as a part of the size, under which there is a corner: the least
/// of an ellipsoid of the greatest aspect ratio is 1e-6.
const SHARP: f64 = 1e-9;
/// Farthest points that the search for the farthest of all starts from, its rounds at most, and the gain, as a part,
/// that ends it.
const STARTS: usize = 100;
const ROUNDS: usize = 200;
const GAIN: f64 = 1e-15;

/// A body's points for a grid of normals.
pub(super) struct Samples {
    normals: Vec<DVec3>,
    pub points: Vec<DVec3>,
    /// The greatest distance of a point from the origin.
    size: f64,
    /// The least radius of curvature at the normals.
    least_curvature_radius: f64,
}

/// Which face of the octahedron: the signs of its points' coordinates.
pub(super) fn octant(face: usize) -> DVec3 {
    let sign = |bit: usize| if face & bit == 0 { 1.0 } else { -1.0 };
    DVec3::new(sign(1), sign(2), sign(4))
}

/// The normals of a grid with `frequency` intervals along an edge of the octahedron, stretched for a body with these
/// half widths: face by face, in rows of falling length.
pub(super) fn directions(frequency: usize, half_widths: DVec3) -> impl Iterator<Item = DVec3> {
    let of_face = move |face: usize| {
        let rows = (0..=frequency).flat_map(move |i| (0..=frequency - i).map(move |j| [i, j, frequency - i - j]));
        // A zero added takes the sign of a zero away.
        rows.map(move |at| {
            (octant(face) * DVec3::from_array(at.map(|x| x as f64)).normalize() / half_widths + 0.0).normalize()
        })
    };
    (0..8).flat_map(of_face)
}

/// How many points of the grid are on a face.
const ON_FACE: usize = (FREQUENCY + 1) * (FREQUENCY + 2) / 2;

/// The number of a face's point in row `i` and place `j`.
pub(super) fn number(face: usize, i: usize, j: usize) -> usize {
    face * ON_FACE + i * (FREQUENCY + 1) - i * i.saturating_sub(1) / 2 + j
}

impl Samples {
    /// Asks for the points, and refuses those that are not finite and those of a body that does not hold the origin.
    pub fn of(function: &dyn SupportFunction) -> Result<Samples, ConvexError> {
        let point = |n: DVec3| {
            let (point, normal) = (function.point(n), n.to_array());
            let reach = n.dot(point);
            if !point.is_finite() {
                Err(ConvexError::NotFinite { normal })
            } else if reach <= 0.0 {
                Err(ConvexError::OriginOutside { normal, reach })
            } else {
                Ok(point)
            }
        };
        let mut half_widths = DVec3::ZERO;
        for (i, axis) in DVec3::AXES.into_iter().enumerate() {
            half_widths[i] = 0.5 * (point(axis)? - point(-axis)?)[i];
        }
        let (largest, smallest) = (half_widths.max_element(), half_widths.min_element());
        super::check_size("the half width", largest)?;
        super::check_size("the half width", smallest)?;
        super::check_aspect("the half width", largest, smallest)?;
        let normals: Vec<DVec3> = directions(FREQUENCY, half_widths).collect();
        let points = normals.iter().map(|n| point(*n)).collect::<Result<Vec<DVec3>, ConvexError>>()?;
        let size = points.iter().map(|y| y.length()).fold(0.0, f64::max);
        Ok(Samples { normals, points, size, least_curvature_radius: 0.0 })
    }

    /// Refuses what is not convex, not strictly so, or not smooth.
    pub fn check(&mut self, function: &dyn SupportFunction) -> Result<(), ConvexError> {
        let step = FREQUENCY / COARSE;
        let coarse: Vec<usize> = (0..8)
            .flat_map(|face| {
                (0..=COARSE).flat_map(move |i| (0..=COARSE - i).map(move |j| number(face, step * i, step * j)))
            })
            .collect();
        coarse.iter().try_for_each(|a| coarse.iter().try_for_each(|b| self.check_farthest(*a, *b)))?;
        for [a, b] in edges() {
            self.check_farthest(a, b)?;
            self.check_farthest(b, a)?;
            self.check_steady(function, a, b)?;
        }
        self.check_smooth(function)
    }

    /// The point for a normal must be the farthest along it.
    fn check_farthest(&self, of: usize, other: usize) -> Result<(), ConvexError> {
        let by = self.normals[of].dot(self.points[other] - self.points[of]);
        if by <= FARTHER * self.size {
            return Ok(());
        }
        let [normal, farther] = [of, other].map(|k| self.normals[k].to_array());
        Err(ConvexError::NotConvex { normal, farther, by })
    }

    /// The point must not jump between two normals: the half way with the greater change is followed.
    fn check_steady(&self, function: &dyn SupportFunction, a: usize, b: usize) -> Result<(), ConvexError> {
        let (mut a, mut b) = ((self.normals[a], self.points[a]), (self.normals[b], self.points[b]));
        for _ in 0..HALVINGS {
            if a.1.distance(b.1) <= JUMP * self.size {
                return Ok(());
            }
            let normal = (a.0 + b.0).normalize();
            let middle = (normal, function.point(normal));
            if middle.1.distance(a.1) > middle.1.distance(b.1) {
                b = middle;
            } else {
                a = middle;
            }
        }
        let jump = a.1.distance(b.1);
        if jump <= JUMP * self.size { Ok(()) } else { Err(ConvexError::Flat { normal: a.0.to_array(), jump }) }
    }

    fn check_smooth(&mut self, function: &dyn SupportFunction) -> Result<(), ConvexError> {
        let step = curvature_step(2.0 * self.size / self.thickness());
        let mut least = f64::INFINITY;
        for n in &self.normals {
            let (h11, h12, h22) = hessian(function, *n, n.any_orthonormal_pair(), step);
            let radius = 0.5 * (h11 + h22) - (0.5 * (h11 - h22)).hypot(h12);
            if radius.abs() <= SHARP * self.size {
                return Err(ConvexError::Sharp { normal: n.to_array() });
            }
            // Points that change so fast that differences tell no matrix, as a superellipsoid's on the axes, are not
            // where it is most curved.
            if radius > 0.0 {
                least = least.min(radius);
            }
        }
        self.least_curvature_radius = least;
        Ok(())
    }

    /// Half the least radius of curvature seen.
    pub fn roundness(&self) -> f64 {
        0.5 * self.least_curvature_radius
    }

    /// The least width seen. The normals come with their opposites.
    pub fn thickness(&self) -> f64 {
        let width = |k: usize| {
            let (face, on_face) = (k / ON_FACE, k % ON_FACE);
            self.normals[k].dot(self.points[k] - self.points[(7 - face) * ON_FACE + on_face])
        };
        (0..self.points.len()).map(width).fold(f64::INFINITY, f64::min)
    }

    /// The greatest distance of all from the origin: from each of the farthest points seen, the point in the direction
    /// of the point is as far or farther.
    pub fn bounding_radius(&self, function: &dyn SupportFunction) -> f64 {
        let mut starts = self.points.clone();
        starts.sort_by(|a, b| b.length().total_cmp(&a.length()));
        starts.truncate(STARTS);
        let climbed = starts.into_iter().map(|mut at| {
            for _ in 0..ROUNDS {
                let next = function.point(at.normalize());
                if next.length() <= at.length() * (1.0 + GAIN) {
                    break;
                }
                at = next;
            }
            at.length()
        });
        climbed.fold(0.0, f64::max)
    }
}

/// The numbers of neighbouring points.
fn edges() -> impl Iterator<Item = [usize; 2]> {
    let rows = (0..8).flat_map(|face| (0..FREQUENCY).flat_map(move |i| (0..FREQUENCY - i).map(move |j| (face, i, j))));
    rows.flat_map(|(face, i, j)| {
        let corners = [number(face, i, j), number(face, i + 1, j), number(face, i, j + 1)];
        [[corners[0], corners[1]], [corners[1], corners[2]], [corners[2], corners[0]]]
    })
}

/// The angle over which curvatures are taken, for a body whose largest size is so many times the smallest: they change
/// over an angle of one over that. Central differences of a round body's points are then good to 1e-10.
pub(super) fn curvature_step(aspect: f64) -> f64 {
    1e-5 / aspect
}

/// Turns of the basis at most that differences are taken in.
const TURNS: usize = 3;
/// The largest element beside the diagonal that is left after them, over the geometric mean of the diagonal.
const LEFT: f64 = 0.5;

/// The Hessian of the support function across `n` in a tangent basis, as (11, 12, 22), by central differences of the
/// point.
///
/// A convex body's is definite. Differences are not where the point changes like a root of the normal, as a
/// superellipsoid's on its axes: a direction at an angle to that change has nearly all of it. They are then taken again
/// in the directions in which the matrix is diagonal.
pub(super) fn hessian(function: &dyn SupportFunction, n: DVec3, basis: (DVec3, DVec3), step: f64) -> (f64, f64, f64) {
    let mut turn = DVec2::X;
    let mut found = differences(function, n, basis, step);
    for _ in 0..TURNS {
        let (h11, h12, h22) = found;
        if h12 * h12 < h11 * h22 {
            break;
        }
        turn = turn.rotate(DVec2::from_angle(0.5 * (2.0 * h12).atan2(h11 - h22)));
        let turned = (basis.0 * turn.x + basis.1 * turn.y, basis.1 * turn.x - basis.0 * turn.y);
        found = differences(function, n, turned, step);
    }
    if turn == DVec2::X {
        return found;
    }
    let (k11, k12, k22) = found;
    let most = LEFT * (k11 * k22).max(0.0).sqrt();
    let (k12, DVec2 { x, y }) = (k12.clamp(-most, most), turn);
    (
        k11 * x * x - 2.0 * k12 * x * y + k22 * y * y,
        (k11 - k22) * x * y + k12 * (x * x - y * y),
        k11 * y * y + 2.0 * k12 * x * y + k22 * x * x,
    )
}

fn differences(function: &dyn SupportFunction, n: DVec3, (e1, e2): (DVec3, DVec3), step: f64) -> (f64, f64, f64) {
    let change = |e: DVec3| {
        (function.point((n + e * step).normalize()) - function.point((n - e * step).normalize())) / (2.0 * step)
    };
    let (along_1, along_2) = (change(e1), change(e2));
    (along_1.dot(e1), 0.5 * (along_1.dot(e2) + along_2.dot(e1)), along_2.dot(e2))
}
