//! Constraints: rows that are made once and never changed again (the paper's equation for the ReLCP, telescoped).
//!
//! A row made at the configuration `C_j = C(U_j)` is one affine inequality in the step's *total* velocity `U`:
//!
//! ```text
//! g(U) = Phi(C_j) + dt D . (U - U_j) >= 0,   D = (-n, -t_a, n, t_b)
//! ```
//!
//! with the torque arms `t = r x n` carried back through the quaternion update to `C^k` ([`torque_arm`]), so that `D`
//! is the exact derivative of `Phi(C(U))` at `U_j`. Scaled by the root `L` of the effective mobility, `J = sqrt(dt) D
//! L`, the LCP matrix is `A = J J^T` and `U = U_free + L J^T gamma / sqrt(dt)`, for every law of motion.

pub(crate) mod bond;
pub(crate) mod friction;
mod source;
mod turning;

pub use source::{FEATURE_OF_SURFACES, RowSource, RowSourceError, sub_sphere_separations};

use crate::dynamics::{Ending, Factor, Motion, Root, Twist};
use crate::freedom::{pack, unpack};
use crate::lcp::Problem;
use crate::separation::Separation;
use glam::{DMat3, DVec3};

/// The torque arm `t = r x n` of a row found at a configuration that was reached with angular velocity `w` in `dt`, as
/// it acts on the velocity from the step's start: `(t - h x t) / (1 + |h|^2)` with `h = dt w / 2`.
///
/// A turn reached by the quaternion update `q + h q` responds to a change of `w` by the rotation
/// `dt (dw + h x dw) / (1 + |h|^2)`; this is its transpose applied to `t`.
#[inline]
pub fn torque_arm(lever: DVec3, normal: DVec3, angular: DVec3, dt: f64) -> DVec3 {
    carried_back(lever.cross(normal), angular, dt)
}

/// A torque arm, or the axis of a turn, that was found at a configuration that was reached with the angular velocity
/// `angular`, as it acts on the velocity from the step's start ([`torque_arm`]).
#[inline]
pub fn carried_back(arm: DVec3, angular: DVec3, dt: f64) -> DVec3 {
    let half = 0.5 * dt * angular;
    (arm - half.cross(arm)) / (1.0 + half.length_squared())
}

/// Least cosine between a row's blocks and those of an overlap's own row for the overlap to be taken for that row's: a
/// contact turns by less in half a step that its linearisation is good for. The other contacts of a pair of rings point
/// elsewhere, and where rods lie side by side the nearest points jump from end to end: their normals stay and their
/// torques do not. With the normals alone, 32 crowded cells come 2.1e-2, 4.5e-3 and 7.5e-4 from their places after a
/// time of 0.05 at dt 0.01, 0.002 and 0.0005, with the torques 7.0e-4, 1.3e-4 and 3.2e-5.
pub(crate) const LEAST_ALIGNED: f64 = 0.9;

/// One body's part in a row: how it moves in this step and the velocity that its configuration was reached with.
#[derive(Clone, Copy, Debug)]
pub struct Mover<'a> {
    /// Free velocity and mobility.
    pub motion: &'a Motion,
    /// `U_j`: zero for rows at the step's start.
    pub reached_with: Twist,
    /// The axis of a body of revolution where forces act, about which contact cannot turn it.
    pub axis: Option<DVec3>,
}

impl Mover<'_> {
    /// The torque arm of a contact of this body. Made at a trial, the arm of a body of revolution has a part along its
    /// axis where forces act, which would spin it.
    fn arm(&self, lever: DVec3, normal: DVec3, dt: f64) -> DVec3 {
        let angular = self.reached_with.angular;
        let arm = torque_arm(lever, normal, angular, dt);
        match self.axis {
            Some(axis) if angular != DVec3::ZERO => arm - axis * axis.dot(arm),
            _ => arm,
        }
    }
}

/// A wall's part: it does not move, so its block of `J` is zero.
pub const FIXED: Mover<'static> = Mover {
    motion: &Motion {
        free: Twist { linear: DVec3::ZERO, angular: DVec3::ZERO },
        factor: Factor { translation: Root::Even(0.0), rotation: DMat3::ZERO },
        ending: Ending { linear: DVec3::ZERO, momentum: DVec3::ZERO, after: None },
    },
    reached_with: Twist { linear: DVec3::ZERO, angular: DVec3::ZERO },
    axis: None,
};

