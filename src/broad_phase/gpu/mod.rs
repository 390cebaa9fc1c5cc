//! The search for touching boxes on the device: a hashed grid of several levels, sorted by cell.
//!
//! Boxes are classified by size into levels; larger boxes have coarser cells. Each pair is found once: within a level
//! by the box whose cell comes first, between levels by the smaller box. So a large box does not make the search of its
//! body long. The cells to search are computed in integers, from positions on the integer lattice, and so are exact at
//! any distance from the origin. Cells are hashed into a table with one column per body, and boxes are sorted by
//! column.
//!
//! In periodic space, the search uses positions that are wrapped into one cell (`shaders/broad_phase/wrap.wgsl`), and
//! the grid cells that a body searches wrap around (`find_periodic.wgsl`). Each grid cell is searched once, however far
//! the box reaches. So a pair is found once, even if its boxes touch through several images. The test of a pair uses
//! the nearest image, which is the nearest along every axis.
//!
//! The body that finds a pair, and the moment in its search, depend on boxes and cells. The returned list is sorted by
//! the bodies of the pairs, so that its order does not depend on the search. Rows that are made from two lists with the
//! same near pairs have the same order. So a resumed run, which searches at other steps, computes the same bits.
//!
//! Sorted cells: S. Green, "Particle simulation using CUDA", 2010. Levels: as in [`Grid`](super::Grid).

mod kernels;

use crate::gpu::{Buffer, Gpu, GpuError, Lattice, LatticePeriods, Made, Precision, Recorder, Scan, Sort, arrays};
use kernels::{AdjacencyArgs, AdjacencyStartArgs, ArrangeArgs, ClassifyArgs, EndsArgs, FindArgs, GatherArgs};
use kernels::{IncomingArgs, Kernels, PlaceArgs, Space, StartsArgs, WrapArgs};

/// The smallest number of columns of the table: more than the cells of any row that a body searches.
const LEAST_COLUMNS: u64 = 64;

/// The largest number of bodies: their indices share a word with their levels.
const MOST_BODIES: u64 = 1 << 27;

/// Words of the survey of a scene: four, plus three for each of 32 classes.
const SURVEY_WORDS: u64 = 4 + 3 * 32;

/// Faults of the search.
const CROWDED: u32 = 1;
const TOO_MANY: u32 = 2;

/// The number of pairs from which a sum may have overflowed.
const TOO_MANY_PAIRS: u64 = 1 << 31;

/// Boxes at positions on the lattice.
pub struct Boxes {
    /// Lattice cells.
    pub cells: Buffer,
    /// The remainders of the positions.
    pub remainders: Buffer,
    /// Half extents, and the radius of a ball that contains the box at every orientation.
    pub boxes: Buffer,
}

arrays! { Boxes { cells, remainders, boxes } }

impl Boxes {
    /// Reserves memory for this many bodies; the contents are lost.
    pub(crate) fn reserve(&mut self, gpu: &Gpu, bodies: u64) -> Result<(), GpuError> {
        for buffer in [&mut self.cells, &mut self.remainders, &mut self.boxes] {
            buffer.reserve(gpu, bodies)?;
        }
        Ok(())
    }
}

/// The search, and the pairs that it found last.
pub struct Search {
    kernels: Kernels,
    periods: LatticePeriods,
    sort: Sort,
    scan: Scan,
    survey: Buffer,
    crowds: Buffer,
    classes: Buffer,
    /// Positions wrapped into one cell of periodic space.
    wrapped: Option<[Buffer; 2]>,
    /// The column of every body; later the body that was found in every pair.
    keys: Buffer,
    /// Bodies with their levels; later the entry of every pair in the list of the found body.
    values: Buffer,
    /// The number of bodies in every column; later the number of pairs that every body found; later the offset to add
    /// to those.
    counts: Buffer,
    /// The start of every column.
    columns: Buffer,
    sorted: Boxes,
    first: Buffer,
    /// Pairs in the order in which they were found.
    found: Buffer,
    pairs: Buffer,
    count: u64,
    adjacency_start: Buffer,
    adjacency: Buffer,
}

