//! A tape for the one workgroup of a small problem.
//!
//! Its elements are the works of a segment's stages and the operations between them. Iterations repeat the same
//! elements with other vectors and scalars. They have a specialised kernel, which keeps intermediate results in
//! registers, has no branches and runs iteration after iteration. A kernel that all solves share reads the elements
//! before and after the iterations as [`Turns`]: interpreting takes some five times as long on a software adapter, but
//! a specialised kernel for everything would take minutes to compile.

use super::layout::{MOST_NUMBERS, MOST_VECTORS, Parameters};
use super::shape::{Shape, ShapeWork, StageArguments};
use super::stage::{Rows, Segment, Stage, Words, Work};
use super::turns::{TURN_WORDS, Turns};
use std::ops::Range;

/// Words of an element, as `Places` in `shaders/lcp/parameters.wgsl`: a power of two, because parts of an arena begin
/// with whole elements.
pub(super) const ELEMENT_WORDS: usize = 32;

const _: () = assert!(MOST_VECTORS / 4 + MOST_NUMBERS / 2 + 2 <= ELEMENT_WORDS);

/// The largest number of elements in an iteration: those of `pair_block_cg` have eight.
const LONGEST_PERIOD: usize = 24;

/// The approximate number of rounds of loops that one invocation executes in one dispatch: some drivers end an
/// invocation at 65,535, and a pair of eight rows may take six times its estimate. With 40,000, a colony of 256 cells
/// takes a fourth of the dispatches, and 4 % less time.
const MOST_ROUNDS: u64 = 12_000;

/// The largest number of rounds for one row in the small problem of its pair, except in rare cases.
const ROUNDS_OF_BLOCKS: u64 = 64;

/// The work of one workgroup, or another stage that has its own kernel.
pub(super) enum Part {
    /// The turns between two offsets of the program.
    Turns {
        range: Range<u32>,
        confirms: bool,
    },
    Rounds(Rounds),
    Other(Work),
}

/// Elements that are executed in order, several times.
pub(super) struct Rounds {
    pub shapes: Vec<Shape>,
    /// The offset of the first round's elements.
    pub first: u32,
    pub rounds: u32,
    /// The largest number of rounds of one dispatch.
    pub at_once: u32,
}

/// A segment for one workgroup.
#[derive(Default)]
pub(super) struct Program {
    /// Turns, in the device's format.
    pub words: Vec<u32>,
    /// The offsets of the vectors and scalars of the rounds' elements.
    pub places: Vec<[u32; ELEMENT_WORDS]>,
    pub parts: Vec<Part>,
}

/// The operations of a stage, or its work.
struct Element<'a> {
    stage: &'a Stage,
    /// The stage before, whose sums the operations take.
    before: Option<&'a Stage>,
    is_work: bool,
    /// The number of checks before it, over the solve.
    looks: u32,
    /// A hash of its work without the offsets of vectors and scalars: elements of one shape have the same hash.
    kind: u64,
}

struct Building {
    program: Program,
    turns: Turns,
    size: [u32; 3],
    workgroup: u32,
}

/// A segment, and the confirmation of a check, for a problem with this many rows, pairs and bodies and for this many
/// invocations.
pub(super) fn of(
    segment: &Segment,
    confirmation: &[Stage],
    constants: &[f64],
    size: [u32; 3],
    workgroup: u32,
) -> Program {
    let mut of = Building { program: Program::default(), turns: Turns::new(size), size, workgroup };
    let mut elements = Vec::new();
    let (mut before, mut looks) = (None, segment.looks_before);
    for stage in &segment.stages {
        add(&mut elements, stage, before, &mut looks);
        if matches!(stage.work, Work::PrepareRows | Work::PreparePairs | Work::Export { .. }) {
            of.add(&std::mem::take(&mut elements), constants);
            of.program.parts.push(Part::Other(stage.work.clone()));
        }
        before = Some(stage);
    }
    of.add(&elements, constants);
    elements.clear();
    before = None;
    for stage in confirmation {
        add(&mut elements, stage, before, &mut looks);
        before = Some(stage);
    }
    of.turns(&elements, true);
    let Building { mut program, turns, .. } = of;
    let (words, first_turn) = turns.words();
    for part in &mut program.parts {
        if let Part::Turns { range, .. } = part {
            let place = |turn: u32| first_turn + turn * (TURN_WORDS / 4) as u32;
            *range = place(range.start)..place(range.end);
        }
    }
    program.words = words;
    program
}

