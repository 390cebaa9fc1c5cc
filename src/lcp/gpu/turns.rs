//! A tape for the one workgroup of a small problem: turns, each of which does rows, pairs, bodies, a product, rows
//! again and a finish, or nothing for some of these.

use super::layout::FIRST_CONSTANT;
use super::stage::{Bodies, Product, Rows, Segment, Stage, Words, Work, packed};

/// One turn, as in `shaders/lcp/main_small.wgsl`.
pub(super) const TURN_WORDS: usize = 16;

/// Rounds of loops that one invocation makes in one dispatch, about: some drivers end it at 65,535.
const MOST_ROUNDS: u64 = 12_000;

/// Rounds for one row in the small problem of its pair, at most but for odd cases.
const ROUNDS_OF_BLOCKS: u64 = 64;

/// What one workgroup is to do: so many turns, or another stage that has a kernel of its own.
pub(super) enum Part {
    Turns(usize),
    /// Turns that are done if a look ended the batch.
    Confirmation(usize),
    Other(Work),
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

/// A segment for one workgroup.
#[derive(Default)]
pub(super) struct Program {
    /// Instructions, operations and turns, as the device reads them.
    pub words: Vec<u32>,
    /// Where the turns begin, in fours of words.
    pub first_turn: u32,
    pub parts: Vec<Part>,
}

/// Builds turns.
struct Turns {
    instructions: Vec<Words>,
    operations: Vec<[u32; 4]>,
    words: Vec<[u32; TURN_WORDS]>,
    last: Step,
    /// Rows, pairs and bodies of the problem.
    rows: u32,
    pairs: u32,
    bodies: u32,
    /// Invocations of the workgroup.
    workgroup: u32,
}

/// A segment, and what confirms a look, as turns of a workgroup of so many invocations for a problem of so many rows,
/// pairs and bodies, in parts that are not too long for one dispatch.
pub(super) fn of(segment: &Segment, confirmation: &[Stage], size: [u32; 3], workgroup: u32) -> Program {
    let mut turns = Turns::new(size, workgroup);
    let (mut parts, mut first, mut rounds) = (Vec::new(), 0, 0);
    let mut kinds = Vec::new();
    for stage in &segment.stages {
        let other = matches!(stage.work, Work::PrepareRows | Work::PreparePairs | Work::Export { .. });
        turns.finish(&stage.operations, &kinds);
        rounds += stage.operations.len() as u64 + 16;
        // Sums are kept in the workgroup until they are finished.
        if other || (rounds >= MOST_ROUNDS && !stage.operations.is_empty()) {
            parts.push(Part::Turns(turns.words.len() - first));
            (first, rounds, turns.last) = (turns.words.len(), 0, Step::Finish);
        }
        turns.add(&stage.work);
        rounds += turns.rounds(stage);
        kinds = stage.kinds();
        if other {
            parts.push(Part::Other(stage.work.clone()));
        }
    }
    parts.push(Part::Turns(turns.words.len() - first));
    (first, turns.last) = (turns.words.len(), Step::Finish);
    kinds.clear();
    for stage in confirmation {
        turns.finish(&stage.operations, &kinds);
        turns.add(&stage.work);
        kinds = stage.kinds();
    }
    parts.push(Part::Confirmation(turns.words.len() - first));
    turns.program(parts)
}

impl Turns {
    fn new([rows, pairs, bodies]: [u32; 3], workgroup: u32) -> Self {
        let (instructions, operations) = (Vec::new(), Vec::new());
        Turns { instructions, operations, words: Vec::new(), last: Step::Finish, rows, pairs, bodies, workgroup }
    }

    /// All words. Operations follow the instructions.
    fn program(mut self, parts: Vec<Part>) -> Program {
        let first_operation = 2 * self.instructions.len() as u32;
        for turn in &mut self.words {
            turn[12] += first_operation;
            turn[13] += first_operation;
        }
        let first_turn = first_operation + self.operations.len() as u32;
        let lists = [self.instructions.as_flattened(), self.operations.as_flattened(), self.words.as_flattened()];
        Program { words: lists.concat(), first_turn, parts }
    }

    /// Adds operations on numbers, which take sums of these kinds.
    fn finish(&mut self, operations: &[[u32; 4]], kinds: &[u32]) {
        if operations.is_empty() {
            return;
        }
        let begin = self.operations.len() as u32;
        self.operations.extend(operations);
        let end = self.operations.len() as u32;
        let turn = self.turn(Step::Finish);
        (turn[12], turn[13], turn[14]) = (begin, end, packed(kinds));
    }

    /// Adds what a stage does after its operations.
    fn add(&mut self, work: &Work) {
        let (rows, pairs, bodies) = (self.rows, self.pairs, self.bodies);
        match work {
            Work::Rows(Rows { product, before, block, after, .. }) => {
                if let Some(Product { out, add_q, .. }) = *product {
                    let turn = self.turn(Step::Product);
                    (turn[10], turn[11], turn[6]) = (rows, out, u32::from(add_q));
                }
                self.rows(before);
                if let Some(block) = block {
                    let at = 2 * self.instructions.len() as u32;
                    let [w, g] = [block.w, block.g].map(|vector| vector.unwrap_or(u32::MAX));
                    self.instructions.push([0, block.out, block.x, w, g, FIRST_CONSTANT, FIRST_CONSTANT, 0]);
                    let turn = self.turn(Step::Pairs);
                    (turn[4], turn[5]) = (at, pairs);
                }
                self.rows(after);
            }
            Work::Bodies(Bodies { x, low, exact, .. }) => {
                let turn = self.turn(Step::Bodies);
                // Zero for velocities in one part, else one more than the place of the second part of the vector.
                let second = if *exact { low.map_or(u32::MAX, |low| low + 1) } else { 0 };
                (turn[8], turn[9], turn[15]) = (bodies, *x, second);
            }
            // A problem with clusters is never for one workgroup.
            Work::Clusters(_) => {}
            Work::Numbers | Work::PrepareRows | Work::PreparePairs | Work::Export { .. } => {}
        }
    }

    fn rows(&mut self, instructions: &[Words]) {
        if instructions.is_empty() {
            return;
        }
        let begin = 2 * self.instructions.len() as u32;
        self.instructions.extend(instructions);
        let end = 2 * self.instructions.len() as u32;
        let begins = matches!(self.last, Step::After | Step::Finish);
        let (step, at) = if begins { (Step::Before, 0) } else { (Step::After, 2) };
        let turn = self.turn(step);
        (turn[at], turn[at + 1]) = (begin, end);
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

    /// About how many rounds of loops an invocation makes for a stage on rows or bodies.
    fn rounds(&self, stage: &Stage) -> u64 {
        let each = |n: u32| u64::from(n.div_ceil(self.workgroup)) + 1;
        let rows = each(self.rows);
        match &stage.work {
            Work::Rows(Rows { product, before, block, after, .. }) => {
                let blocks = if block.is_some() { ROUNDS_OF_BLOCKS } else { 0 };
                ((before.len() + after.len()) as u64 + u64::from(product.is_some()) + blocks) * rows
            }
            Work::Bodies(_) => each(self.bodies) + 2 * rows,
            _ => 0,
        }
    }
}
