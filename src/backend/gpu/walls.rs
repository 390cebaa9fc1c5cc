//! Walls on the device. Pairs of a surface and a place of a body that may come near it follow in the list of candidate
//! pairs, so that they are processed like all other pairs. The second index of such a pair encodes the surface and the
//! place.

use super::Setup;
use super::lists::Lists;
use super::row_inputs::RowInputs;
use super::source::{base, numbers, with_bodies, with_flags};
use super::states::Shapes;
use crate::broad_phase::gpu::Boxes;
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, Scan, fragment, functions, kernels};
use crate::separation::gpu::{add_places_to, add_surfaces_to, surface_numbers};
use crate::walls::{AtSurface, Walls, surface_of};
use crate::warm::Warm;

functions! {
    pub(super) FindPlaces = struct FindPlacesArgs<'a> {
        bodies: u64, count: u64, fill: bool, first: u64, stored: &'a Boxes, shapes: &'a Shapes, surfaces: &'a Buffer,
        list: &'a Buffer, pairs: &'a Buffer,
    }
    pub(super) Adjoin = struct AdjoinArgs<'a> {
        bodies: u64, first: u64, pair_start: &'a Buffer, pair_list: &'a Buffer, place_start: &'a Buffer,
        adjacency_start: &'a Buffer, adjacency: &'a Buffer,
    }
    pub(super) NarrowPlaces = struct NarrowPlacesArgs<'a> {
        first: u64, at_trial: bool, violating: f32, made: RowInputs<'a>, surfaces: &'a Buffer,
    }
    pub(super) Blocks = struct BlocksArgs<'a> {
        lists: &'a Lists, row_start: &'a Buffer, block_start: &'a Buffer,
    }
    pub(super) Turn = struct TurnArgs<'a> { first: u64, made: RowInputs<'a>, surfaces: &'a Buffer }
}

kernels! {
    /// The kernels of walls.
    pub(super) struct WallKernels for setup: &Setup {
        find: FindPlaces = add_surfaces_to(numbers(with_bodies(setup, "places")), &setup.lattice)
            .include(fragment!("walls/find.wgsl")),
        adjoin: Adjoin = base(setup, "adjoin").include(fragment!("walls/adjoin.wgsl")),
        narrow: NarrowPlaces = add_places_to(
            numbers(with_flags(with_bodies(setup, "separations from surfaces"))),
            &setup.lattice,
            &setup.shapes,
        )
        .include(fragment!("walls/narrow.wgsl")),
        blocks: Blocks = numbers(base(setup, "blocks")).include(fragment!("walls/blocks.wgsl")),
        /// With moving walls and midpoint steps.
        turn: Option<Turn> = (setup.midpoint && setup.walls.move_in_time()).then(|| {
            let source = numbers(with_bodies(setup, "normals of surfaces"));
            add_places_to(source, &setup.lattice, &setup.shapes).include(fragment!("walls/turn.wgsl"))
        }),
    }
}

/// The largest number of pairs, including places of bodies at surfaces: entries of lists are twice a pair's number.
const TOO_MANY_PAIRS: u64 = 1 << 31;

/// The surfaces, and the buffers for lists of places at them.
pub(super) struct Surfaces {
    surfaces: Buffer,
    /// The contents of that buffer.
    placed: Vec<f64>,
    /// The surfaces in the middle of a step, if walls move.
    middle: Option<Buffer>,
    count: u64,
    counts: Buffer,
    starts: Buffer,
    /// The lists of bodies with places, exchanged with those without.
    adjacency_start: Buffer,
    adjacency: Buffer,
    /// The starts of the solver's blocks, exchanged with the starts of the pairs' rows.
    block_start: Buffer,
    scan: Scan,
    kernels: WallKernels,
}

/// A stored pair in the device's format; `None` if the scene has no such surface or place.
pub(super) fn device_pair(warm: &Warm, walls: &Walls) -> Option<[u32; 2]> {
    let Some(surface) = surface_of(warm.pair[1]) else { return Some(warm.pair) };
    let there = surface < walls.len() && warm.feature < AtSurface::PLACES;
    there.then(|| [warm.pair[0], AtSurface { surface, place: warm.feature }.number()])
}

/// The surfaces of walls in the device's format.
fn numbers_of(walls: &Walls, setup: &Setup) -> Result<Vec<f64>, GpuError> {
    let mut numbers = Vec::new();
    for surface in walls.surfaces() {
        numbers.extend(surface_numbers(surface, &setup.lattice)?);
    }
    Ok(numbers)
}

