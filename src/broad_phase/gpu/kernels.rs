//! The kernels of the search.

use crate::gpu::{Fragment, Gpu, GpuError, Kernel, Lattice, LatticePeriods, MOST_CELL, Precision, Source, fragment};

/// Boxes that one body may look at. Mesa before version 23 ends loops after 65,535 rounds.
const MOST_ROUNDS: u32 = 60_000;

/// A level's cells are smaller than its largest boxes could be by this power of two. On lavapipe, 100,000 rods in a
/// plane take 1.3 times as long with 0 and the same with 2, 100,000 spheres in space 0.8 times as long with 0 and 1.7
/// times with 2.
const FINER: u32 = 1;

pub(super) struct Kernels {
    /// Where space is periodic.
    pub wrap: Option<Kernel>,
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

const PERIODIC: [Fragment; 2] = [fragment!("broad_phase/wrap.wgsl"), fragment!("broad_phase/find_periodic.wgsl")];

const LISTS: [Fragment; 3] = [
    fragment!("broad_phase/incoming.wgsl"),
    fragment!("broad_phase/adjacency_start.wgsl"),
    fragment!("broad_phase/adjacency.wgsl"),
];

fn grid_source(fragment: Fragment, precision: Precision, planar: bool, lattice: Lattice) -> Source {
    levels(lattice.define(constants(fragment, precision, planar)), fragment)
}

fn periodic_source(fragment: Fragment, precision: Precision, planar: bool, periods: &LatticePeriods) -> Source {
    levels(periods.define(constants(fragment, precision, planar)), fragment)
}

fn levels(source: Source, fragment: Fragment) -> Source {
    source.include(fragment!("broad_phase/levels.wgsl")).include(fragment)
}

fn constants(fragment: Fragment, precision: Precision, planar: bool) -> Source {
    Source::new(fragment.name, precision)
        .integer("PLANAR", u32::from(planar))
        .integer("FINER", FINER)
        .integer("MOST_ROUNDS", MOST_ROUNDS)
        .text(&format!("const MOST_CELL: i32 = {MOST_CELL};\n"))
}

fn list_source(fragment: Fragment) -> Source {
    Source::new(fragment.name, Precision::F32).include(fragment)
}

impl Kernels {
    pub fn new(
        gpu: &Gpu,
        precision: Precision,
        planar: bool,
        lattice: Lattice,
        periods: Option<&LatticePeriods>,
    ) -> Result<Self, GpuError> {
        let grid = |k: usize| Kernel::new(gpu, &grid_source(GRID[k], precision, planar, lattice));
        let periodic = |k: usize| match periods {
            Some(periods) => Ok(Some(Kernel::new(gpu, &periodic_source(PERIODIC[k], precision, planar, periods))?)),
            None => Ok(None),
        };
        let list = |k: usize| Kernel::new(gpu, &list_source(LISTS[k]));
        Ok(Kernels {
            wrap: periodic(0)?,
            classify: grid(0)?,
            place: grid(1)?,
            gather: grid(2)?,
            find: match periodic(1)? {
                Some(find) => find,
                None => grid(3)?,
            },
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
                let periods = LatticePeriods::new(lattice, [Some(3.1), None, None]).unwrap();
                sources.extend(PERIODIC.map(|fragment| periodic_source(fragment, precision, planar, &periods)));
            }
        }
        for source in sources {
            validate(&source).unwrap_or_else(|e| panic!("{}: {e}", source.name()));
        }
    }
}
