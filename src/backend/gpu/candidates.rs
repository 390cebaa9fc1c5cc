//! Candidate pairs on the device. A list is kept while the box of every body lies inside the box from which the list
//! was made. The stored values of each pair are carried from one list to the next.

use super::Setup;
use super::branches::{CarryBranches, CarryBranchesArgs, carry_branches};
use super::lists::Lists;
use super::row_set::RowSet;
use super::source::{base, numbers, reporting};
use super::states::{Poses, Shapes};
use super::walls::Surfaces;
use crate::broad_phase::gpu::{Boxes, Search};
use crate::gpu::{Buffer, Gpu, GpuError, LatticePeriods, Made, Recorder, fragment, functions, kernels};
use crate::walls::Walls;
use crate::warm::Warm;

functions! {
    pub(super) Inside = struct InsideArgs<'a> {
        bodies: u64, has_list: bool, start: &'a Poses, boxes: &'a Buffer, stored: &'a Boxes, report: &'a Buffer,
    }
    pub(super) Store = struct StoreArgs<'a> {
        bodies: u64, skin: &'a Buffer, start: &'a Poses, boxes: &'a Buffer, stored: &'a Boxes,
    }
    pub(super) FindOld = struct FindOldArgs<'a> {
        old_bodies: u64, lists: &'a Lists, old: &'a Lists, old_pair: &'a Buffer,
    }
    pub(super) Carry = struct CarryArgs<'a> {
        has_rows: bool, lists: &'a Lists, old: &'a Lists, old_pair: &'a Buffer, old_row_start: &'a Buffer,
        counts: &'a Buffer,
    }
}

/// The number of calls that a list should last: a search costs about as much as a dozen narrow phases.
const FEW_CALLS: u64 = 16;
const MANY_CALLS: u64 = 64;

/// The skin of a first search and its bounds, as fractions of the largest bounding radius. As on the CPU, a skin of
/// more than a tenth of the boxes' edges lengthens the list more than it saves searches, and a skin of less than a
/// five-hundredth has no effect.
const FIRST_SKIN: f64 = 0.04;
const LEAST_SKIN: f64 = 0.004;
const LARGEST_SKIN: f64 = 0.2;

kernels! {
    /// The kernels of lists.
    pub(super) struct CandidateKernels for setup: &Setup {
        inside: Inside = reporting(base(setup, "inside")).include(fragment!("broad_phase/inside.wgsl")),
        store: Store = base(setup, "store").include(fragment!("broad_phase/store.wgsl")),
        find: FindOld = numbers(base(setup, "find")).include(fragment!("constraint/find.wgsl")),
        carry: Carry = base(setup, "carry").include(fragment!("constraint/carry.wgsl")),
        /// With rows by branches.
        carry_branches: Option<CarryBranches> = (setup.branches > 0).then(|| carry_branches(setup)),
    }
}

pub(super) struct Candidates {
    pub lists: Lists,
    old: Lists,
    old_pair: Buffer,
    /// Row counts of pairs for a list that is made before there are rows.
    no_rows: Buffer,
    search: Search,
    pub surfaces: Option<Surfaces>,
    pub stored: Boxes,
    skin_buffer: Buffer,
    skin: Option<f64>,
    calls: u64,
    pub searches: u64,
    /// Whether walls or the cell have moved since the list was made.
    stale: bool,
    /// Whether the next search is the first one after the start, or after the host has set the device's state.
    pub(super) first: bool,
    /// The pairs stored by an earlier run or by the host, until that search.
    pub(super) warm: Vec<Warm>,
    kernels: CandidateKernels,
}

impl Candidates {
    pub fn new(gpu: &Gpu, setup: &Setup, warm: Vec<Warm>) -> Result<Self, GpuError> {
        let real = setup.precision.bytes();
        Ok(Candidates {
            lists: Lists::new(gpu, setup)?,
            old: Lists::new(gpu, setup)?,
            old_pair: Buffer::new(gpu, "old pairs", 4, 0)?,
            no_rows: Buffer::new(gpu, "row counts", 4, 0)?,
            search: Search::among(
                gpu,
                setup.precision,
                setup.planar,
                (setup.lattice, setup.lattice_periods, setup.strain.is_some()),
            )?,
            surfaces: Surfaces::new(gpu, setup)?,
            stored: Boxes {
                cells: Buffer::new(gpu, "stored cells", 16, 0)?,
                remainders: Buffer::new(gpu, "stored remainders", 4 * real, 0)?,
                boxes: Buffer::new(gpu, "stored boxes", 4 * real, 0)?,
            },
            skin_buffer: Buffer::new(gpu, "skin", real, 1)?,
            skin: None,
            calls: 0,
            searches: 0,
            stale: false,
            first: true,
            warm,
            kernels: CandidateKernels::make(gpu, setup)?,
        })
    }

    /// Drops the list. The next search starts from these stored pairs.
    pub fn forget(&mut self, warm: Vec<Warm>) {
        (self.first, self.warm) = (true, warm);
    }

    /// Whether there is a list of this many bodies.
    pub fn is_for(&self, bodies: u64) -> bool {
        !self.first && !self.stale && self.lists.bodies == bodies
    }