/// Adds the elements of a stage that follows another one.
fn add<'a>(elements: &mut Vec<Element<'a>>, stage: &'a Stage, before: Option<&'a Stage>, looks: &mut u32) {
    if !stage.operations.is_empty() {
        let kind = stage.operations.iter().fold(1, |kind, words| mixed(kind, words[0] & 0xff));
        elements.push(Element { stage, before, is_work: false, looks: *looks, kind });
        *looks += stage.looks();
    }
    let kind = match &stage.work {
        Work::Rows(Rows { product, before, block, after, .. }) => {
            let actions = |kind, lines: &[Words]| lines.iter().fold(kind, |kind, words| mixed(kind, words[0]));
            let [product, block] = [product.is_some(), block.is_some()].map(u32::from);
            actions(mixed(actions(mixed(2, product), before), block), after)
        }
        Work::Bodies(_) => 3,
        _ => return,
    };
    elements.push(Element { stage, before, is_work: true, looks: *looks, kind });
}

/// A hash of words, by the steps of FNV.
fn mixed(kind: u64, word: u32) -> u64 {
    (kind ^ u64::from(word + 1)).wrapping_mul(0x100_0000_01b3)
}

impl Building {
    /// Adds elements: those before the longest repetition, the repetition, and those after it.
    fn add(&mut self, elements: &[Element], constants: &[f64]) {
        let kinds: Vec<u64> = elements.iter().map(|element| element.kind).collect();
        let (start, period, rounds) = repetition(&kinds, |at| elements[at].leaves_sums());
        let repeated = &elements[start..start + period * rounds];
        let arguments: Vec<StageArguments> = repeated.iter().map(|element| element.arguments(constants)).collect();
        let shape = |at: usize| &arguments[at].shape;
        if rounds < 2 || (period..arguments.len()).any(|at| shape(at) != shape(at % period)) {
            return self.turns(elements, false);
        }
        self.turns(&elements[..start], false);
        let first = self.program.places.len() as u32;
        let places = repeated.iter().zip(&arguments).map(|(element, arguments)| places(arguments, element.looks));
        self.program.places.extend(places);
        let shapes: Vec<Shape> = arguments.into_iter().take(period).map(|arguments| arguments.shape).collect();
        let cost = |elements: &[Element]| elements.iter().map(|element| self.rounds_of(element)).sum::<u64>();
        let at_once = MOST_ROUNDS / cost(&repeated[..period]).max(1);
        // If a round is too long for one dispatch, each dispatch ends after the small problems of the pairs.
        let cuts = |at: &usize| *at == period || (is_after_pairs(&shapes[..*at]) && !repeated[at - 1].leaves_sums());
        let ends: Vec<usize> = if at_once == 0 { (1..=period).filter(cuts).collect() } else { vec![period] };
        let (times, rounds) = if at_once == 0 { (rounds as u32, 1) } else { (1, rounds as u32) };
        for nth in 0..times {
            let mut begin = 0;
            for end in &ends {
                let (shapes, first) = (shapes[begin..*end].to_vec(), first + nth * period as u32 + begin as u32);
                let at_once = at_once.clamp(1, MOST_ROUNDS) as u32;
                self.program.parts.push(Part::Rounds(Rounds { shapes, first, rounds, at_once }));
                begin = *end;
            }
        }
        self.turns(&elements[start + repeated.len()..], false);
    }

    /// Adds elements as turns, in parts of limited length.
    fn turns(&mut self, elements: &[Element], confirms: bool) {
        let (mut begin, mut rounds, mut kinds) = (self.turns.end(), 0, Vec::new());
        for (nth, element) in elements.iter().enumerate() {
            rounds += self.rounds_of(element);
            if element.is_work {
                self.turns.add(&element.stage.work);
                kinds = element.stage.kinds();
            } else {
                self.turns.finish(&element.stage.operations, &kinds);
            }
            // The workgroup keeps sums until they are taken.
            let ends = nth + 1 == elements.len() || (rounds >= MOST_ROUNDS && !element.leaves_sums());
            if ends {
                let end = self.turns.end();
                self.program.parts.push(Part::Turns { range: begin..end, confirms });
                (begin, rounds) = (end, 0);
            }
        }
    }

