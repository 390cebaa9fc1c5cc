//! Inertial motion: Newton's and Euler's equations.
//!
//! The velocity is advanced, `U = U^k + dt M^-1 (F + D gamma)`; of the turn it is the angular momentum in space: `L^k+1
//! = L^k + dt (T + D gamma)`, and the state's angular velocity is what `L^k+1` gives in the attitude that the step ends
//! with. The body turns with `w = w_free + E D gamma`: `w_free` is the [mean velocity](super::Spin) of a step without
//! torque from `L^k + dt T`, and the effective mobility `E = dt I^-1` is that at the step's start, so that contact is
//! affine in `gamma`. Without torque and contact, angular momentum and energy are kept to rounding; attitudes are of
//! second order.
//!
//! Midpoint steps have the forces, torques and mobilities of the step's middle, and half of the forces' impulse comes
//! after the move: `V = U^k + dt/2 M^-1 F`, `U^k+1 = V + dt/2 M^-1 F`, and `w_free` is that from `L^k + dt/2 T`. All of
//! contact's impulse comes with the move, so that a contact that closes in the step is inelastic as in a step of first
//! order.
//!
//! With drag the law's equations are solved exactly for steady loads: in a step of first order all of it comes before
//! the move, in a midpoint step half before and half after it ([`Damping`]), about the principal axes there. The
//! effective mobility is `(1 - e^-a) / a dt M^-1`, which is that of the overdamped law where `a`, the step over the
//! time in which drag stops the body, is large. What is split is the turn: between the halves of drag it is that of a
//! body without any, so that the tumbling of strongly damped bodies is off by a part of the order of `dt |w|`.
//!
//! Contact is inelastic: the complementarity conditions bring approaching surfaces to rest against each other.

use super::along::{Along, Root, about};
use super::damping::Damping;
use super::motion::After;
use super::{Drag, Ending, Factor, Law, Load, Motion, Spin, Twist};
use crate::bodies::Bodies;
use glam::{DQuat, DVec3};

/// Solid bodies of one density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass per volume.
    pub density: f64,
    /// The drag, where there is any.
    pub drag: Option<Drag>,
}

impl Inertial {
    /// The motion from `start` under a load found in `here`, of whose impulse over `dt` the part `before` comes before
    /// the move.
    fn over(&self, [start, here]: [&Bodies; 2], i: usize, load: Load, dt: f64, before: f64) -> Motion {
        let shape = here.shape[i];
        let mass = self.density * shape.volume();
        let moments = self.density * shape.unit_inertia();
        let spin = Spin::new(moments);
        let (orientation, twist) = (start.orientation[i], start.twist(i));
        let momentum = spin.momentum(orientation, twist.angular);
        let impulse = dt / moments.x * load.torque;
        let speeding = dt / mass * load.force;
        let root = (dt / moments).map(f64::sqrt);
        Motion {
            free: Twist {
                linear: twist.linear + before * speeding,
                angular: spin.turning(orientation, momentum + before * impulse, dt),
            },
            factor: Factor { translation: Root::Even((dt / mass).sqrt()), rotation: about(here.orientation[i], root) },
            ending: Ending { linear: (1.0 - before) * speeding, momentum: momentum + impulse, after: None },
        }
    }

    /// The same with drag.
    fn damped(
        &self,
        [start, here]: [&Bodies; 2],
        i: usize,
        load: Load,
        (dt, before): (f64, f64),
        drag: Drag,
    ) -> Motion {
        let shape = here.shape[i];
        let mass = self.density * shape.volume();
        let moments = self.density * shape.unit_inertia();
        let spin = Spin::new(moments);
        let (orientation, twist) = (start.orientation[i], start.twist(i));
        let over = |time: f64| Damping::over(time, drag, self.density, &shape);
        let (part, Damping { share: whole, .. }) = (over(before * dt), over(dt));
        let kept = part.kept.of_turning(orientation, spin.momentum(orientation, twist.angular));
        let impulse = part.share.of_turning(here.orientation[i], before * dt / moments.x * load.torque);
        let speeding = match part.share.linear {
            Along::Even(share) => share * before * dt / mass * load.force,
            axes => axes.of(here.orientation[i], before * dt / mass * load.force),
        };
        let (momentum, late) = (kept + impulse, before < 1.0);
        let root = (dt / moments * whole.turning).map(f64::sqrt);
        Motion {
            free: Twist {
                linear: part.kept.linear.of(orientation, twist.linear) + speeding,
                angular: spin.turning(orientation, momentum, dt),
            },
            factor: Factor {
                translation: whole.linear.with(|share| (dt / mass * share).sqrt()).root(here.orientation[i]),
                rotation: about(here.orientation[i], root),
            },
            ending: Ending {
                linear: if late { speeding } else { DVec3::ZERO },
                momentum,
                after: late.then_some(After { kept: part.kept, momentum: impulse }),
            },
        }
    }
}

impl Law for Inertial {
    fn motion(&self, bodies: &Bodies, i: usize, load: Load, dt: f64) -> Motion {
        match self.drag {
            Some(drag) => self.damped([bodies, bodies], i, load, (dt, 1.0), drag),
            None => self.over([bodies, bodies], i, load, dt, 1.0),
        }
    }

    fn motion_by_middle(&self, start: &Bodies, middle: &Bodies, i: usize, load: Load, dt: f64) -> Motion {
        match self.drag {
            Some(drag) => self.damped([start, middle], i, load, (dt, 0.5), drag),
            None => self.over([start, middle], i, load, dt, 0.5),
        }
    }

    fn arrived(&self, here: &Bodies, i: usize, motion: &Motion, moved: Twist, orientation: DQuat) -> Twist {
        let spin = Spin::new(here.shape[i].unit_inertia());
        let by_contact = spin.momentum(here.orientation[i], moved.angular - motion.free.angular);
        let momentum = motion.ending.momentum + by_contact;
        let (moved, momentum) = match &motion.ending.after {
            Some(After { kept, momentum: late }) => {
                (kept.linear.of(orientation, moved.linear), kept.of_turning(orientation, momentum) + *late)
            }
            None => (moved.linear, momentum),
        };
        Twist { linear: moved + motion.ending.linear, angular: spin.velocity(orientation, momentum) }
    }
}