    /// Moves walls to these positions. Older lists do not contain all bodies near them.
    pub fn place_walls(
        &mut self,
        gpu: &Gpu,
        setup: &Setup,
        walls: &Walls,
        middle: Option<&Walls>,
    ) -> Result<(), GpuError> {
        if let Some(surfaces) = &mut self.surfaces {
            self.stale |= surfaces.place(gpu, setup, walls, middle)?;
        }
        Ok(())
    }

    /// Sets other periods, for which older lists are not valid.
    pub fn place_cell(&mut self, periods: LatticePeriods) {
        self.search.set_periods(periods);
        self.stale = true;
    }

    /// Counts a check that found the list complete.
    pub fn used(&mut self) {
        self.calls += 1;
    }

    /// Records the check whether the list is complete for these boxes; without a list, only whether the boxes are
    /// finite.
    pub fn inside(
        &mut self,
        gpu: &Gpu,
        record: &mut Recorder<'_>,
        (start, boxes, report): (&Poses, &Buffer, &Buffer),
        bodies: u64,
    ) -> Result<(), GpuError> {
        self.stored.reserve(gpu, bodies)?;
        let (has_list, stored) = (self.is_for(bodies), &self.stored);
        self.kernels.inside.call(record, bodies, InsideArgs { bodies, has_list, start, boxes, stored, report });
        Ok(())
    }

    /// Makes a new list, and copies the stored values of its pairs, with their rows if there are any.
    pub fn search(
        &mut self,
        gpu: &Gpu,
        setup: &Setup,
        (start, shapes, boxes, largest): (&Poses, &Shapes, &Buffer, f64),
        bodies: u64,
        rows: Option<&mut RowSet>,
    ) -> Result<(), GpuError> {
        let skin = self.next_skin(largest);
        self.stale = false;
        self.skin_buffer.write(gpu, 0, &setup.precision.encode([skin]));
        let mut record = gpu.record();
        record.stage("broad phase");
        let (skin, stored) = (&self.skin_buffer, &self.stored);
        self.kernels.store.call(&mut record, bodies, StoreArgs { bodies, skin, start, boxes, stored });
        record.submit()?;
        std::mem::swap(&mut self.lists, &mut self.old);
        let lists = &mut self.lists;
        // The search writes into the buffers of the list before the last one. The last list is needed until its values
        // are copied.
        self.search.exchange([&mut lists.pairs, &mut lists.adjacency_start, &mut lists.adjacency]);
        let found = self.search.run(gpu, &stored.cells, &stored.remainders, &stored.boxes, bodies);
        self.search.exchange([&mut lists.pairs, &mut lists.adjacency_start, &mut lists.adjacency]);
        found?;
        (lists.body_pairs, lists.bodies) = (self.search.count(), bodies);
        lists.pairs_count = lists.body_pairs;
        if let Some(surfaces) = &mut self.surfaces {
            surfaces.extend(gpu, lists, &self.stored, shapes, bodies)?;
        }
        lists.contacts.reserve(gpu, lists.pairs_count)?;
        if setup.branches > 0 {
            lists.remembered.reserve(gpu, lists.pairs_count)?;
        }
        self.searches += 1;
        self.calls = 0;
        if std::mem::replace(&mut self.first, false) {
            return self.recall(gpu, setup);
        }
        self.carry(gpu, rows)
    }

    fn carry(&mut self, gpu: &Gpu, mut rows: Option<&mut RowSet>) -> Result<(), GpuError> {
        let (lists, old, kernels, pairs) = (&self.lists, &self.old, &self.kernels, self.lists.pairs_count);
        let mut record = gpu.record();
        record.stage("broad phase");
        self.old_pair.reserve(gpu, pairs)?;
        self.no_rows.reserve(gpu, pairs)?;
        if let Some(rows) = &mut rows {
            rows.counts.reserve(gpu, pairs)?;
        }
        let (old_bodies, old_pair) = (old.bodies, &self.old_pair);
        kernels.find.call(&mut record, pairs, FindOldArgs { old_bodies, lists, old, old_pair });
        if let Some(carry) = &kernels.carry_branches {
            carry.call(&mut record, pairs, CarryBranchesArgs { lists, old, old_pair });
        }
        let (old_row_start, counts) = match &rows {
            Some(rows) => (&rows.problem.block_start, &rows.counts),
            None => (&old.adjacency_start, &self.no_rows),
        };
        let has_rows = rows.is_some();
        let carried = CarryArgs { has_rows, lists, old, old_pair, old_row_start, counts };
        kernels.carry.call(&mut record, pairs, carried);
        if let Some(rows) = rows {
            rows.carry(gpu, &mut record, pairs, old_pair)?;
        }
        record.submit()
    }

    /// Doubles the skin if lists soon became incomplete, and halves it if they lasted long.
    fn next_skin(&mut self, largest: f64) -> f64 {
        let bounds = (LEAST_SKIN * largest, LARGEST_SKIN * largest);
        let skin = match self.skin {
            None => FIRST_SKIN * largest,
            // The motion of a wall or of the cell does not affect the skin.
            Some(skin) if self.stale => skin,
            Some(skin) if self.calls < FEW_CALLS => 2.0 * skin,
            Some(skin) if self.calls > MANY_CALLS => 0.5 * skin,
            Some(skin) => skin,
        };
        let skin = skin.clamp(bounds.0, bounds.1);
        self.skin = Some(skin);
        skin
    }
}
