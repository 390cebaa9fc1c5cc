//! Microdomains: bodies that are connected by contacts between nearly parallel bodies.
//!
//! The domains of highly aligned cells in colonies of Z. You, D. J. G. Pearce, A. Sengupta, L. Giomi, Phys. Rev. X 8,
//! 031065 (2018). Two touching bodies belong to one domain if the angle between their axes is below a threshold, which
//! the user chooses. A body with an axis that is aligned with no touching body is a domain of one.

use super::clusters::{SIZE_COLUMNS, components, rows, sizes, summary};
use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell};

const COLUMNS: [Column; 6] = [
    Column { name: "domain_angle_degrees", what: "largest angle between touching bodies of one domain" },
    Column { name: "domains", what: "domains" },
    Column { name: "domain_mean", what: "mean number of bodies of a domain" },
    Column { name: "domain_largest", what: "bodies of the largest domain" },
    Column { name: "domain_volume", what: "mean volume of a domain's bodies; in the plane area" },
    Column {
        name: "domain_volume_weighted",
        what: "the same over the bodies by their volume: that of the domain which a point of a body is in",
    },
];

/// Microdomains.
pub(super) struct Microdomains;

impl Measure for Microdomains {
    fn about(&self) -> &'static About {
        &About {
            name: "microdomains",
            line: "microdomains: touching bodies that are nearly parallel",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &SIZE_COLUMNS, drawn: 1, counts: None, marks: Marks::Bars }),
            plots: &[&["domains"], &["domain_mean", "domain_largest"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        if view.axes.iter().all(Option::is_none) {
            return Err("no body has an axis".into());
        }
        let angle = view.settings.domain_angle_degrees;
        let aligned = |[a, b]: &[usize; 2]| {
            let (Some(a), Some(b)) = (view.axes[*a], view.axes[*b]) else { return false };
            // From the sine and the cosine: a small angle has a cosine of 1 up to rounding.
            a.cross(b).length().atan2(a.dot(b).abs()).to_degrees() < angle
        };
        let links = view.touching().map(|contact| contact.pair).filter(aligned);
        let roots = components(view.bodies().len(), links);
        let sizes = sizes(&roots, |root| view.axes[root].is_some());
        let mut values = vec![cell(angle)];
        values.extend(summary(&sizes));
        values.extend(volumes(view, &roots));
        Ok(Found { values, rows: rows(&sizes), remark: None })
    }
}

/// The domains' mean volume, and that weighted by volume.
fn volumes(view: &View<'_>, roots: &[usize]) -> [Cell; 2] {
    let mut volume = vec![0.0; roots.len()];
    for ((root, own), _) in roots.iter().zip(&view.volumes).zip(&view.axes).filter(|(_, axis)| axis.is_some()) {
        volume[*root] += own;
    }
    let domains: Vec<f64> = volume.into_iter().filter(|volume| *volume > 0.0).collect();
    let all: f64 = domains.iter().sum();
    let squares: f64 = domains.iter().map(|volume| volume * volume).sum();
    [cell(all / domains.len() as f64), cell(squares / all)]
}