// The search's buffers, by their names in each kernel.
arrays! { Search {
    survey, crowds, classes, columns: keys, keys, members: values, places: values, entries: values, counts,
    own: counts, starts: columns, first, found, pairs, adjacency_start, adjacency,
} }

impl Search {
    /// Compiles the kernels. In the plane (`planar`) only x and y count.
    ///
    /// # Errors
    /// [`GpuError::Kernel`], [`GpuError::NoF64`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu, precision: Precision, planar: bool, lattice: Lattice) -> Result<Self, GpuError> {
        Search::in_space(gpu, precision, planar, lattice, ([None; 3], false))
    }

    /// The same in space with these periods, which may be `changing` ([`Search::set_periods`]): pairs are those that
    /// touch through any image. Positions need not be wrapped.
    ///
    /// # Errors
    /// As [`Search::new`], and [`GpuError::Unsupported`] for periods that the lattice cannot hold.
    pub fn in_space(
        gpu: &Gpu,
        precision: Precision,
        planar: bool,
        lattice: Lattice,
        (periods, changing): ([Option<f64>; 3], bool),
    ) -> Result<Self, GpuError> {
        Search::among(gpu, precision, planar, (lattice, LatticePeriods::new(lattice, periods)?, changing))
    }

    /// The same with the periods on the lattice, also of a sheared cell, whose offset changes.
    ///
    /// # Errors
    /// As [`Search::new`].
    pub fn among(
        gpu: &Gpu,
        precision: Precision,
        planar: bool,
        (lattice, periods, changing): (Lattice, LatticePeriods, bool),
    ) -> Result<Self, GpuError> {
        let changing = changing || periods.is_sheared();
        let words = |label| Buffer::new(gpu, label, 4, 1);
        let reals = |label| Buffer::new(gpu, label, 4 * precision.bytes(), 1);
        let is_periodic = !periods.is_none();
        let space = Space { precision, planar, lattice, periods: is_periodic.then_some(periods), changing };
        Ok(Search {
            periods,
            kernels: Kernels::make(gpu, &space)?,
            sort: Sort::new(gpu)?,
            scan: Scan::new(gpu)?,
            survey: Buffer::new(gpu, "search-survey", 4, SURVEY_WORDS)?,
            crowds: Buffer::new(gpu, "search-crowds", 4, 2)?,
            classes: words("search-classes")?,
            wrapped: match space.periods {
                Some(_) => {
                    Some([Buffer::new(gpu, "search-wrapped-cells", 16, 1)?, reals("search-wrapped-remainders")?])
                }
                None => None,
            },
            keys: words("search-keys")?,
            values: words("search-values")?,
            counts: words("search-counts")?,
            columns: words("search-columns")?,
            sorted: Boxes {
                cells: Buffer::new(gpu, "search-sorted-cells", 16, 1)?,
                remainders: reals("search-sorted-remainders")?,
                boxes: reals("search-sorted-boxes")?,
            },
            first: words("search-first")?,
            found: Buffer::new(gpu, "search-found", 8, 1)?,
            pairs: Buffer::new(gpu, "pairs", 8, 1)?,
            count: 0,
            adjacency_start: words("adjacency-start")?,
            adjacency: words("adjacency")?,
        })
    }

    /// Finds every pair whose boxes touch, and perhaps some that are separated by a few rounding errors.
    ///
    /// `cell` and `remainder` are the bodies' positions on the lattice (four numbers each, the last unused). `boxes`
    /// contains half extents, with margins, and the radius of a ball about the body's position that contains the box at
    /// every orientation. A box with a negative or not finite extent touches nothing. The pairs and their order depend
    /// only on the boxes.
    ///
    /// # Errors
    /// [`GpuError::Limit`] and [`GpuError::OutOfMemory`] if the pairs do not fit, [`GpuError::Unsupported`] if a body
    /// is beyond the lattice or has 60,000 boxes near it, and faults of the device. After an error there are no pairs.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        cell: &Buffer,
        remainder: &Buffer,
        boxes: &Buffer,
        bodies: u64,
    ) -> Result<(), GpuError> {
        self.count = 0;
        if bodies > MOST_BODIES {
            return Err(GpuError::Unsupported { what: format!("room for {bodies} bodies (at most {MOST_BODIES})") });
        }
        let columns = bodies.next_power_of_two().max(LEAST_COLUMNS);
        self.reserve(gpu, bodies, columns)?;
        let mut record = gpu.record();
        record.stage("search: order");
        self.order(&mut record, [cell, remainder, boxes], bodies, columns)?;
        record.stage("search: find");
        self.find(&mut record, bodies, columns, false);
        self.scan.exclusive(&mut record, &self.counts, &self.first, bodies)?;
        let count = self.total(gpu, &mut record, bodies)?;
        self.found.reserve(gpu, count)?;
        self.pairs.reserve(gpu, count)?;
        self.adjacency.reserve(gpu, 2 * count)?;
        self.keys.reserve(gpu, count)?;
        self.values.reserve(gpu, count)?;
        if count > 0 {
            self.find(&mut record, bodies, columns, true);
        }
        record.stage("search: lists");
        self.arrange(&mut record, bodies, count)?;
        self.connect(&mut record, bodies, count)?;
        record.submit()?;
        self.count = count;
        Ok(())
    }

    /// Sets other periods, for searches with changing periods.
    pub fn set_periods(&mut self, periods: LatticePeriods) {
        self.periods = periods;
    }

    /// Exchanges the pairs, the starts of the bodies' lists and the lists with other buffers, so that both can be kept.
    pub(crate) fn exchange(&mut self, [pairs, start, adjacency]: [&mut Buffer; 3]) {
        std::mem::swap(&mut self.pairs, pairs);
        std::mem::swap(&mut self.adjacency_start, start);
        std::mem::swap(&mut self.adjacency, adjacency);
    }

    /// The pairs `[a, b]` with `a < b`: each once, in ascending order.
    pub fn pairs(&self) -> &Buffer {
        &self.pairs
    }

    /// The number of pairs.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The start of every body's list in [`Search::adjacency`], and the end of the last one.
    pub fn adjacency_start(&self) -> &Buffer {
        &self.adjacency_start
    }

    /// The pairs of every body, in ascending order: twice the pair's number, plus one if the body is the second of the
    /// pair.
    pub fn adjacency(&self) -> &Buffer {
        &self.adjacency
    }

    fn reserve(&mut self, gpu: &Gpu, bodies: u64, columns: u64) -> Result<(), GpuError> {
        self.sorted.reserve(gpu, bodies)?;
        let of_bodies = [&mut self.classes, &mut self.keys, &mut self.values].into_iter();
        for buffer in of_bodies.chain(self.wrapped.iter_mut().flatten()) {
            buffer.reserve(gpu, bodies)?;
        }
        self.counts.reserve(gpu, columns)?;
        self.columns.reserve(gpu, columns + 1)?;
        self.first.reserve(gpu, bodies + 1)?;
        self.adjacency_start.reserve(gpu, bodies + 1)?;
        Ok(())
    }

    /// Sorts the boxes by column.
    fn order(
        &mut self,
        record: &mut Recorder<'_>,
        [mut cells, mut remainders, boxes]: [&Buffer; 3],
        bodies: u64,
        columns: u64,
    ) -> Result<(), GpuError> {
        let (kernels, periods) = (&self.kernels, self.periods);
        record.clear(&self.survey, 0..4 * SURVEY_WORDS);
        record.clear(&self.crowds, 0..8);
        record.clear(&self.counts, 0..4 * columns);
        if let (Some(wrap), Some([wrapped_cells, wrapped_remainders])) = (&kernels.wrap, &self.wrapped) {
            let wrapped = WrapArgs { bodies, periods, cells, remainders, wrapped_cells, wrapped_remainders };
            wrap.call(record, bodies, wrapped);
            (cells, remainders) = (wrapped_cells, wrapped_remainders);
        }
        let (mask, search) = (columns - 1, &*self);
        kernels.classify.call(record, bodies, ClassifyArgs { bodies, cells, remainders, boxes, search });
        kernels.place.call(record, bodies, PlaceArgs { bodies, mask, cells, search });
        self.scan.exclusive(record, &self.counts, &self.columns, columns)?;
        self.sort.by_key(record, &mut self.keys, &mut self.values, bodies, columns.trailing_zeros())?;
        let (sorted, search) = (&self.sorted, &*self);
        self.kernels.gather.call(record, bodies, GatherArgs { bodies, cells, remainders, boxes, sorted, search });
        Ok(())
    }

    /// Counts the pairs that every body finds, or writes them. One kernel does both, so that the two results agree
    /// exactly.
    fn find(&self, record: &mut Recorder<'_>, bodies: u64, columns: u64, fill: bool) {
        let arguments = FindArgs {
            bodies,
            mask: columns - 1,
            fill,
            large: TOO_MANY_PAIRS / bodies.max(1),
            periods: self.periods,
            sorted: &self.sorted,
            list: if fill { &self.first } else { &self.counts },
            pairs: &self.found,
            search: self,
        };
        self.kernels.find.call(record, bodies, arguments);
    }

    /// Waits for the number of pairs.
    fn total(&self, gpu: &Gpu, record: &mut Recorder<'_>, bodies: u64) -> Result<u64, GpuError> {
        let read =
            record.read(&[(&self.survey, 4..8), (&self.crowds, 0..4), (&self.first, 4 * bodies..4 * bodies + 4)])?;
        let word = |k: usize| read[k].as_chunks().0.first().map_or(0, |bytes| u32::from_le_bytes(*bytes));
        let (far, faults, count) = (word(0), word(1), word(2));
        let unsupported = |what: &str| Err(GpuError::Unsupported { what: what.into() });
        if far != 0 {
            return unsupported("room for a body so far from the origin");
        }
        if faults & CROWDED != 0 {
            return unsupported("search where 60,000 boxes lie about one");
        }
        if faults & TOO_MANY != 0 {
            let (needs, has) = (8 * TOO_MANY_PAIRS, 8 * gpu.most_elements(8));
            return Err(GpuError::Limit { what: "pairs".into(), needs, has, adapter: gpu.name().into() });
        }
        Ok(u64::from(count))
    }

    /// Sorts the pairs by their first bodies, then by the second.
    fn arrange(&mut self, record: &mut Recorder<'_>, bodies: u64, count: u64) -> Result<(), GpuError> {
        let bits = bodies.next_power_of_two().trailing_zeros();
        for side in [1, 0] {
            self.kernels.ends.call(record, count, EndsArgs { count, side, search: self });
            self.sort.by_key(record, &mut self.keys, &mut self.values, count, bits)?;
        }
        let search = &*self;
        self.kernels.arrange.call(record, count, ArrangeArgs { count, search });
        self.kernels.starts.call(record, bodies + 1, StartsArgs { bodies, pairs: count, search });
        Ok(())
    }

    /// Makes the list of pairs of every body.
    fn connect(&mut self, record: &mut Recorder<'_>, bodies: u64, count: u64) -> Result<(), GpuError> {
        self.kernels.incoming.call(record, count, IncomingArgs { count, search: self });
        let bits = bodies.next_power_of_two().trailing_zeros();
        self.sort.by_key(record, &mut self.keys, &mut self.values, count, bits)?;
        let search = &*self;
        self.kernels.adjacency_start.call(record, bodies + 1, AdjacencyStartArgs { bodies, pairs: count, search });
        self.kernels.adjacency.call(record, count, AdjacencyArgs { count, search });
        Ok(())
    }
}
