//! The global block order of bodies that are distributed over processes: the order of [`bisect`].
//!
//! Level by level, all parts are cut at once. A part's bodies are counted and their box is joined. The key of its cut,
//! a coordinate and a number, is found among few: a histogram over the box leaves those of one of its columns, which
//! all processes see. A part that one process has whole is that process's own from there on. So a level takes three
//! exchanges, of some numbers for each part that is not yet somebody's.
//!
//! [`bisect`]: crate::bisection::bisect

use crate::bisection::{cuts, edges, half, longest, order};
use crate::processes::Processes;
use glam::DVec3;
use std::collections::BTreeMap;

/// Columns of a histogram. This and the next two numbers change no result, only how many numbers go to all; others were
/// not measured.
const COLUMNS: usize = 128;

/// Of so few bodies all processes see the keys, without a histogram.
const FEW: usize = 512;

/// Histograms in histograms, before a cut is sought among all that is left. Coordinates that differ by rounding alone
/// are in one column.
const MOST_HISTOGRAMS: usize = 6;

/// A body by which parts are cut: a coordinate, and its number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key(f64, u32);

impl Key {
    fn order(&self, other: &Key) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

/// The positions in the block order of these bodies of `all`, from their wrapped centres and ascending global indices.
/// Collective.
pub(super) fn places(processes: Processes, centres: &[DVec3], numbers: &[u32], all: usize) -> Vec<u32> {
    let mut places = Places { processes, centres, numbers, place: vec![0; centres.len()] };
    let levels = cuts(all);
    let mut parts = BTreeMap::from([(0, (0..centres.len() as u32).collect())]);
    for level in 0..levels {
        let edges = edges(all, level);
        let mut cuts = places.begin(&mut parts, &edges, levels - level);
        if cuts.is_empty() {
            return places.place;
        }
        places.narrow(&parts, &mut cuts);
        let keys = places.keys(&cuts);
        parts = places.halves(parts, &cuts, &keys);
    }
    places.settle_blocks(&parts, &edges(all, levels));
    places.place
}

/// The own bodies of each part.
type Parts = BTreeMap<usize, Vec<u32>>;

/// How a part is cut that several processes have bodies of.
struct Cut {
    axis: usize,
    /// Which of the part's keys, in their order, is the first of the second half.
    middle: usize,
    /// The keys that it is among: how many there are, how many are before them, the coordinates they are between, and
    /// the own bodies that have them.
    left: usize,
    before: usize,
    range: [f64; 2],
    own: Vec<u32>,
    histograms: usize,
}

impl Cut {
    fn column(&self, x: f64) -> usize {
        let [low, high] = self.range;
        // What is not a number is in the first column.
        (((x - low) / (high - low) * COLUMNS as f64) as usize).min(COLUMNS - 1)
    }

    fn wants_a_histogram(&self) -> bool {
        self.left > FEW && self.histograms < MOST_HISTOGRAMS && self.range[0] < self.range[1]
    }

    /// Goes on with the column that has the key.
    fn take_column(&mut self, counts: &[usize; COLUMNS], x: impl Fn(u32) -> f64) {
        let mut before = self.before;
        let holds = |column: &usize| {
            before += counts[*column];
            before > self.middle
        };
        let column = (0..COLUMNS).find(holds).unwrap_or(COLUMNS - 1);
        let mut own = std::mem::take(&mut self.own);
        own.retain(|body| self.column(x(*body)) == column);
        let ([low, high], columns) = (self.range, COLUMNS as f64);
        let edge = |column: usize| low + (high - low) * column as f64 / columns;
        self.range = [edge(column), edge(column + 1)];
        (self.own, self.before, self.left) = (own, before - counts[column], counts[column]);
        self.histograms += 1;
    }
}

/// How to cut the parts that no process has whole, by part.
type Cuts = BTreeMap<usize, Cut>;

struct Places<'a> {
    processes: Processes,
    centres: &'a [DVec3],
    numbers: &'a [u32],
    place: Vec<u32>,
}

