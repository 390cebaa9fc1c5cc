//! The turns of two bodies that bonds with a bending stiffness, hinges and welds resist.
//!
//! A turn is a rotation by the angle `theta` about the axis `n`, away from rest, and its energy is `B theta^2 / 2`:
//!
//! * a bend takes the direction `u_a` of the first body into that `u_b` of the second by the least angle, so that a
//!   twist about them is free. A hinge is a rigid bend of its axis;
//! * where a bond has some length, its own direction lies between those of both bodies: two bends, of `2 B` each, which
//!   are `B` in series;
//! * a weld resists the rotation from the orientation that the second body has at rest.
//!
//! A turn has a row along each of some axes `c` that turn with a body, half-way into the turn. As the body turns by
//! `psi` against the other, the part of `theta n` along `c` changes by `c . (n n + f (1 - n n)) psi` with
//! `f = (theta / 2) cot(theta / 2)`. The rows have the root of this, `n n + f^1/2 (1 - n n)`, so that their compliances
//! `1 / B` give Newton's matrix of the energy. That of a bend is exact for bends of any axis across both directions,
//! that of a weld has its symmetric part (rotation vectors: J. Diebel, *Representing Attitude*, 2006, section 7).

use crate::motion::Pose;
use glam::{DQuat, DVec3};

/// Bends by more than about 150 degrees get rows as if they were bent so far: at 180 degrees a bend has no axis.
const LEAST_TANGENT: f64 = 0.3;

/// A bond that is shorter than this part of its rest length gets rows as if it were as long: its direction would turn
/// by any angle.
const LEAST_WAY: f64 = 0.01;

/// What is resisted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Resists {
    /// The angle between a direction of each body, unit vectors in body axes.
    Bend([DVec3; 2]),
    /// All turns from this orientation of the second body in the axes of the first.
    Turn(DQuat),
}

/// The stiffness of a turn, torque over angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    pub stiffness: f64,
    pub resists: Resists,
}

/// What turns against what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Between {
    /// The second body against the first.
    Bodies,
    /// The bond against the first body.
    FirstAndWay,
    /// The second body against the bond.
    WayAndSecond,
}

/// A turn of bodies as they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    pub between: Between,
    /// The axis times the angle away from rest, space axes.
    pub angle: DVec3,
    /// The axes of its rows, unit vectors, and how many there are.
    axes: [DVec3; 3],
    count: usize,
    /// The inverse of its stiffness.
    pub compliance: f64,
}

impl Turn {
    /// The part of the angle along each axis, and the torque on what turns of a multiplier of 1.
    pub fn parts(&self) -> impl Iterator<Item = (f64, DVec3)> {
        let Turn { angle, axes, count, .. } = *self;
        let theta = angle.length();
        let part = move |axis: DVec3| {
            if theta == 0.0 {
                return (0.0, axis);
            }
            let about = angle / theta * angle.dot(axis) / theta;
            (angle.dot(axis), about + tangent(theta).sqrt() * (axis - about))
        };
        axes.into_iter().take(count).map(part)
    }
}

/// `(theta / 2) cot(theta / 2)`.
fn tangent(theta: f64) -> f64 {
    let half = 0.5 * theta;
    (half / half.tan()).max(LEAST_TANGENT)
}

impl Turning {
    /// The turns of bodies in these poses, `way` apart, with a bond of this rest length.
    pub fn turns(&self, [a, b]: [Pose; 2], way: DVec3, length: f64, planar: bool) -> Vec<Turn> {
        let compliance = self.stiffness.recip();
        let turn = |between, angle: DVec3, (body, toward): (DQuat, f64), axes: &[DVec3]| {
            let half = DQuat::from_scaled_axis(toward * 0.5 * angle) * body;
            let mut turn = Turn { between, angle, axes: [DVec3::ZERO; 3], count: axes.len(), compliance };
            turn.axes.iter_mut().zip(axes).for_each(|(own, axis)| *own = half * *axis);
            if planar {
                (turn.axes[0], turn.count) = (DVec3::Z, 1);
            }
            turn
        };
        match self.resists {
            Resists::Turn(rest) => {
                let rest = a.orientation * rest;
                let angle = rotation(b.orientation * rest.inverse());
                vec![turn(Between::Bodies, angle, (rest, 1.0), &[DVec3::X, DVec3::Y, DVec3::Z])]
            }
            Resists::Bend(of) => {
                let [from, to] = [a.orientation * of[0], b.orientation * of[1]];
                let across = of.map(|axis| <[DVec3; 2]>::from(axis.any_orthonormal_pair()));
                let first = |between, angle| turn(between, angle, (a.orientation, 1.0), &across[0]);
                if length == 0.0 {
                    return vec![first(Between::Bodies, bend(from, to))];
                }
                let along = along(way, from);
                let second = turn(Between::WayAndSecond, bend(along, to), (b.orientation, -1.0), &across[1]);
                let ends = [first(Between::FirstAndWay, bend(from, along)), second];
                ends.map(|end| Turn { compliance: 0.5 * compliance, ..end }).into()
            }
        }
    }
}

