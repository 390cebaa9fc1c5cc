//! The grid's layout: boxes are classified by size into levels, and each level divides space into columns along one
//! axis.
//!
//! A box belongs to the column of its lowest corner in its level. A level's columns are wider than any box of this and
//! of finer levels, so a box meets boxes of its own level only in the 3 x 3 columns around its own, and a coarser
//! level's boxes only in at most 3 x 3 columns. The columns of a level are folded onto a torus of at most about as many
//! columns as the level has boxes: a sparse scene costs no memory, and two columns with the same index only cost
//! additional tests.

use super::{Aabb, each};
use glam::DVec3;

/// Boxes per work unit of the passes over all boxes: long enough (about 0.1 ms) to hide the cost of dispatching it.
pub(super) const SURVEY_CHUNK: usize = 8192;

/// Sizes are classified by their leading bits: the exponent and this many bits of the mantissa, two classes per octave.
const MANTISSA_BITS: u32 = 1;
const CLASSES: usize = 1 << (11 + MANTISSA_BITS);

/// Classes that share a level: sizes up to about 4 : 1, enough for one shape in all orientations, or one rod before and
/// after it doubles its length. For 100,000 boxes of sizes spread over 1000 : 1 a search takes 1.4 times as long with 3
/// classes and 0.9 times with 7; for those of similar size the three agree. More classes make columns wider for small
/// boxes.
const CLASSES_PER_LEVEL: usize = 5;

/// The largest number of levels; the finest has all smaller boxes. Sixteen levels reach down to 4^-16 = 2e-10 of the
/// largest box.
const MAX_LEVELS: usize = 16;

/// Columns are wider than the widest box by this factor, so that rounding cannot put two touching boxes farther apart
/// than neighbouring columns: a cell index is below 2^40 (see [`MAX_CELLS`]), its rounding error below 2^-11.
const WIDTH_SLACK: f64 = 1.0 + 1.0 / 1024.0;

/// The largest number of columns along one axis, before folding.
const MAX_CELLS: f64 = (1u64 << 40) as f64;

/// The result of one pass over the boxes.
struct Survey {
    low: DVec3,
    high: DVec3,
    extent: DVec3,
    classes: Vec<u32>,
}

/// One level: boxes of similar size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    /// Longest edges along the sweep axis and the two column axes, of this and finer levels.
    pub(super) extent: [f64; 3],
    /// First column in the table of all levels.
    pub(super) first: usize,
    origin: [f64; 2],
    width: [f64; 2],
    /// The number of columns along each axis minus one: 0, or at least 3, so that three neighbours in a row are
    /// distinct columns.
    mask: [i64; 2],
}

/// The levels of a scene, coarsest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Layout {
    /// The sweep axis, then the two axes that index the columns.
    pub(super) axes: [usize; 3],
    pub(super) levels: Vec<Level>,
    /// Columns of all levels together.
    pub(super) columns: usize,
    level_of_class: Vec<u8>,
}

impl Level {
    /// The index, along column axis `axis`, of the cell that contains `value`. Monotone in `value`.
    fn cell(&self, axis: usize, value: f64) -> i64 {
        ((value - self.origin[axis]) / self.width[axis]).floor() as i64
    }

    /// The index of the column of cell `cell`.
    fn column(&self, cell: [i64; 2]) -> usize {
        let across = (cell[0] & self.mask[0]) * (self.mask[1] + 1) + (cell[1] & self.mask[1]);
        self.first + across as usize
    }

    fn columns(&self) -> usize {
        ((self.mask[0] + 1) * (self.mask[1] + 1)) as usize
    }

    /// Calls `visit` once with every neighbour of column `column` in this level, without the column itself.
    pub(super) fn neighbours(&self, column: usize, mut visit: impl FnMut(usize)) {
        let across = (column - self.first) as i64;
        let cell = [across / (self.mask[1] + 1), across & self.mask[1]];
        let step = self.mask.map(|mask| i64::from(mask > 0));
        for i in -step[0]..=step[0] {
            for j in -step[1]..=step[1] {
                if i != 0 || j != 0 {
                    visit(self.column([cell[0] + i, cell[1] + j]));
                }
            }
        }
    }

