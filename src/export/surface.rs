//! The surfaces of superellipsoids as meshes of quadrilaterals, for formats that have no such shape.
//!
//! The corners are those of a grid on a cube, moved along rays from the centre onto the surface of the superellipsoid
//! with unit semi-axes, then scaled. They lie on the surface to rounding.

use crate::shape::Norm;
use glam::DVec3;
use std::f64::consts::PI;

/// Faces along an edge of the cube. Of a body with equal semi-axes the faces are inside by at most 1.5 % of a semi-axis
/// for equal exponents to 10, and 3 % for the exponents 2 and 10.
pub(super) const FACES: usize = 10;

/// A closed surface about the origin, in the body's axes.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Corners.
    pub points: Vec<DVec3>,
    /// The outward unit normals there.
    pub normals: Vec<DVec3>,
    /// The corners of each face, anticlockwise from outside.
    pub faces: Vec<[usize; 4]>,
}

/// A coordinate of the grid: the mean of equal angles, which are best for a ball, and of a spacing that is dense near
/// the edges, which is best for a cube with rounded ones.
fn coordinate(k: usize) -> f64 {
    let t = 2.0 * k as f64 / FACES as f64 - 1.0;
    0.5 * ((0.25 * PI * t).tan() + (0.5 * PI * t).sin())
}

impl Surface {
    /// The surface with unit semi-axes.
    pub fn unit(exponents: [f64; 2]) -> Surface {
        let norm = Norm::new([1.0; 3], exponents);
        let mut surface = Surface { points: Vec::new(), normals: Vec::new(), faces: Vec::new() };
        let side = FACES + 1;
        let number = |[i, j, k]: [usize; 3]| (i * side + j) * side + k;
        let mut numbers = vec![0; side * side * side];
        for at in (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..side).map(move |k| [i, j, k]))) {
            if at.iter().any(|k| *k == 0 || *k == FACES) {
                numbers[number(at)] = surface.points.len();
                let ray = DVec3::from_array(at.map(coordinate));
                let (gauge, gradient) = norm.gauge(ray);
                surface.points.push(ray / gauge);
                surface.normals.push(gradient.normalize());
            }
        }
        for axis in 0..3 {
            let corner = |end: usize, a: usize, b: usize| {
                let mut at = [end; 3];
                (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (a, b);
                numbers[number(at)]
            };
            for (a, b) in (0..FACES).flat_map(|a| (0..FACES).map(move |b| (a, b))) {
                let [low, high] = [0, FACES].map(|end| {
                    [corner(end, a, b), corner(end, a + 1, b), corner(end, a + 1, b + 1), corner(end, a, b + 1)]
                });
                let [p, q, r, s] = low;
                surface.faces.extend([[s, r, q, p], high]);
            }
        }
        surface
    }

    /// The surface with these semi-axes.
    pub fn scaled(&self, radii: [f64; 3]) -> Surface {
        let radii = DVec3::from_array(radii);
        Surface {
            points: self.points.iter().map(|point| *point * radii).collect(),
            normals: self.normals.iter().map(|normal| (*normal / radii).normalize()).collect(),
            faces: self.faces.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Shape, Superellipsoid};

    const BODIES: [([f64; 3], [f64; 2]); 6] = [
        ([1.0; 3], [2.0; 2]),
        ([0.5; 3], [8.0; 2]),
        ([0.3, 0.4, 0.8], [6.0, 3.0]),
        ([1.0, 2.0, 0.1], [10.0; 2]),
        ([1.0, 1.0, 30.0], [2.0, 10.0]),
        ([3.0, 0.5, 1.0], [10.0, 2.0]),
    ];

    /// By the inequality as it is written, and its derivative by differences.
    #[test]
    fn corners_are_on_the_surface_and_normals_are_its_own() {
        for (radii, exponents) in BODIES {
            let [n1, n2] = exponents;
            let left = |p: DVec3| {
                let v = (p / DVec3::from_array(radii)).abs();
                (v.x.powf(n2) + v.y.powf(n2)).powf(n1 / n2) + v.z.powf(n1)
            };
            let surface = Surface::unit(exponents).scaled(radii);
            assert_eq!(surface.points.len(), 6 * FACES * FACES + 2);
            for (point, normal) in surface.points.iter().zip(&surface.normals) {
                assert!(
                    (left(*point) - 1.0).abs() < 1e-12,
                    "{radii:?} {exponents:?} {point}: {:e}",
                    left(*point) - 1.0
                );
                let slope = DVec3::AXES.map(|axis| {
                    let h = 1e-6 * axis.dot(DVec3::from_array(radii));
                    (left(*point + h * axis) - left(*point - h * axis)) / (2.0 * h)
                });
                let off = DVec3::from_array(slope).normalize().distance(*normal);
                assert!(off < 1e-7, "{radii:?} {exponents:?} {point}: {off:e}");
            }
        }
    }

    /// Every edge belongs to two faces in opposite directions; the volume within is close to the body's, and less.
    #[test]
    fn it_is_closed_and_faces_outwards() {
        for (radii, exponents) in BODIES {
            let Surface { points, faces, .. } = Surface::unit(exponents).scaled(radii);
            let mut edges = std::collections::BTreeSet::new();
            let mut volume = 0.0;
            for [a, b, c, d] in faces.iter().copied() {
                for edge in [(a, b), (b, c), (c, d), (d, a)] {
                    assert!(edges.insert(edge), "{edge:?} twice");
                }
                for [p, q, r] in [[a, b, c], [a, c, d]].map(|face| face.map(|corner| points[corner])) {
                    volume += p.cross(q).dot(r) / 6.0;
                }
            }
            assert_eq!(edges.len(), 4 * faces.len());
            assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
            let part = volume / Shape::Superellipsoid(Superellipsoid::new(radii, exponents)).volume();
            assert!((0.97..1.0).contains(&part), "{radii:?} {exponents:?}: {part}");
        }
    }
}
