//! The tape: what verbs and arithmetic asked for, cut into stages.
//!
//! A stage is what can be done without data of other rows: instructions on rows, with the sums over rows that they end
//! in, or one pass over the bodies. It ends where a product or the small problems of the pairs need whole vectors, and
//! where an instruction needs a number that the sums made; then the sums are finished and the operations on numbers
//! done.

use super::layout::{CONSTANTS, FIRST_CONSTANT, HALT, LOOKS, REDUCTIONS};
use super::number::{self, Noted, Number, Operation, RING};
use super::shape::StageArguments;

/// How the values of rows are brought together, with their names in kernels.
const SUM: u32 = 0;
const LEAST: u32 = 1;
const WORST: u32 = 2;
pub(super) const REDUCTION_KINDS: [(&str, u32); 3] = [("SUM", SUM), ("LEAST", LEAST), ("WORST", WORST)];

/// What is done on a row, by `shaders/lcp/instructions.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Hash)]
#[repr(u32)]
pub(super) enum Action {
    Zero,
    Copy,
    CopyIf,
    Combine,
    Proximal,
    Project,
    Invert,
    Dot,
    Triple,
    Objective,
    Room,
    Residual,
    Largest,
}

impl Action {
    /// How its values are brought together, by `shaders/lcp/reduce.wgsl`.
    pub fn kind(self) -> u32 {
        match self {
            Action::Room => LEAST,
            Action::Residual | Action::Largest => WORST,
            _ => SUM,
        }
    }

    /// The name of its number in kernels.
    pub fn constant(self) -> &'static str {
        match self {
            Action::Zero => "ZERO",
            Action::Copy => "COPY",
            Action::CopyIf => "COPY_IF",
            Action::Combine => "COMBINE",
            Action::Proximal => "PROXIMAL",
            Action::Project => "PROJECT",
            Action::Invert => "INVERT",
            Action::Dot => "DOT",
            Action::Triple => "TRIPLE",
            Action::Objective => "OBJECTIVE",
            Action::Room => "ROOM",
            Action::Residual => "RESIDUAL",
            Action::Largest => "LARGEST",
        }
    }
}

/// This many instructions and one more always fit the parameters of a dispatch.
const FEW: usize = 6;

/// One instruction: what, out, three vectors, two numbers.
pub(super) type Words = [u32; 8];

/// Where in the tape a stage's instructions or operations stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Instructions on rows; before them the rows of a product.
    Rows { begin: usize, end: usize, product: Option<Product>, sums: Sums },
    /// Instructions on the rows of pairs, the one at `middle` on whole pairs.
    Pairs { begin: usize, middle: usize, end: usize, sums: Sums },
    /// `J^T x`.
    Bodies { x: u32 },
    /// Finishes sums, does operations on numbers.
    Finish { begin: usize, end: usize, kinds: u32, sums: u32 },
    /// Reads the problem.
    PrepareRows,
    /// Looks at the blocks of pairs.
    PreparePairs,
    /// Brings a vector to `gamma`.
    Export { x: u32 },
}

/// The row half of a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Product {
    pub out: u32,
    pub add_q: bool,
}

/// The sums that a stage makes, of those that the next finish takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sums {
    pub first: u32,
    pub count: u32,
    /// Kinds of all up to these.
    pub kinds: u32,
}