/// The direction of a bond; `instead` where its points are one.
fn along(way: DVec3, instead: DVec3) -> DVec3 {
    way.try_normalize().unwrap_or(instead)
}

/// How long a bond is at least, where its direction is concerned.
pub(crate) fn least_way(length: f64) -> f64 {
    LEAST_WAY * length
}

/// The rotation of the least angle from one unit vector to another, its axis times its angle.
fn bend(from: DVec3, to: DVec3) -> DVec3 {
    let (cross, cosine) = (from.cross(to), from.dot(to));
    let sine = cross.length();
    if sine > 0.0 {
        return cross * (sine.atan2(cosine) / sine);
    }
    // What is folded back bends about any axis; in the plane about z.
    let aside = if from.z.abs() < 0.5 { DVec3::Z } else { DVec3::X };
    if cosine < 0.0 { std::f64::consts::PI * from.cross(aside).cross(from).normalize() } else { DVec3::ZERO }
}

/// A rotation's axis times its angle, which is at most half a turn.
fn rotation(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    if sine > 0.0 { q.xyz() * (2.0 * sine.atan2(q.w) / sine) } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(axis: DVec3, angle: f64) -> Pose {
        Pose { position: DVec3::ZERO, orientation: DQuat::from_axis_angle(axis.normalize(), angle) }
    }

    #[test]
    fn a_bend_is_the_least_turn_from_one_direction_to_another() {
        for (from, to) in [(DVec3::X, DVec3::Y), (DVec3::X, DVec3::NEG_X), (DVec3::Z, DVec3::NEG_Z)] {
            let angle = bend(from, to);
            assert!((DQuat::from_scaled_axis(angle) * from).distance(to) < 1e-14 && angle.dot(from).abs() < 1e-14);
        }
        assert_eq!(bend(DVec3::Y, DVec3::Y), DVec3::ZERO);
        assert_eq!(bend(DVec3::X, DVec3::NEG_X), std::f64::consts::PI * DVec3::Z);
    }

    /// The torque of the rows, whose multipliers are those at rest for a stiffness of 1, is the gradient of the energy,
    /// and their matrix its second derivative along the axis and across it.
    #[test]
    fn the_rows_of_a_turn_are_the_gradient_and_the_matrix_of_its_energy() {
        let axes = [DVec3::new(0.3, -0.2, 0.9).normalize(), DVec3::new(-0.5, 0.1, 0.7).normalize()];
        for resists in [Resists::Bend(axes), Resists::Turn(DQuat::from_rotation_x(0.4))] {
            let turning = Turning { stiffness: 1.0, resists };
            let [a, b] = [pose(DVec3::new(1.0, 2.0, 0.5), 0.3), pose(DVec3::new(-1.0, 0.2, 0.4), 1.1)];
            let angle = |turned: DVec3| {
                let [one, other] = [0.5, -0.5].map(|part| DQuat::from_scaled_axis(part * turned));
                let a = Pose { orientation: other * a.orientation, ..a };
                let b = Pose { orientation: one * b.orientation, ..b };
                turning.turns([a, b], DVec3::ZERO, 0.0, false)[0].angle
            };
            let turn = turning.turns([a, b], DVec3::ZERO, 0.0, false)[0];
            let torque: DVec3 = turn.parts().map(|(part, about)| part * about).sum();
            let theta = turn.angle.length();
            assert!(theta > 0.5 && torque.distance(turn.angle) < 1e-13, "{resists:?}");
            let h = 1e-5;
            for direction in [DVec3::X, DVec3::Y, DVec3::Z] {
                let energy = |part: f64| 0.5 * angle(part * direction).length_squared();
                let slope = (energy(h) - energy(-h)) / (2.0 * h);
                assert!((slope - torque.dot(direction)).abs() < 1e-8, "{resists:?} {slope}");
            }
            // How the angle changes across its axis, by the symmetric part of the derivative.
            let across = turn.axes[..turn.count]
                .iter()
                .map(|axis| axis.reject_from(turn.angle))
                .max_by(|a, b| a.length().total_cmp(&b.length()));
            let across = across.unwrap().normalize();
            let slope = (angle(h * across) - angle(-h * across)).dot(across) / (2.0 * h);
            let rows: f64 = turn.parts().map(|(_, about)| about.dot(across).powi(2)).sum();
            assert!((slope - rows).abs() < 1e-8 && (rows - tangent(theta)).abs() < 1e-12, "{resists:?} {slope} {rows}");
        }
    }
}
