//! The search for touching boxes: a grid of columns, several levels of them, swept along the third axis.
//!
//! Boxes are distributed to columns (see [`super::levels`]) and sorted along the sweep axis inside each. Every box is
//! tested against the boxes of the neighbouring columns that begin, along the sweep axis, within its extent, and
//! against boxes of coarser levels in at most nine columns. Each pair is found once: within a level by the box that
//! begins first, between levels by the smaller box. For bodies of similar size the cost per body is constant, except
//! for the sort inside columns.
//!
//! Sweep and prune: D. Baraff, "Dynamic simulation of non-penetrating rigid bodies", 1992. Levels of grids: B. Mirtich,
//! "Impulse-based dynamic simulation of rigid body systems", 1996.

use super::levels::{Layout, Level, SURVEY_CHUNK};
use super::pair_order::{order, pack};
use super::{Aabb, BroadPhase, each};
use rayon::prelude::*;

/// Below this many boxes one thread does all: a search then takes about a millisecond or less. At 10,000 boxes two
/// threads took two thirds of the time of one.
const PARALLEL_MIN: usize = 4096;

/// Boxes per work unit of the sweep, about 0.3 ms: short enough to distribute a scene of [`PARALLEL_MIN`] boxes.
const SWEEP_CHUNK: usize = 2048;

/// The column of a box that is not proper.
const NOWHERE: u32 = u32::MAX;

/// A box in column order, its axes in the layout's order.
#[derive(Clone, Copy, Debug)]
struct Entry {
    min: [f64; 3],
    max: [f64; 3],
    body: u32,
    column: u32,
}

impl Entry {
    /// Whether the boxes overlap across the sweep axis.
    fn meets_across(&self, other: &Entry) -> bool {
        (self.min[1] <= other.max[1])
            & (other.min[1] <= self.max[1])
            & (self.min[2] <= other.max[2])
            & (other.min[2] <= self.max[2])
    }
}

/// The multi-level grid. It has no state except memory for reuse between searches.
///
/// ```
/// use glam::DVec3;
/// use relcp::internals::broad_phase::{Aabb, BroadPhase, Grid};
///
/// let boxes: Vec<Aabb> = (0..100).map(|k| Aabb::from_centre(DVec3::X * k as f64, DVec3::splat(0.6))).collect();
/// let mut pairs = Vec::new();
/// Grid::default().pairs(&boxes, &mut pairs);
/// assert_eq!(pairs.len(), 99);
/// assert_eq!(pairs[1], [1, 2]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Grid {
    layout: Layout,
    /// The column of every box.
    column: Vec<u32>,
    /// The offset of every column's boxes in `sorted`, and the end.
    start: Vec<u32>,
    /// Lower end along the sweep axis and index of every box, by column.
    order: Vec<(f64, u32)>,
    sorted: Vec<Entry>,
    found: Vec<Vec<u64>>,
}

impl BroadPhase for Grid {
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        let parallel = boxes.len() >= PARALLEL_MIN;
        self.layout = Layout::new(boxes, parallel);
        self.place(boxes, parallel);
        self.share_out(boxes);
        self.sort_columns(parallel);
        self.gather(boxes, parallel);
        self.sweep(parallel);
        order(&self.found, boxes.len(), parallel, pairs);
    }
}

impl Grid {
    /// Finds every box's column.
    fn place(&mut self, boxes: &[Aabb], parallel: bool) {
        self.column.resize(boxes.len(), NOWHERE);
        let layout = &self.layout;
        let mut parts: Vec<&mut [u32]> = self.column.chunks_mut(SURVEY_CHUNK).collect();
        each(parallel, &mut parts, |k, part| {
            for (column, aabb) in part.iter_mut().zip(&boxes[k * SURVEY_CHUNK..]) {
                *column = if aabb.is_proper() { layout.place(aabb) as u32 } else { NOWHERE };
            }
        });
    }

    /// Counting sort of the boxes by column.
    fn share_out(&mut self, boxes: &[Aabb]) {
        let Grid { layout, column, start, order, .. } = self;
        start.clear();
        start.resize(layout.columns + 1, 0);
        for &column in column.iter().filter(|column| **column != NOWHERE) {
            start[column as usize] += 1;
        }
        let mut sum = 0;
        for count in start.iter_mut() {
            sum += *count;
            *count = sum;
        }
        order.resize(sum as usize, (0.0, 0));
        // From the back, every column's end becomes its start.
        for (body, &column) in column.iter().enumerate().rev().filter(|(_, column)| **column != NOWHERE) {
            let next = &mut start[column as usize];
            *next -= 1;
            order[*next as usize] = (boxes[body].min[layout.axes[0]], body as u32);
        }
    }

