//! Contact stress and pressure, from the contact forces of a checkpoint.
//!
//! With the force `f = gamma n` on b, with friction `gamma n + t` (and its opposite on a), and the centres' distance `l
//! = x_b - x_a`, the virial of a contact is `f l^T`; the stress, positive where it compresses, is their sum's symmetric
//! part over the bodies' own volume, and the pressure its trace over the dimension (J. Christoffersen, M. M. Mehrabadi,
//! S. Nemat-Nasser, J. Appl. Mech. 48, 339 (1981)). Times a packing fraction it is the stress of the packing as a
//! whole. A body's own part has its lever instead of `l`; the profile is the sum of these parts over a ring's area.
//! Only contacts count, neither drag nor inertia. Contacts with walls count in a body's own part, and so in the
//! profile, but not in the stress.

use super::bins::Bins;
use super::density::ring;
use super::{About, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count, radius};
use glam::{DMat3, DVec3};

const COLUMNS: [Column; 10] = [
    Column { name: "force_mean", what: "mean contact force of the pairs that push; a force" },
    Column { name: "force_most", what: "the largest contact force" },
    Column {
        name: "pressure",
        what: "trace of the stress over the dimension; force over area, in the plane over length",
    },
    Column { name: "shear", what: "half the difference of the largest and the least principal stress" },
    Column { name: "stress_xx", what: "contact stress over the bodies' own volume, positive in compression" },
    Column { name: "stress_xy", what: "likewise" },
    Column { name: "stress_yy", what: "likewise" },
    Column { name: "stress_xz", what: "likewise; in space" },
    Column { name: "stress_yz", what: "likewise; in space" },
    Column { name: "stress_zz", what: "likewise; in space" },
];

const PROFILE: [Column; 4] = [
    Column { name: "radius", what: "middle of the ring; a length" },
    Column {
        name: "pressure",
        what: "contact pressure of the packing: virials of the bodies centred in the ring over the ring's area",
    },
    Column { name: "body_pressure", what: "the same over these bodies' own area; none where no centre is" },
    Column { name: "bodies", what: "centres in the ring" },
];

/// Contact stress.
pub(super) struct Stress;

impl Measure for Stress {
    fn about(&self) -> &'static About {
        &About {
            name: "stress",
            line: "contact stress, pressure and its profile",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Curves }),
            plots: &[&["pressure", "shear"], &["force_mean", "force_most"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let position = &view.bodies().position;
        if position.is_empty() {
            return Err("there is no body".into());
        }
        let mut virial = DMat3::ZERO;
        let (mut sum, mut most, mut pairs) = (0.0, 0.0_f64, 0_usize);
        for contact in view.pushing()? {
            let [a, b] = contact.pair;
            virial += dyad(contact.force(), position[b] + contact.shift - position[a]);
            (sum, most, pairs) = (sum + contact.gamma, most.max(contact.gamma), pairs + 1);
        }
        let stress = 0.5 * (virial + virial.transpose()) * (1.0 / view.volumes.iter().sum::<f64>());
        let at = |row: usize, column: usize| cell(stress.col(column)[row]);
        let in_space = |row, column| if view.planar() { None } else { at(row, column) };
        let mean = (pairs > 0).then(|| sum / pairs as f64);
        let mut values =
            vec![mean, mean.map(|_| most), cell(trace(stress) / view.dimension()), cell(shear(stress, view.planar()))];
        values.extend([at(0, 0), at(0, 1), at(1, 1), in_space(0, 2), in_space(1, 2), in_space(2, 2)]);
        let open = view.in_open_space();
        let remark = match (pairs, open) {
            (0, _) => Some("no pair pushes".to_owned()),
            (_, Err(LeftOut(reason))) => Some(format!("profile: {reason}")),
            _ => None,
        };
        Ok(Found { values, rows: profile(view, &view.virials()?), remark })
    }
}

fn profile(view: &View<'_>, virial: &[f64]) -> Vec<Vec<super::Cell>> {
    if view.in_open_space().is_err() {
        return Vec::new();
    }
    let Some(bins) = Bins::new(view.bin(), radius::outermost(view)) else { return Vec::new() };
    let mut sums = vec![(0.0, 0.0, 0_usize); bins.count];
    for (i, (own, space)) in virial.iter().zip(&view.volumes).enumerate() {
        if let Some(bin) = bins.of(view.distance(i)) {
            let (all, volume, bodies) = sums[bin];
            sums[bin] = (all + own, volume + space, bodies + 1);
        }
    }
    let row = |(bin, &(virial, volume, bodies)): (usize, &(f64, f64, usize))| {
        let over = |volume: f64| cell(virial / (view.dimension() * volume));
        vec![cell(bins.middle(bin)), over(ring(view, bins, bin)), over(volume), count(bodies)]
    };
    sums.iter().enumerate().map(row).collect()
}

/// The matrix `a b^T`.
fn dyad(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Half the difference of the largest and the smallest principal stress.
fn shear(stress: DMat3, planar: bool) -> f64 {
    if planar {
        return (0.5 * (stress.x_axis.x - stress.y_axis.y)).hypot(stress.y_axis.x);
    }
    // The eigenvalue iteration would not end for values that are not finite.
    if !stress.is_finite() {
        return f64::NAN;
    }
    let principal = nalgebra::Matrix3::from_column_slice(&stress.to_cols_array()).symmetric_eigenvalues();
    0.5 * (principal.max() - principal.min())
}
