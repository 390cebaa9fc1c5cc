//! Density by distance from the mean of the centres, in rings, or in shells in space: centres over the ring's area, and
//! the part of it that bodies fill. A body's area is distributed over the rings that it overlaps. S. Torquato, "Random
//! Heterogeneous Materials", 2002, section 2.1.

use super::bins::Bins;
use super::packing::spread;
use super::{About, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, radius};

const COLUMNS: [Column; 1] =
    [Column { name: "density_bin", what: "width of the rings of the density profile; a length" }];

const PROFILE: [Column; 4] = [
    Column { name: "radius", what: "middle of the ring; a length" },
    Column { name: "filled", what: "part of the ring that bodies fill" },
    Column { name: "number_density", what: "centres over the ring's area; in space over the shell's volume" },
    Column { name: "bodies", what: "centres in the ring" },
];

/// Density by distance.
pub(super) struct Density;

impl Measure for Density {
    fn about(&self) -> &'static About {
        &About {
            name: "density",
            line: "density by distance from the centre",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Curves }),
            plots: &[],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        view.in_open_space()?;
        let bins = Bins::new(view.bin(), radius::outermost(view)).ok_or("the bodies have no extent")?;
        let filled = spread(view, bins.count, |distance| bins.of(distance));
        let mut centres = vec![0_usize; bins.count];
        for bin in (0..view.bodies().len()).filter_map(|i| bins.of(view.distance(i))) {
            centres[bin] += 1;
        }
        let row = |bin: usize| {
            let ring = ring(view, bins, bin);
            let number = centres[bin] as f64;
            vec![cell(bins.middle(bin)), cell(filled[bin] / ring), cell(number / ring), cell(number)]
        };
        let rows = (0..bins.count).map(row).collect();
        Ok(Found { values: vec![cell(bins.width)], rows, remark: None })
    }
}

/// The area of a ring, or the volume of a shell.
pub(super) fn ring(view: &View<'_>, bins: Bins, bin: usize) -> f64 {
    view.ball(bins.lower(bin + 1)) - view.ball(bins.lower(bin))
}