impl Surfaces {
    /// The surfaces of a scene; `None` without walls.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        if setup.walls.is_empty() {
            return Ok(None);
        }
        let numbers = numbers_of(&setup.walls, setup)?;
        let words = |label| Buffer::new(gpu, label, 4, 1);
        Ok(Some(Surfaces {
            surfaces: Buffer::reals(gpu, "surfaces", setup.precision, 4, numbers.iter().copied())?,
            middle: None,
            placed: numbers,
            count: setup.walls.len() as u64,
            counts: words("places at surfaces")?,
            starts: words("starts of places")?,
            adjacency_start: words("adjacency starts")?,
            adjacency: words("adjacency")?,
            block_start: words("block starts")?,
            scan: Scan::new(gpu)?,
            kernels: WallKernels::make(gpu, setup)?,
        }))
    }

    /// Moves the surfaces, and returns whether any has moved. `middle` has the walls in the middle of the step.
    pub fn place(&mut self, gpu: &Gpu, setup: &Setup, walls: &Walls, middle: Option<&Walls>) -> Result<bool, GpuError> {
        let middle = middle.map(|walls| numbers_of(walls, setup)).transpose()?;
        let reals = |numbers| Buffer::reals(gpu, "surfaces in the middle", setup.precision, 4, numbers);
        self.middle = middle.map(reals).transpose()?;
        let numbers = numbers_of(walls, setup)?;
        let moved = numbers != self.placed;
        if moved {
            self.surfaces.write(gpu, 0, &setup.precision.encode(numbers.iter().copied()));
            self.placed = numbers;
        }
        Ok(moved)
    }

    /// Appends the places of bodies that may come near a surface to a new list of pairs of bodies, made from the
    /// `stored` boxes.
    pub fn extend(
        &mut self,
        gpu: &Gpu,
        lists: &mut Lists,
        stored: &Boxes,
        shapes: &Shapes,
        bodies: u64,
    ) -> Result<(), GpuError> {
        let first = lists.body_pairs;
        self.counts.reserve(gpu, bodies)?;
        self.starts.reserve(gpu, bodies + 1)?;
        let mut record = gpu.record();
        record.stage("broad phase");
        self.find(&mut record, (stored, shapes, &self.counts, &lists.pairs), bodies, None);
        self.scan.exclusive(&mut record, &self.counts, &self.starts, bodies)?;
        let read = record.read(&[(&self.starts, 4 * bodies..4 * bodies + 4)])?;
        let places = u64::from(bytemuck::pod_read_unaligned::<u32>(&read[0]));
        let pairs = first + places;
        if pairs >= TOO_MANY_PAIRS {
            let (needs, has) = (8 * pairs, 8 * TOO_MANY_PAIRS);
            return Err(GpuError::Limit { what: "pairs".into(), needs, has, adapter: gpu.name().into() });
        }
        let mut record = gpu.record();
        record.stage("broad phase");
        lists.pairs.reserve_and_keep(gpu, &mut record, pairs)?;
        self.find(&mut record, (stored, shapes, &self.starts, &lists.pairs), bodies, Some(first));
        self.adjacency_start.reserve(gpu, bodies + 1)?;
        self.adjacency.reserve(gpu, 2 * first + places)?;
        let adjoined = AdjoinArgs {
            bodies,
            first,
            pair_start: &lists.adjacency_start,
            pair_list: &lists.adjacency,
            place_start: &self.starts,
            adjacency_start: &self.adjacency_start,
            adjacency: &self.adjacency,
        };
        self.kernels.adjoin.call(&mut record, bodies + 1, adjoined);
        record.submit()?;
        std::mem::swap(&mut lists.adjacency_start, &mut self.adjacency_start);
        std::mem::swap(&mut lists.adjacency, &mut self.adjacency);
        lists.pairs_count = pairs;
        Ok(())
    }

    /// Counts the places of every body, or writes them from pair `first` on. One kernel does both, so that the two
    /// results agree exactly.
    fn find(
        &self,
        record: &mut Recorder<'_>,
        (stored, shapes, list, pairs): (&Boxes, &Shapes, &Buffer, &Buffer),
        bodies: u64,
        first: Option<u64>,
    ) {
        let (fill, first, count, surfaces) = (first.is_some(), first.unwrap_or(0), self.count, &self.surfaces);
        let found = FindPlacesArgs { bodies, count, fill, first, stored, shapes, surfaces, list, pairs };
        self.kernels.find.call(record, bodies, found);
    }

    /// Exchanges the starts of the rows of each place with the blocks of a solver, and back.
    pub fn exchange_starts(&mut self, row_start: &mut Buffer) {
        std::mem::swap(&mut self.block_start, row_start);
    }

    /// Makes one block of the rows of all places of a body at a surface, as on the CPU: otherwise rings that lie flat
    /// need 1.7 times as many products.
    pub fn join_places(&mut self, gpu: &Gpu, lists: &Lists, row_start: &Buffer) -> Result<(), GpuError> {
        let pairs = lists.pairs_count;
        self.block_start.reserve(gpu, pairs + 1)?;
        let mut record = gpu.record();
        record.stage("walls");
        let blocks = BlocksArgs { lists, row_start, block_start: &self.block_start };
        self.kernels.blocks.call(&mut record, pairs + 1, blocks);
        record.submit()
    }

    /// Records the separations of the places in a list.
    pub fn separate(&self, record: &mut Recorder<'_>, made: RowInputs<'_>, (at_trial, violating): (bool, f32)) {
        let (first, surfaces) = (made.lists.body_pairs, &self.surfaces);
        let places = made.pairs() - first;
        self.kernels.narrow.call(record, places, NarrowPlacesArgs { first, at_trial, violating, made, surfaces });
        if let (Some(turn), Some(surfaces), false) = (&self.kernels.turn, &self.middle, at_trial) {
            turn.call(record, places, TurnArgs { first, made, surfaces });
        }
    }
}