impl Places<'_> {
    /// Joins the boxes of all parts, and settles those that this process has whole.
    fn begin(&mut self, parts: &mut Parts, edges: &[u32], levels: u32) -> Cuts {
        let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let join = |(low, high): (DVec3, DVec3), (a, b): (DVec3, DVec3)| (low.min(a), high.max(b));
        let of_own = |(part, own): (&usize, &Vec<u32>)| {
            let points = own.iter().map(|body| self.centres[*body as usize]);
            let (low, high) = points.fold(ends, |ends, x| join(ends, (x, x)));
            let sides = [low, high].map(|corner| corner.to_array().map(f64::to_bits)).concat();
            [&[*part as u64, own.len() as u64], sides.as_slice()].concat()
        };
        let all = self.processes.all_gather(&parts.iter().flat_map(of_own).collect::<Vec<u64>>());
        let mut boxes = BTreeMap::new();
        for [part, count, sides @ ..] in all.as_chunks::<8>().0 {
            let [a, b, c, d, e, f] = sides.map(f64::from_bits);
            let sides = (DVec3::new(a, b, c), DVec3::new(d, e, f));
            let known = boxes.entry(*part as usize).or_insert((0, ends));
            *known = (known.0.max(*count as usize), join(known.1, sides));
        }
        let size = |part: usize| (edges[part + 1] - edges[part]) as usize;
        let (mut cuts, mut whole) = (Cuts::new(), Vec::new());
        for (part, (most, (low, high))) in boxes {
            if most == size(part) {
                whole.extend(parts.remove(&part).map(|own| (part, own)));
                continue;
            }
            let axis = longest(low, high);
            let (range, own) = ([low[axis], high[axis]], parts.get(&part).cloned().unwrap_or_default());
            let (left, middle) = (size(part), half(size(part)));
            cuts.insert(part, Cut { axis, middle, left, before: 0, range, own, histograms: 0 });
        }
        for (part, own) in whole {
            let mut bodies: Vec<(DVec3, u32)> = own.iter().map(|body| (self.centres[*body as usize], *body)).collect();
            let order = order(&mut bodies, levels);
            (edges[part]..).zip(order).for_each(|(place, body)| self.place[body as usize] = place);
        }
        cuts
    }

    fn x(&self, body: u32, axis: usize) -> f64 {
        self.centres[body as usize][axis]
    }

    /// Looks for the keys in histograms until few are left.
    fn narrow(&self, parts: &Parts, cuts: &mut Cuts) {
        while cuts.values().any(Cut::wants_a_histogram) {
            let mut own = Vec::new();
            for (part, cut) in cuts.iter().filter(|(part, cut)| cut.wants_a_histogram() && parts.contains_key(part)) {
                let mut counts = [0_u64; COLUMNS];
                cut.own.iter().for_each(|body| counts[cut.column(self.x(*body, cut.axis))] += 1);
                let filled = (0_u64..).zip(counts).filter(|(_, count)| *count > 0);
                own.extend(filled.flat_map(|(column, count)| [*part as u64, column, count]));
            }
            let mut all: BTreeMap<usize, [usize; COLUMNS]> = BTreeMap::new();
            for [part, column, count] in self.processes.all_gather(&own).as_chunks::<3>().0 {
                all.entry(*part as usize).or_insert([0; COLUMNS])[*column as usize] += *count as usize;
            }
            for (part, cut) in cuts.iter_mut() {
                if let Some(counts) = all.get(part) {
                    let axis = cut.axis;
                    cut.take_column(counts, |body| self.x(body, axis));
                }
            }
        }
    }

    /// The first key of the second half of each part.
    fn keys(&self, cuts: &Cuts) -> BTreeMap<usize, Key> {
        let mut own = Vec::new();
        for (part, cut) in cuts {
            let key =
                |body: &u32| [*part as u64, self.numbers[*body as usize].into(), self.x(*body, cut.axis).to_bits()];
            own.extend(cut.own.iter().flat_map(key));
        }
        let mut all: BTreeMap<usize, Vec<Key>> = BTreeMap::new();
        for [part, number, x] in self.processes.all_gather(&own).as_chunks::<3>().0 {
            all.entry(*part as usize).or_default().push(Key(f64::from_bits(*x), *number as u32));
        }
        let key = |(part, mut keys): (usize, Vec<Key>)| {
            let cut = &cuts[&part];
            let middle = (cut.middle - cut.before).min(keys.len() - 1);
            let (_, key, _) = keys.select_nth_unstable_by(middle, |a, b| a.order(b));
            (part, *key)
        };
        all.into_iter().map(key).collect()
    }

    fn halves(&self, parts: Parts, cuts: &Cuts, keys: &BTreeMap<usize, Key>) -> Parts {
        let mut halves = Parts::new();
        for (part, own) in parts {
            let (Some(cut), Some(key)) = (cuts.get(&part), keys.get(&part)) else { continue };
            let is_first = |body: &u32| Key(self.x(*body, cut.axis), self.numbers[*body as usize]).order(key).is_lt();
            let (first, second): (Vec<u32>, Vec<u32>) = own.into_iter().partition(is_first);
            halves.insert(2 * part, first);
            halves.insert(2 * part + 1, second);
        }
        halves.retain(|_, own| !own.is_empty());
        halves
    }

    /// The places within blocks that several processes have bodies of: by number.
    fn settle_blocks(&mut self, parts: &Parts, edges: &[u32]) {
        let words = |(part, own): (&usize, &Vec<u32>)| -> Vec<u64> {
            own.iter().map(|body| (*part as u64) << 32 | u64::from(self.numbers[*body as usize])).collect()
        };
        let mut all = self.processes.all_gather(&parts.iter().flat_map(words).collect::<Vec<u64>>());
        all.sort_unstable();
        for (part, own) in parts {
            let first = all.partition_point(|word| (word >> 32) < *part as u64);
            for body in own {
                let word = (*part as u64) << 32 | u64::from(self.numbers[*body as usize]);
                let rank = all.partition_point(|other| *other < word) - first;
                self.place[*body as usize] = edges[*part] + rank as u32;
            }
        }
    }
}