/// The blocks of a row of `J` and its offset.
pub type Row<const D: usize> = ([[f64; D]; 2], f64);

/// Makes `problem` one of `bodies` bodies without rows, keeping its memory.
pub fn clear<const D: usize>(problem: &mut Problem<D>, bodies: usize) {
    problem.bodies = bodies;
    problem.pair.clear();
    problem.jacobian.clear();
    problem.q.clear();
    problem.cones.clear();
    problem.compliance.clear();
}

/// Moves the offset of row `row` so that `g = separation` at the total velocity whose scaled contact velocities are
/// `scaled`, if the row has the direction of the blocks `there`, those that a row of its own would have at that
/// separation, and this makes it tighter; says whether it did.
pub fn tighten<const D: usize>(
    problem: &mut Problem<D>,
    row: usize,
    (separation, there): (f64, &[[f64; D]; 2]),
    scaled: &[[f64; D]],
) -> bool {
    let [ja, jb] = &problem.jacobian[row];
    let dot = |j: &[f64; D], v: &[f64; D]| j.iter().zip(v).map(|(j, v)| j * v).sum::<f64>();
    let both = |[a, b]: [&[f64; D]; 2], [c, d]: [&[f64; D]; 2]| dot(a, c) + dot(b, d);
    let (own, other) = ([ja, jb], [&there[0], &there[1]]);
    let aligned = both(own, other) > LEAST_ALIGNED * (both(own, own) * both(other, other)).sqrt();
    let g = problem.value(row, scaled);
    let tightens = aligned && separation < g;
    if tightens {
        problem.q[row] += separation - g;
    }
    tightens
}

/// Appends the row of pair `pair` with these blocks and this offset to `problem`.
pub fn append<const D: usize>(problem: &mut Problem<D>, pair: [u32; 2], (jacobian, q): Row<D>) {
    problem.pair.push(pair);
    problem.jacobian.push(jacobian);
    problem.q.push(q);
}

/// The blocks and the offset of the row with separation `found`.
pub fn row<const D: usize>(found: &Separation, [a, b]: [Mover<'_>; 2], dt: f64) -> Row<D> {
    let normal = found.normal;
    let arm_a = a.arm(found.lever_a, normal, dt);
    let arm_b = b.arm(found.lever_b, normal, dt);
    row_of([a, b], normal, [arm_a, arm_b], found.separation, dt)
}

/// The same of a value that grows along `normal` and with these torque arms.
#[inline]
fn row_of<const D: usize>(
    [a, b]: [Mover<'_>; 2],
    normal: DVec3,
    [arm_a, arm_b]: [DVec3; 2],
    value: f64,
    dt: f64,
) -> Row<D> {
    let linear = (b.motion.free.linear - b.reached_with.linear) - (a.motion.free.linear - a.reached_with.linear);
    let still_to_come = normal.dot(linear) + arm_b.dot(b.motion.free.angular - b.reached_with.angular)
        - arm_a.dot(a.motion.free.angular - a.reached_with.angular);
    (blocks([a, b], normal, [arm_a, arm_b], dt), value + dt * still_to_come)
}

/// The blocks of a row along `direction`, with these torque arms.
fn blocks<const D: usize>(
    [a, b]: [Mover<'_>; 2],
    direction: DVec3,
    [arm_a, arm_b]: [DVec3; 2],
    dt: f64,
) -> [[f64; D]; 2] {
    let root = dt.sqrt();
    let block = |mover: Mover<'_>, direction: DVec3, arm: DVec3| {
        let factor = &mover.motion.factor;
        pack::<D>(factor.translation.times(root, direction), root * (factor.rotation * arm))
    };
    [block(a, -direction, -arm_a), block(b, direction, arm_b)]
}

/// The velocity `U = U_free + L v / sqrt(dt)` of a body whose scaled contact velocity is `v`.
#[inline]
pub fn velocity<const D: usize>(motion: &Motion, scaled: &[f64; D], dt: f64) -> Twist {
    let (linear, angular) = unpack(scaled);
    let root = dt.sqrt();
    // What the scene does not carry is exactly zero, also where the free motion is not (a planar scene's loads are in
    // the plane).
    let (free_linear, free_angular) = unpack::<D>(&pack(motion.free.linear, motion.free.angular));
    let contact = motion.factor.rotation * angular / root;
    Twist {
        linear: free_linear + motion.factor.translation.over::<D>(root, linear),
        angular: free_angular + unpack::<D>(&pack(DVec3::ZERO, contact)).1,
    }
}