    /// Calls `visit` with every column of this level whose boxes could touch a box of a finer level with the corners
    /// `min` and `max` (axes in the layout's order), each once.
    ///
    /// A box that touches it has its lowest corner between `min - extent` and `max`; rounding and [`Level::cell`] are
    /// monotone, so its cell is in the range for all coordinates.
    pub(super) fn around(&self, min: [f64; 3], max: [f64; 3], mut visit: impl FnMut(usize)) {
        let low = [self.cell(0, min[1] - self.extent[1]), self.cell(1, min[2] - self.extent[2])];
        let high = [self.cell(0, max[1]), self.cell(1, max[2])];
        let last = [0, 1].map(|axis| high[axis].saturating_sub(low[axis]).clamp(0, self.mask[axis]));
        for i in 0..=last[0] {
            for j in 0..=last[1] {
                visit(self.column([low[0].wrapping_add(i), low[1].wrapping_add(j)]));
            }
        }
    }
}

impl Layout {
    /// Lays out levels for `boxes`.
    pub(super) fn new(boxes: &[Aabb], parallel: bool) -> Self {
        let survey = Survey::new(boxes, parallel);
        let span = (survey.high - survey.low).to_array();
        // The longest axis is swept: a line or a plane of bodies then needs few columns.
        let sweep = (0..3).fold(0, |best, axis| if span[axis] > span[best] { axis } else { best });
        let axes = [sweep, (sweep + 1) % 3, (sweep + 2) % 3];
        let (level_of_class, counts) = group(&survey.classes);
        let mut layout = Layout { axes, levels: Vec::with_capacity(counts.len()), columns: 0, level_of_class };
        let extents = layout.extents(boxes, counts.len(), survey.extent, parallel);
        for (count, extent) in counts.into_iter().zip(extents) {
            let level = Level::new(axes, survey.low, span, extent, count, layout.columns);
            layout.columns += level.columns();
            layout.levels.push(level);
        }
        layout
    }

    /// The level and the column of a proper box.
    pub(super) fn place(&self, aabb: &Aabb) -> usize {
        let level = &self.levels[usize::from(self.level_of_class[class(aabb)])];
        let min = aabb.min.to_array();
        level.column([level.cell(0, min[self.axes[1]]), level.cell(1, min[self.axes[2]])])
    }

    /// The index of the level that column `column` belongs to.
    pub(super) fn level_of_column(&self, column: usize) -> usize {
        self.levels.partition_point(|level| level.first <= column) - 1
    }

    /// The longest edges of every level and all finer ones, from those of all boxes.
    fn extents(&self, boxes: &[Aabb], levels: usize, all: DVec3, parallel: bool) -> Vec<DVec3> {
        if levels <= 1 {
            return vec![all; levels];
        }
        let mut parts = vec![[DVec3::ZERO; MAX_LEVELS]; boxes.len().div_ceil(SURVEY_CHUNK)];
        each(parallel, &mut parts, |k, part| {
            for aabb in chunk(boxes, k).iter().filter(|aabb| aabb.is_proper()) {
                let level = usize::from(self.level_of_class[class(aabb)]);
                part[level] = part[level].max(extent(aabb));
            }
        });
        let mut extents: Vec<DVec3> =
            (0..levels).map(|level| parts.iter().fold(DVec3::ZERO, |longest, part| longest.max(part[level]))).collect();
        for level in (1..levels).rev() {
            extents[level - 1] = extents[level - 1].max(extents[level]);
        }
        extents
    }
}

