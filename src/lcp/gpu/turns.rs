//! A tape for the one workgroup of a small problem: turns, each of which does rows, pairs, bodies, a product, rows
//! again and a finish, or nothing for some of these.

use super::kernels::SMALL_WORKGROUP;
use super::tape::{Product, Stage, Tape};

/// One turn, as in `shaders/lcp/main_small.wgsl`.
pub(super) const TURN_WORDS: usize = 16;

/// Rounds of loops that one invocation makes in one dispatch, about: some drivers end it at 65,535.
const MOST_ROUNDS: u64 = 12_000;

/// Rounds for one row in the small problem of its pair, at most but for odd cases.
const ROUNDS_OF_BLOCKS: u64 = 64;

/// What one workgroup is to do: so many turns, or another stage that has a kernel of its own.
pub(super) enum Part {
    Turns(usize),
    Other(Stage),
}

/// What a turn does, in its order.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Step {
    Before,
    Pairs,
    Bodies,
    Product,
    After,
    Finish,
}

/// Builds turns.
struct Turns {
    words: Vec<[u32; TURN_WORDS]>,
    last: Step,
    /// Rows, pairs and bodies of the problem.
    rows: u32,
    pairs: u32,
    bodies: u32,
}

/// A tape as turns for a problem of so many rows, pairs and bodies, in parts that are not too long for one dispatch.
pub(super) fn of(tape: &Tape, size: [u32; 3]) -> (Vec<Part>, Vec<[u32; TURN_WORDS]>) {
    let mut turns = Turns::new(size[0], size[1], size[2]);
    let (mut parts, mut first, mut rounds) = (Vec::new(), 0, 0);
    for stage in &tape.stages {
        let other = matches!(stage, Stage::PrepareRows | Stage::PreparePairs | Stage::Export { .. });
        turns.add(tape, stage);
        rounds += turns.rounds(stage);
        // Sums are kept in the workgroup until they are finished.
        let long = matches!(stage, Stage::Finish { .. }) && rounds >= MOST_ROUNDS;
        if other || long {
            parts.push(Part::Turns(turns.words.len() - first));
            (first, rounds, turns.last) = (turns.words.len(), 0, Step::Finish);
        }
        if other {
            parts.push(Part::Other(*stage));
        }
    }
    parts.push(Part::Turns(turns.words.len() - first));
    (parts, turns.words)
}

impl Turns {
    fn new(rows: u32, pairs: u32, bodies: u32) -> Self {
        Turns { words: Vec::new(), last: Step::Finish, rows, pairs, bodies }
    }

    /// Adds a stage.
    fn add(&mut self, tape: &Tape, stage: &Stage) {
        let first_operation = 2 * tape.instructions.len();
        let (rows, pairs, bodies) = (self.rows, self.pairs, self.bodies);
        match *stage {
            Stage::Rows { begin, end, product, .. } => {
                if let Some(Product { out, add_q }) = product {
                    let turn = self.turn(Step::Product);
                    (turn[10], turn[11], turn[6]) = (rows, out, u32::from(add_q));
                }
                self.rows(begin, end);
            }
            Stage::Pairs { begin, middle, end, .. } => {
                self.rows(begin, middle);
                let turn = self.turn(Step::Pairs);
                (turn[4], turn[5]) = (2 * middle as u32, pairs);
                self.rows(middle + 1, end);
            }
            Stage::Bodies { x } => {
                let turn = self.turn(Step::Bodies);
                (turn[8], turn[9]) = (bodies, x);
            }
            Stage::Finish { begin, end, kinds, .. } => {
                let turn = self.turn(Step::Finish);
                (turn[12], turn[13], turn[14]) =
                    ((first_operation + begin) as u32, (first_operation + end) as u32, kinds);
            }
            Stage::PrepareRows | Stage::PreparePairs | Stage::Export { .. } => {}
        }
    }

    fn rows(&mut self, begin: usize, end: usize) {
        if begin == end {
            return;
        }
        let begins = matches!(self.last, Step::After | Step::Finish);
        let (step, at) = if begins { (Step::Before, 0) } else { (Step::After, 2) };
        let turn = self.turn(step);
        (turn[at], turn[at + 1]) = (2 * begin as u32, 2 * end as u32);
    }

    /// The turn that can do this part: the last, unless that did it or a later one.
    fn turn(&mut self, step: Step) -> &mut [u32; TURN_WORDS] {
        if step <= self.last || self.words.is_empty() {
            self.words.push([0; TURN_WORDS]);
        }
        self.last = step;
        let last = self.words.len() - 1;
        &mut self.words[last]
    }

    /// About how many rounds of loops an invocation makes for a stage.
    fn rounds(&self, stage: &Stage) -> u64 {
        let each = |n: u32| u64::from(n.div_ceil(SMALL_WORKGROUP)) + 1;
        let rows = each(self.rows);
        match *stage {
            Stage::Rows { begin, end, product, .. } => ((end - begin) as u64 + u64::from(product.is_some())) * rows,
            Stage::Pairs { begin, end, .. } => (end - begin) as u64 * rows + ROUNDS_OF_BLOCKS * rows,
            Stage::Bodies { .. } => each(self.bodies) + 2 * rows,
            Stage::Finish { begin, end, .. } => (end - begin) as u64 + 16,
            _ => 0,
        }
    }
}
