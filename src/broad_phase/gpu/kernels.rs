//! The kernels of the search.

use super::{Boxes, CROWDED, Search, TOO_MANY};
use crate::gpu::{Buffer, Fragment, Lattice, LatticePeriods, MOST_CELL, Precision, Source};
use crate::gpu::{fragment, functions, kernels};

/// The largest number of boxes that one body may test. Mesa before version 23 ends loops after 65,535 rounds.
const MOST_ROUNDS: u32 = 60_000;

/// The cells of a level are smaller than its largest boxes by this power of two. On lavapipe, 100,000 rods in a plane
/// take 1.3 times as long with 0 and the same time with 2; 100,000 spheres in space take 0.8 times as long with 0 and
/// 1.7 times with 2.
const FINER: u32 = 1;

/// The properties of the space that the kernels depend on.
pub(super) struct Space {
    pub precision: Precision,
    pub planar: bool,
    pub lattice: Lattice,
    /// In periodic space.
    pub periods: Option<LatticePeriods>,
    /// Whether the periods change between searches.
    pub changing: bool,
}

functions! {
    pub(super) Wrap = struct WrapArgs<'a> {
        bodies: u64, periods: LatticePeriods, cells: &'a Buffer, remainders: &'a Buffer, wrapped_cells: &'a Buffer,
        wrapped_remainders: &'a Buffer,
    }
    pub(super) Classify = struct ClassifyArgs<'a> {
        bodies: u64, cells: &'a Buffer, remainders: &'a Buffer, boxes: &'a Buffer, search: &'a Search,
    }
    pub(super) Place = struct PlaceArgs<'a> { bodies: u64, mask: u64, cells: &'a Buffer, search: &'a Search }
    pub(super) Gather = struct GatherArgs<'a> {
        bodies: u64, cells: &'a Buffer, remainders: &'a Buffer, boxes: &'a Buffer, sorted: &'a Boxes,
        search: &'a Search,
    }
    pub(super) Find = struct FindArgs<'a> {
        bodies: u64, mask: u64, fill: bool, large: u64, periods: LatticePeriods, sorted: &'a Boxes, list: &'a Buffer,
        pairs: &'a Buffer, search: &'a Search,
    }
    pub(super) Ends = struct EndsArgs<'a> { count: u64, side: u32, search: &'a Search }
    pub(super) Arrange = struct ArrangeArgs<'a> { count: u64, search: &'a Search }
    pub(super) Starts = struct StartsArgs<'a> { bodies: u64, pairs: u64, search: &'a Search }
    pub(super) Incoming = struct IncomingArgs<'a> { count: u64, search: &'a Search }
    pub(super) AdjacencyStart = struct AdjacencyStartArgs<'a> { bodies: u64, pairs: u64, search: &'a Search }
    pub(super) Adjacency = struct AdjacencyArgs<'a> { count: u64, search: &'a Search }
}

kernels! {
    /// The kernels of the search.
    pub(super) struct Kernels for space: &Space {
        /// In periodic space.
        wrap: Option<Wrap> = space.periods.as_ref().map(|periods| match periods.is_sheared() {
            false => space.periodic(periods, fragment!("broad_phase/wrap.wgsl")),
            true => space.periodic(periods, fragment!("broad_phase/wrap_sheared.wgsl")),
        }),
        classify: Classify = space.open(fragment!("broad_phase/classify.wgsl")),
        place: Place = space.open(fragment!("broad_phase/place.wgsl")),
        gather: Gather = space.open(fragment!("broad_phase/gather.wgsl")),
        find: Find = match &space.periods {
            Some(periods) if periods.is_sheared() => space.around_sheared(periods),
            Some(periods) => space.periodic(periods, fragment!("broad_phase/find_periodic.wgsl")),
            None => space.open(fragment!("broad_phase/find.wgsl")),
        },
        ends: Ends = list(fragment!("broad_phase/ends.wgsl")),
        arrange: Arrange = list(fragment!("broad_phase/arrange.wgsl")),
        starts: Starts = list(fragment!("broad_phase/starts.wgsl")),
        incoming: Incoming = list(fragment!("broad_phase/incoming.wgsl")),
        adjacency_start: AdjacencyStart = list(fragment!("broad_phase/adjacency_start.wgsl")),
        adjacency: Adjacency = list(fragment!("broad_phase/adjacency.wgsl")),
    }
}

impl Space {
    /// A kernel of the grid in open space.
    fn open(&self, fragment: Fragment) -> Source {
        levels(self.lattice.define(self.constants(fragment)), fragment)
    }

    /// A kernel of the grid in periodic space.
    fn periodic(&self, periods: &LatticePeriods, fragment: Fragment) -> Source {
        let source = levels(periods.define(self.constants(fragment)), fragment);
        if self.changing { LatticePeriods::changing(source) } else { source }
    }

    /// The search of a sheared cell, where the offset changes.
    fn around_sheared(&self, periods: &LatticePeriods) -> Source {
        let fragment = fragment!("broad_phase/find_periodic.wgsl");
        let source = levels(periods.define(self.constants(fragment)), fragment)
            .mapped(|text| text.replace("let look = around(", "let look = around_sheared("))
            .include(fragment!("broad_phase/around_sheared.wgsl"));
        LatticePeriods::changing(source)
    }

    fn constants(&self, fragment: Fragment) -> Source {
        Source::new(fragment.name, self.precision)
            .constants("faults of the search", [("CROWDED", CROWDED), ("TOO_MANY", TOO_MANY)])
            .integer("PLANAR", u32::from(self.planar))
            .integer("FINER", FINER)
            .integer("MOST_ROUNDS", MOST_ROUNDS)
            .text(&format!("const MOST_CELL: i32 = {MOST_CELL};\n"))
    }
}

fn levels(source: Source, fragment: Fragment) -> Source {
    source.include(fragment!("broad_phase/levels.wgsl")).include(fragment)
}

/// A kernel of lists, which does not depend on the scene.
fn list(fragment: Fragment) -> Source {
    Source::new(fragment.name, Precision::F32).include(fragment)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Made, validate};
    use crate::periodic::{Axis, Periods, Tilt};

    #[test]
    fn kernels_are_valid() {
        let lattice = Lattice::for_thickness(0.3).unwrap();
        let periods = LatticePeriods::new(lattice, [Some(3.1), None, None]).unwrap();
        for precision in [Precision::F32, Precision::F64] {
            let space = Periods::new([Some(3.1), Some(2.9), None]);
            let tilt = Tilt { direction: Axis::X, gradient: Axis::Y, offset: -0.7 };
            let sheared = LatticePeriods::of(lattice, space.tilted(tilt).numbers()).unwrap();
            let all = [(false, None), (true, None), (false, Some(periods)), (true, Some(periods))];
            for (planar, periods) in all.into_iter().chain([(false, Some(sheared)), (true, Some(sheared))]) {
                let is_sheared = periods.is_some_and(|periods| periods.is_sheared());
                for changing in [is_sheared, periods.is_some()] {
                    let sources = Kernels::sources(&Space { precision, planar, lattice, periods, changing });
                    assert_eq!(sources.len(), 10 + usize::from(periods.is_some()));
                    for source in sources {
                        validate(&source).unwrap_or_else(|e| panic!("{}: {e}", source.name()));
                    }
                }
            }
        }
    }
}