    /// Sorts every column along the sweep axis.
    fn sort_columns(&mut self, parallel: bool) {
        let mut parts = Vec::new();
        let mut rest = self.order.as_mut_slice();
        let (mut first, mut begin) = (0, 0);
        for (column, &end) in self.start.iter().enumerate().skip(1) {
            let length = end as usize - begin;
            if length >= SWEEP_CHUNK || column + 1 == self.start.len() {
                let (head, tail) = rest.split_at_mut(length);
                parts.push((&self.start[first..=column], head));
                (rest, first, begin) = (tail, column, end as usize);
            }
        }
        let ascending = |one: &(f64, u32), other: &(f64, u32)| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1));
        each(parallel, &mut parts, |_, (start, part)| {
            let base = start[0];
            for ends in start.windows(2) {
                let column = &mut part[(ends[0] - base) as usize..(ends[1] - base) as usize];
                if parallel && column.len() >= PARALLEL_MIN {
                    column.par_sort_unstable_by(ascending);
                } else {
                    column.sort_unstable_by(ascending);
                }
            }
        });
    }

    /// Copies the boxes into column order.
    fn gather(&mut self, boxes: &[Aabb], parallel: bool) {
        let blank = Entry { min: [0.0; 3], max: [0.0; 3], body: 0, column: 0 };
        self.sorted.resize(self.order.len(), blank);
        let (layout, order, column) = (&self.layout, &self.order, &self.column);
        let mut parts: Vec<&mut [Entry]> = self.sorted.chunks_mut(SURVEY_CHUNK).collect();
        each(parallel, &mut parts, |k, part| {
            for (entry, &(_, body)) in part.iter_mut().zip(&order[k * SURVEY_CHUNK..]) {
                let (min, max) = (boxes[body as usize].min.to_array(), boxes[body as usize].max.to_array());
                let column = column[body as usize];
                *entry = Entry { min: layout.axes.map(|k| min[k]), max: layout.axes.map(|k| max[k]), body, column };
            }
        });
    }

    /// Finds all pairs, one list per work unit.
    fn sweep(&mut self, parallel: bool) {
        let mut found = std::mem::take(&mut self.found);
        found.resize_with(self.sorted.len().div_ceil(SWEEP_CHUNK), Vec::new);
        let grid = &*self;
        each(parallel, &mut found, |k, found| {
            found.clear();
            let end = grid.sorted.len().min((k + 1) * SWEEP_CHUNK);
            let mut begin = k * SWEEP_CHUNK;
            while begin < end {
                let column = grid.sorted[begin].column as usize;
                let stop = end.min(grid.start[column + 1] as usize);
                grid.sweep_run(begin, stop, column, found);
                begin = stop;
            }
        });
        self.found = found;
    }

    /// The pairs that the boxes `begin..stop` of column `column` must find.
    fn sweep_run(&self, begin: usize, stop: usize, column: usize, found: &mut Vec<u64>) {
        let (coarser, level) = self.layout.levels.split_at(self.layout.level_of_column(column));
        let run = &self.sorted[begin..stop];
        let rest = &self.sorted[begin..self.start[column + 1] as usize];
        for (k, entry) in run.iter().enumerate() {
            scan(entry, &rest[k + 1..], found);
        }
        level[0].neighbours(column, |other| {
            let boxes = self.boxes_of(other);
            if !boxes.is_empty() {
                sweep_columns(run, boxes, other > column, found);
            }
        });
        for level in coarser {
            for entry in run {
                self.search_coarser(entry, level, found);
            }
        }
    }

    /// The pairs of one box with boxes of a coarser level.
    fn search_coarser(&self, entry: &Entry, level: &Level, found: &mut Vec<u64>) {
        let lowest = entry.min[0] - level.extent[0];
        level.around(entry.min, entry.max, |column| {
            let boxes = self.boxes_of(column);
            let begin = boxes.partition_point(|other| other.min[0] < lowest);
            for other in boxes[begin..].iter().take_while(|other| other.min[0] <= entry.max[0]) {
                if entry.min[0] <= other.max[0] && entry.meets_across(other) {
                    found.push(pack(entry.body, other.body));
                }
            }
        });
    }

    fn boxes_of(&self, column: usize) -> &[Entry] {
        &self.sorted[self.start[column] as usize..self.start[column + 1] as usize]
    }
}

/// The pairs of each box of `run` with the boxes of `boxes`, another column, that begin after it along the sweep axis;
/// if both begin together, the pair belongs to the box of the earlier column.
fn sweep_columns(run: &[Entry], boxes: &[Entry], later: bool, found: &mut Vec<u64>) {
    let before = |other: &Entry, entry: &Entry| other.min[0] < entry.min[0] || (!later && other.min[0] == entry.min[0]);
    let mut next = boxes.partition_point(|other| before(other, &run[0]));
    for entry in run {
        while next < boxes.len() && before(&boxes[next], entry) {
            next += 1;
        }
        scan(entry, &boxes[next..], found);
    }
}

/// The pairs of a box with boxes that begin no earlier along the sweep axis.
fn scan(entry: &Entry, boxes: &[Entry], found: &mut Vec<u64>) {
    for other in boxes.iter().take_while(|other| other.min[0] <= entry.max[0]) {
        if entry.meets_across(other) {
            found.push(pack(entry.body, other.body));
        }
    }
}
