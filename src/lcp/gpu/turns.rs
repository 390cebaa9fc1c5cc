//! Turns of the one workgroup of a small problem, read from a program. Each turn consists of rows, pairs, bodies, a
//! product, rows again and a finish; each of these may be empty.

use super::layout::FIRST_CONSTANT;
use super::stage::{Bodies, Product, Rows, Words, Work, packed};

/// One turn, as in `shaders/lcp/main_small.wgsl`.
pub(super) const TURN_WORDS: usize = 16;

/// The steps of a turn, in order.
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
pub(super) struct Turns {
    instructions: Vec<Words>,
    operations: Vec<[u32; 4]>,
    words: Vec<[u32; TURN_WORDS]>,
    last: Step,
    /// The numbers of rows, pairs and bodies of the problem.
    rows: u32,
    pairs: u32,
    bodies: u32,
}

impl Turns {
    /// For a problem with this many rows, pairs and bodies.
    pub fn new([rows, pairs, bodies]: [u32; 3]) -> Self {
        let (instructions, operations) = (Vec::new(), Vec::new());
        Turns { instructions, operations, words: Vec::new(), last: Step::Finish, rows, pairs, bodies }
    }

    /// Ends the present turn and returns the number of turns.
    pub fn end(&mut self) -> u32 {
        self.last = Step::Finish;
        self.words.len() as u32
    }

    /// All words: instructions, operations and turns, in the device's format; and the offset of the turns, in units of
    /// four words.
    pub fn words(mut self) -> (Vec<u32>, u32) {
        let first_operation = 2 * self.instructions.len() as u32;
        for turn in &mut self.words {
            turn[12] += first_operation;
            turn[13] += first_operation;
        }
        let first_turn = first_operation + self.operations.len() as u32;
        let lists = [self.instructions.as_flattened(), self.operations.as_flattened(), self.words.as_flattened()];
        (lists.concat(), first_turn)
    }

    /// Adds operations on scalars, which take sums of these kinds.
    pub fn finish(&mut self, operations: &[[u32; 4]], kinds: &[u32]) {
        if operations.is_empty() {
            return;
        }
        let begin = self.operations.len() as u32;
        self.operations.extend(operations);
        let end = self.operations.len() as u32;
        let turn = self.turn(Step::Finish);
        (turn[12], turn[13], turn[14]) = (begin, end, packed(kinds));
    }

    /// Adds the work that a stage executes after its operations.
    pub fn add(&mut self, work: &Work) {
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
                // Zero for velocities in one part; otherwise the offset of the second part of the vector, plus one.
                let second = if *exact { low.map_or(u32::MAX, |low| low + 1) } else { 0 };
                (turn[8], turn[9], turn[15]) = (bodies, *x, second);
            }
            // One workgroup never solves a problem with clusters.
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

    /// The turn that can execute this step: the last one, unless it already has this step or a later one.
    fn turn(&mut self, step: Step) -> &mut [u32; TURN_WORDS] {
        if step <= self.last || self.words.is_empty() {
            self.words.push([0; TURN_WORDS]);
        }
        self.last = step;
        let last = self.words.len() - 1;
        &mut self.words[last]
    }
}