impl Level {
    fn new(axes: [usize; 3], low: DVec3, span: [f64; 3], extent: DVec3, count: u32, first: usize) -> Self {
        let extent = axes.map(|axis| extent[axis]);
        let across = [axes[1], axes[2]];
        let width = [0, 1].map(|k| (extent[k + 1] * WIDTH_SLACK).max(span[across[k]] / MAX_CELLS));
        // Zero over zero (all corners in one plane) becomes zero, one cell; so does any span over an infinite width.
        let mut folds = [0, 1].map(|k| fold(((span[across[k]] / width[k]) as i64).min(MAX_CELLS as i64)));
        let room = i64::from(count).max(1);
        while folds[0].saturating_mul(folds[1]) > room {
            let longer = usize::from(folds[1] > folds[0]);
            folds[longer] = if folds[longer] > 4 { folds[longer] / 2 } else { 1 };
        }
        Level { extent, first, origin: across.map(|axis| low[axis]), width, mask: folds.map(|count| count - 1) }
    }
}

impl Survey {
    fn new(boxes: &[Aabb], parallel: bool) -> Self {
        let mut parts: Vec<Option<Survey>> = Vec::new();
        parts.resize_with(boxes.len().div_ceil(SURVEY_CHUNK), || None);
        each(parallel, &mut parts, |k, part| {
            let mut survey = Survey::empty();
            for aabb in chunk(boxes, k).iter().filter(|aabb| aabb.is_proper()) {
                survey.low = survey.low.min(aabb.min);
                survey.high = survey.high.max(aabb.max);
                survey.extent = survey.extent.max(extent(aabb));
                survey.classes[class(aabb)] += 1;
            }
            *part = Some(survey);
        });
        parts.into_iter().flatten().reduce(Survey::joined).unwrap_or_else(Survey::empty)
    }

    fn empty() -> Self {
        Survey { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, extent: DVec3::ZERO, classes: vec![0; CLASSES] }
    }

    fn joined(mut self, other: Survey) -> Self {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.extent = self.extent.max(other.extent);
        self.classes.iter_mut().zip(other.classes).for_each(|(sum, count)| *sum += count);
        self
    }
}

/// Assigns size classes to levels, largest first: the level of every class, and the number of boxes of every level. A
/// level begins at the largest remaining size, so that a few giants do not determine the division of the others.
fn group(classes: &[u32]) -> (Vec<u8>, Vec<u32>) {
    let mut level_of_class = vec![0; classes.len()];
    let mut counts: Vec<u32> = Vec::new();
    let mut top = 0;
    for (class, &count) in classes.iter().enumerate().rev().filter(|(_, count)| **count > 0) {
        if counts.is_empty() || (top - class >= CLASSES_PER_LEVEL && counts.len() < MAX_LEVELS) {
            top = class;
            counts.push(0);
        }
        let level = counts.len() - 1;
        level_of_class[class] = level as u8;
        counts[level] += count;
    }
    (level_of_class, counts)
}

/// Columns to fold `last + 1` cells onto: a power of two, one or at least four.
fn fold(last: i64) -> i64 {
    if last <= 0 { 1 } else { (last as u64 + 1).next_power_of_two().max(4) as i64 }
}

fn chunk(boxes: &[Aabb], k: usize) -> &[Aabb] {
    &boxes[k * SURVEY_CHUNK..boxes.len().min((k + 1) * SURVEY_CHUNK)]
}

/// The edges of a proper box, rounded up unless they are zero.
fn extent(aabb: &Aabb) -> DVec3 {
    let up = |edge: f64| if edge > 0.0 { edge.next_up() } else { 0.0 };
    let edges = aabb.max - aabb.min;
    DVec3::new(up(edges.x), up(edges.y), up(edges.z))
}

/// The size class of a proper box: the leading bits of its longest edge.
fn class(aabb: &Aabb) -> usize {
    let longest = (aabb.max - aabb.min).max_element();
    ((longest.to_bits() >> (52 - MANTISSA_BITS)) as usize) & (CLASSES - 1)
}
