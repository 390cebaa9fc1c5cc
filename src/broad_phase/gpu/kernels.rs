//! The kernels of the search.

use crate::gpu::{Fragment, Gpu, GpuError, Kernel, Lattice, MOST_CELL, Precision, Source, fragment};

/// Boxes that one body may look at. Mesa before version 23 ends loops after 65,535 rounds.
const MOST_ROUNDS: u32 = 60_000;

/// A level's cells are smaller than its largest boxes could be by this power of two. For 100,000 rods in a plane and as many spheres in
/// space, on lavapipe, the search takes 1.6 and 1.4 times as long with 0, and 1.0 and 8 times with 2.
const FINER: u32 = 1;

pub(super) struct Kernels {
    pub classify: Kernel,
    pub place: Kernel,
    pub gather: Kernel,
    pub find: Kernel,
    pub incoming: Kernel,
    pub adjacency_start: Kernel,
    pub adjacency: Kernel,
}

const GRID: [Fragment; 4] = [
    fragment!("broad_phase/classify.wgsl"),
    fragment!("broad_phase/place.wgsl"),
    fragment!("broad_phase/gather.wgsl"),
    fragment!("broad_phase/find.wgsl"),
];

const LISTS: [Fragment; 3] = [
    fragment!("broad_phase/incoming.wgsl"),
    fragment!("broad_phase/adjacency_start.wgsl"),
    fragment!("broad_phase/adjacency.wgsl"),
];

fn grid_source(fragment: Fragment, precision: Precision, planar: bool, lattice: Lattice) -> Source {
    let source = Source::new(fragment.name, precision)
        .integer("PLANAR", u32::from(planar))
        .integer("FINER", FINER)
        .integer("MOST_ROUNDS", MOST_ROUNDS)
        .text(&format!("const MOST_CELL: i32 = {MOST_CELL};\n"));
    lattice.define(source).include(fragment!("broad_phase/levels.wgsl")).include(fragment)
}

fn list_source(fragment: Fragment) -> Source {
    Source::new(fragment.name, Precision::F32).include(fragment)
}

impl Kernels {
    pub fn new(gpu: &Gpu, precision: Precision, planar: bool, lattice: Lattice) -> Result<Self, GpuError> {
        let grid = |k: usize| Kernel::new(gpu, &grid_source(GRID[k], precision, planar, lattice));
        let list = |k: usize| Kernel::new(gpu, &list_source(LISTS[k]));
        Ok(Kernels {
            classify: grid(0)?,
            place: grid(1)?,
            gather: grid(2)?,
            find: grid(3)?,
            incoming: list(0)?,
            adjacency_start: list(1)?,
            adjacency: list(2)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::validate;

    #[test]
    fn kernels_are_valid() {
        let lattice = Lattice::for_thickness(0.3).unwrap();
        let mut sources: Vec<Source> = LISTS.into_iter().map(list_source).collect();
        for precision in [Precision::F32, Precision::F64] {
            for planar in [false, true] {
                sources.extend(GRID.map(|fragment| grid_source(fragment, precision, planar, lattice)));
            }
        }
        for source in sources {
            validate(&source).unwrap_or_else(|e| panic!("{}: {e}", source.name()));
        }
    }
}
