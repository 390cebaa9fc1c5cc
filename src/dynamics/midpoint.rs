//! The midpoint rule's motion: the velocity of the whole step from forces and mobilities in its middle `C_h`.
//!
//! Without inertia `U = M_h (F_h + D gamma)`. With it the step moves with `V = U^k + dt/2 M_h^-1 F_h + dt M_h^-1 D gamma` and ends with
//! `U^k+1 = V + dt/2 M_h^-1 F_h`: half of the forces' impulse comes after the move, and all of contact's with it, so that a contact that closes
//! in the step is inelastic as in a step of first order. Without contact this is the midpoint rule in `x` and `U`.

use super::{Law, Motion, Twist};

/// The motion over a whole step that begins with velocity `from`: `middle` is the motion that [`Law::motion`] gives at `C_h` from there on, over
/// the same `dt`, and `reached` the velocity that it began with.
pub fn of_whole_step(law: &dyn Law, middle: Motion, reached: Twist, from: Twist) -> Motion {
    if !law.inertia() {
        return middle;
    }
    let half = |after, before, from| from + 0.5 * (after - before);
    let free = Twist {
        linear: half(middle.free.linear, reached.linear, from.linear),
        angular: half(middle.free.angular, reached.angular, from.angular),
    };
    Motion { free, ..middle }
}

/// The velocity at the end of a whole step of `motion` that began with `from` and moved with `twist`.
pub fn arrived(law: &dyn Law, motion: &Motion, from: Twist, twist: Twist) -> Twist {
    if !law.inertia() {
        return twist;
    }
    Twist {
        linear: twist.linear + (motion.free.linear - from.linear),
        angular: twist.angular + (motion.free.angular - from.angular),
    }
}
