//! Contact stress in a sheared cell, and the work of the shear.
//!
//! With the force `f` of a on b at an image and the centres' distance `l`, the contact stress of the suspension as a
//! whole is `sigma = -sum of f l^T / V`, with `V` the volume of the cell (G. K. Batchelor, J. Fluid Mech. 41, 545
//! (1970), for contact forces J. F. Brady and G. Bossis, Annu. Rev. Fluid Mech. 20, 111 (1988)). With the
//! flow's direction `d` and its gradient `e`, `sigma_de` is positive where contacts resist the shear. Times the rate
//! `g` it is the work of the shear on contacts per volume and time. Together with the work of the flow on rotating
//! bodies, the power is
//!
//! ```text
//! P = g V sigma_de - sum of T . w_J
//! ```
//!
//! with the contact torque `T` on a body and the angular velocity `w_J` by which the flow turns it. Contacts without
//! friction dissipate nothing, so without inertia and other forces all of it goes into the drag of bodies relative to
//! the flow, `sum of xi L |u - u(x)|^2 + xi L^3 / 12 |w - w_J|^2`. The difference of both is of the order of the step.

use super::view::Push;
use super::{About, Column, Found, LeftOut, Measure, View, cell};
use crate::motion::Twist;
use glam::{DMat3, DVec3};

const COLUMNS: [Column; 7] = [
    Column { name: "shear_strain", what: "rate times time: by how much the cell has been sheared" },
    Column { name: "shear_stress", what: "contact stress along the flow across its gradient, over the cell's volume" },
    Column {
        name: "shear_viscosity",
        what: "the contacts' part of the viscosity: the shear stress over the shear rate",
    },
    Column {
        name: "normal_difference_1",
        what: "first normal stress difference: along the flow less along its gradient; positive in tension",
    },
    Column { name: "normal_difference_2", what: "the second: along the gradient less along the third axis; in space" },
    Column { name: "shear_power", what: "power that the shear does work with on contacts" },
    Column { name: "shear_dissipation", what: "power that drag takes beside the flow; under a law that has drag" },
];

/// Contact stress under shear.
pub(super) struct ShearStress;

impl Measure for ShearStress {
    fn about(&self) -> &'static About {
        &About {
            name: "shear_stress",
            line: "contact stress in a sheared cell, its viscosity and its work",
            columns: &COLUMNS,
            profile: None,
            plots: &[
                &["shear_stress"],
                &["shear_viscosity"],
                &["normal_difference_1", "normal_difference_2"],
                &["shear_power", "shear_dissipation"],
            ],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let (shear, stream) = view.frame.shear.ok_or("the run's scene is not there, or has no periodic.shear")?;
        let bodies = view.bodies();
        let volume = bodies.periods.volume(view.planar()).ok_or("the cell is open along an axis, and has no volume")?;
        let at = |i: usize| bodies.placed(i);
        // Without drag the flow does not turn bodies.
        let turning = |i: usize| {
            let placed = at(i);
            let carried = stream.map(|stream| stream.carries(&placed.shape, placed.position, placed.orientation));
            carried.map_or(DVec3::ZERO, |twist| twist.angular)
        };
        let (mut virial, mut turned) = (DMat3::ZERO, 0.0);
        for Push { pair: [a, b], force, delta, lever } in view.pushes()? {
            virial += DMat3::from_cols(force * delta.x, force * delta.y, force * delta.z);
            turned += (lever - delta).cross(force).dot(turning(b)) - lever.cross(force).dot(turning(a));
        }
        let (direction, gradient) = (shear.direction.index(), shear.gradient.index());
        let stress = |row: usize, column: usize| -virial.col(column)[row] / volume;
        let along = stress(direction, gradient);
        let third = (!view.planar()).then_some(3 - direction - gradient);
        let twist = |i: usize| Twist { linear: bodies.velocity[i], angular: bodies.angular_velocity[i] };
        let taken = stream.map(|stream| (0..bodies.len()).map(|i| stream.power(&at(i), twist(i))).sum());
        let values = vec![
            cell(shear.rate * view.state.time),
            cell(along),
            cell(along / shear.rate),
            cell(stress(direction, direction) - stress(gradient, gradient)),
            third.and_then(|third| cell(stress(gradient, gradient) - stress(third, third))),
            cell(shear.rate * volume * along - turned),
            taken.and_then(cell),
        ];
        Ok(Found { values, ..Found::default() })
    }
}
