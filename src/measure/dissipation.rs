//! Power dissipated by drag, under the overdamped law: `sum of F . u + T . w = xi (L |u|^2 + L^3 |w|^2 / 12)` with the
//! velocities of the last step, or with the resistances of other drag (Palmer, Aktulga, Gao 2026 for the drag;
//! Rayleigh's dissipation function is half of it).

use super::{About, Column, Found, LeftOut, Measure, View, cell};
use crate::dynamics::Drag;

const COLUMNS: [Column; 1] =
    [Column { name: "dissipation", what: "power that the bodies' drag takes; force times length over time" }];

/// Power dissipated by drag.
pub(super) struct Dissipation;

impl Measure for Dissipation {
    fn about(&self) -> &'static About {
        &About {
            name: "dissipation",
            line: "power that drag takes, under the overdamped law",
            columns: &COLUMNS,
            profile: None,
            plots: &[&["dissipation"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let drag = view
            .frame
            .drag
            .ok_or("the run's scene is not there, its law is not overdamped, or a flow carries its bodies")?;
        if view.state.step == 0 {
            return Err("no step has been taken, so there are no velocities".into());
        }
        let bodies = view.bodies();
        let of = |i: usize| {
            let (u, w) = (bodies.velocity[i], bodies.angular_velocity[i]);
            match drag {
                Drag::Even(xi) => {
                    let length = bodies.shape[i].major_axis();
                    xi * (length * u.length_squared() + length.powi(3) * w.length_squared() / 12.0)
                }
                drag => {
                    let (resistance, orientation) = (drag.resistance(&bodies.shape[i]), bodies.orientation[i]);
                    resistance.linear.square(orientation, u) + resistance.turning.square(orientation, w)
                }
            }
        };
        Ok(Found { values: vec![cell((0..bodies.len()).map(of).sum())], ..Found::default() })
    }
}