    /// The approximate number of rounds of loops that an invocation executes for an element.
    fn rounds_of(&self, element: &Element) -> u64 {
        let [rows, pairs, bodies] = self.size;
        let each = |n: u32| u64::from(n.div_ceil(self.workgroup)) + 1;
        match &element.stage.work {
            _ if !element.is_work => element.stage.operations.len() as u64 + 16,
            Work::Rows(Rows { before, block, after, .. }) => {
                let blocks = if block.is_some() { 3 * each(pairs) + ROUNDS_OF_BLOCKS * each(rows) } else { 0 };
                (1 + before.len() + after.len()) as u64 * each(rows) + blocks
            }
            _ => each(bodies) + 2 * each(rows),
        }
    }
}

impl Element<'_> {
    /// Whether it leaves sums that the next element takes.
    fn leaves_sums(&self) -> bool {
        matches!(&self.stage.work, Work::Rows(Rows { kinds, .. }) if self.is_work && !kinds.is_empty())
    }

    fn arguments(&self, constants: &[f64]) -> StageArguments {
        if self.is_work {
            return StageArguments::of_work(constants, &self.stage.work);
        }
        StageArguments::of_operations(constants, &self.stage.operations, &self.before.map_or(Vec::new(), Stage::kinds))
    }
}

/// Whether the last elements, apart from operations, are the small problems of pairs.
fn is_after_pairs(shapes: &[Shape]) -> bool {
    shapes.iter().rev().find(|shape| !matches!(shape.work, ShapeWork::Numbers)).is_some_and(Shape::has_block)
}

/// The offsets of an element, as `Places` in `shaders/lcp/parameters.wgsl`.
fn places(arguments: &StageArguments, looks: u32) -> [u32; ELEMENT_WORDS] {
    let mut parameters = Parameters::default();
    parameters.pass(&arguments.vectors, &arguments.numbers);
    let mut words = [0; ELEMENT_WORDS];
    let all = parameters.vectors.into_iter().chain(parameters.numbers).chain([arguments.base, looks]);
    words.iter_mut().zip(all).for_each(|(word, value)| *word = value);
    words
}

/// The longest repetition: its start, the number of elements in a round, and the number of rounds. Without a
/// repetition, one round of no elements at the end. No round begins with sums of the element before, because sums are
/// lost at the end of a dispatch.
fn repetition(kinds: &[u64], leaves_sums: impl Fn(usize) -> bool) -> (usize, usize, usize) {
    let may_cut = |at: usize| at == 0 || !leaves_sums(at - 1);
    let mut best = (kinds.len(), 0, 1);
    let mut covered = 0;
    for period in 1..=LONGEST_PERIOD.min(kinds.len() / 2) {
        for run in equal_runs(kinds, period) {
            // Later starts in the run leave fewer elements.
            let Some(start) = run.clone().find(|at| may_cut(*at) && may_cut(at + period)) else { continue };
            let rounds = (run.end + period - start) / period;
            if rounds >= 2 && rounds * period > covered {
                (best, covered) = ((start, period, rounds), rounds * period);
            }
        }
    }
    best
}

/// The runs of elements that are equal to those one period later.
fn equal_runs(kinds: &[u64], period: usize) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut begin = 0;
    let last = kinds.len() - period;
    for at in 0..=last {
        if at == last || kinds[at] != kinds[at + period] {
            if at > begin {
                runs.push(begin..at);
            }
            begin = at + 1;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_repeated_most_is_found() {
        for (word, expected) in [
            ("abc", (3, 0, 1)),
            ("xabcabcabcab", (1, 3, 3)),
            ("aab", (0, 1, 2)),
            ("headloopslooploopend", (9, 4, 2)),
            // A round does not begin with sums of the element before.
            ("xAbAbAb", (1, 2, 3)),
            ("AbcAbcAbc", (0, 3, 3)),
            ("bAbAbAy", (1, 2, 2)),
        ] {
            // Capital letters leave sums.
            let kinds: Vec<u64> = word.to_lowercase().bytes().map(u64::from).collect();
            let found = repetition(&kinds, |at| word.as_bytes()[at].is_ascii_uppercase());
            assert_eq!(found, expected, "{word}");
        }
        assert_eq!(repetition(&[], |_| false), (0, 0, 1));
    }
}