impl Stage {
    /// Its name, for timing.
    pub fn name(&self) -> &'static str {
        match self {
            Stage::Rows { product: None, .. } => "lcp-rows",
            Stage::Rows { .. } => "lcp-product",
            Stage::Pairs { .. } => "lcp-pairs",
            Stage::Bodies { .. } => "lcp-bodies",
            Stage::Finish { .. } => "lcp-finish",
            Stage::PrepareRows | Stage::PreparePairs | Stage::Export { .. } => "lcp-prepare",
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Tape {
    pub instructions: Vec<Words>,
    pub operations: Vec<[u32; 4]>,
    pub stages: Vec<Stage>,
    pub looks: u32,
    constants: Vec<f64>,
    noted: Vec<Noted>,
    /// Whether the last stage may be added to.
    open: bool,
    /// Numbers that are known after the next finish only.
    unfinished: Vec<u32>,
    /// Operations from here on wait for it, and so many sums.
    waiting: usize,
    sums: u32,
    kinds: u32,
}

impl Tape {
    /// Takes up arithmetic noted since.
    fn catch_up(&mut self) {
        number::drain(&mut self.noted);
        for noted in std::mem::take(&mut self.noted) {
            let [a, b, c] = noted.operands.map(|operand| self.number(operand));
            let out = number::place(noted.out);
            self.operations.push([noted.operation as u32 | out << 8, a, b, c]);
            self.unfinished.push(out);
        }
    }

    /// Where a number stands.
    pub fn number(&mut self, number: Number) -> u32 {
        match number {
            Number::At(nth) => number::place(nth),
            Number::Known(x) => {
                let known = self.constants.iter().position(|y| y.to_bits() == x.to_bits());
                let place = known.unwrap_or_else(|| {
                    // Solvers use some ten constants.
                    if self.constants.len() >= CONSTANTS as usize {
                        number::report("a solver uses more constants than a device holds");
                        self.constants.truncate(CONSTANTS as usize - 1);
                    }
                    self.constants.push(x);
                    self.constants.len() - 1
                });
                FIRST_CONSTANT + place as u32
            }
        }
    }

    /// All constants used so far.
    pub fn constants(&self) -> &[f64] {
        &self.constants
    }

    fn knows(&self, number: u32) -> bool {
        number >= RING || !self.unfinished.contains(&number)
    }

    /// Adds an instruction on rows.
    pub fn row(&mut self, action: Action, out: u32, vectors: [u32; 3], numbers: [Number; 2]) {
        let words = self.words(action, out, vectors, numbers);
        self.rows_stage();
        self.push(words);
    }

    /// Adds a sum (or least, or worst) over the rows.
    pub fn sum(&mut self, action: Action, vectors: [u32; 3]) -> Number {
        self.catch_up();
        if self.sums == REDUCTIONS {
            self.finish();
        }
        let words = self.words(action, self.sums, vectors, [Number::Known(0.0); 2]);
        self.rows_stage();
        self.push(words);
        let nth = number::new();
        let place = number::place(nth);
        self.operations.push([Operation::Take as u32 | place << 8, self.sums, 0, 0]);
        self.unfinished.push(place);
        self.kinds |= action.kind() << (2 * self.sums);
        self.sums += 1;
        if let Some(Stage::Rows { sums, .. } | Stage::Pairs { sums, .. }) = self.stages.last_mut() {
            (sums.count, sums.kinds) = (sums.count + 1, self.kinds);
        }
        Number::At(nth)
    }

    /// Adds the small problems of the pairs.
    pub fn pairs(&mut self, x: u32, step: Number, g: u32, out: u32) {
        let words = self.words(Action::Proximal, out, [x, g, x], [step, Number::Known(0.0)]);
        let middle = self.instructions.len();
        let last = if self.open { self.stages.last().copied() } else { None };
        match last {
            Some(Stage::Rows { begin, end, product: None, sums }) => {
                self.stages.pop();
                self.stages.push(Stage::Pairs { begin, middle: end, end, sums });
            }
            _ => {
                self.stages.push(Stage::Pairs { begin: middle, middle, end: middle, sums: self.new_sums() });
                self.open = true;
            }
        }
        self.push(words);
    }

    /// Adds `out = [q +] A x`.
    pub fn product(&mut self, x: u32, out: u32, add_q: bool) {
        self.catch_up();
        self.stages.push(Stage::Bodies { x });
        let at = self.instructions.len();
        let product = Some(Product { out, add_q });
        self.stages.push(Stage::Rows { begin: at, end: at, product, sums: self.new_sums() });
        self.open = true;
    }

    /// Adds another stage.
    pub fn stage(&mut self, stage: Stage) {
        self.catch_up();
        self.open = false;
        self.stages.push(stage);
    }

    /// Notes a residual. Says whether there was room.
    pub fn look(&mut self, residual: Number, tolerance: f64) -> bool {
        self.catch_up();
        if self.looks == LOOKS {
            return false;
        }
        let [residual, tolerance] = [residual, Number::Known(tolerance)].map(|number| self.number(number));
        self.looks += 1;
        let out = HALT + self.looks;
        self.operations.push([Operation::Look as u32 | out << 8, residual, tolerance, tolerance]);
        true
    }

    /// Ends the last stage, finishes all sums and does all operations.
    pub fn finish(&mut self) {
        self.catch_up();
        self.open = false;
        if self.waiting < self.operations.len() {
            let (begin, end) = (self.waiting, self.operations.len());
            self.stages.push(Stage::Finish { begin, end, kinds: self.kinds, sums: self.sums });
        }
        (self.waiting, self.sums, self.kinds) = (self.operations.len(), 0, 0);
        self.unfinished.clear();
    }

    /// Whether there is a look among some operations.
    pub fn looks_in(&self, begin: usize, end: usize) -> bool {
        self.operations[begin..end].iter().any(|words| words[0] & 0xff == Operation::Look as u32)
    }

    /// Forgets all but the constants.
    pub fn clear(&mut self) {
        self.instructions.clear();
        self.operations.clear();
        self.stages.clear();
        self.unfinished.clear();
        (self.looks, self.waiting, self.sums, self.kinds, self.open) = (0, 0, 0, 0, false);
    }

    /// An instruction, after a finish where its numbers need one.
    fn words(&mut self, action: Action, out: u32, [a, b, c]: [u32; 3], numbers: [Number; 2]) -> Words {
        self.catch_up();
        let [s, t] = numbers.map(|number| self.number(number));
        if !self.knows(s) || !self.knows(t) {
            self.finish();
        }
        [action as u32, out, a, b, c, s, t, 0]
    }

    fn new_sums(&self) -> Sums {
        Sums { first: self.sums, count: 0, kinds: self.kinds }
    }

    fn rows_stage(&mut self) {
        if !self.open || self.is_full() {
            let at = self.instructions.len();
            self.stages.push(Stage::Rows { begin: at, end: at, product: None, sums: self.new_sums() });
            self.open = true;
        }
    }

    /// Whether the last stage might exceed the parameters of a dispatch with one more instruction.
    fn is_full(&self) -> bool {
        match self.stages.last() {
            Some(stage @ (Stage::Rows { begin, end, .. } | Stage::Pairs { begin, end, .. })) if end - begin > FEW => {
                !StageArguments::of(self, stage).is_some_and(|arguments| arguments.has_room())
            }
            _ => false,
        }
    }

    fn push(&mut self, words: Words) {
        self.instructions.push(words);
        let at = self.instructions.len();
        if let Some(Stage::Rows { end, .. } | Stage::Pairs { end, .. }) = self.stages.last_mut() {
            *end = at;
        }
    }
}
