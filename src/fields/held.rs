//! Grid cells whose concentration is held.

use super::grid::Grid;
use super::settings::Held;
use crate::separation::Surface;
use glam::DVec3;

/// The held concentration of each cell of a grid, `None` for a free cell; empty without regions.
pub(super) type HeldCells = Vec<Option<f64>>;

/// The cells that regions hold. Along a periodic axis a centre counts where it is in the grid, like that of a body.
pub(super) fn held_cells(grid: &Grid, regions: &[Held], planar: bool) -> HeldCells {
    let regions: Vec<(Vec<Surface>, f64)> =
        regions.iter().map(|held| (held.inside.surfaces(planar), held.value)).collect();
    let of = |cell: usize| {
        let center = DVec3::from(grid.center_of(cell));
        let holds = |(surfaces, _): &&(Vec<Surface>, f64)| surfaces.iter().all(|surface| surface.height(center) >= 0.0);
        regions.iter().rev().find(holds).map(|(_, value)| *value)
    };
    if regions.is_empty() { Vec::new() } else { (0..grid.len()).map(of).collect() }
}

/// Sets cells to what they are held at.
pub(super) fn hold(values: &mut [f64], held: &[Option<f64>]) {
    for (value, held) in values.iter_mut().zip(held) {
        if let Some(held) = held {
            *value = *held;
        }
    }
}
