//! The tape: the operations that verbs and arithmetic recorded, ordered into stages.
//!
//! A stage is the work of one dispatch: operations on scalars, then instructions on rows with the small problems of the
//! pairs between them, or one pass over the bodies. An instruction goes to the first stage that can execute it. So an
//! instruction that waits for a scalar does not delay later instructions that do not wait.
//!
//! * The beginning of the next stage completes the sums that a stage computes, and executes the operations that wait
//!   for them.
//! * A stage has at most one instruction on whole pairs. A product needs all of a vector and is two stages.
//! * The vectors of a convergence test (the iterate and its gradient) stay unchanged until the test is complete,
//!   because nothing that follows may be executed if the test ends the solve.

use super::layout::{CONSTANTS, FIRST_CONSTANT, HALT, LOOKS, REDUCTIONS, TOLERANCE};
use super::number::{self, Noted, Number, Operation};
use super::room::Room;
use super::stage::{Action, Block, Bodies, Clusters, Gather, Product, Rows, Segment, Stage, Words, Work};
use std::collections::HashMap;

#[derive(Debug, Default)]
pub(super) struct Tape {
    pub stages: Vec<Stage>,
    /// The vectors and scalars that each stage uses, and those of the operations that wait for the next stage.
    rooms: Vec<Room>,
    /// Operations for the next stage.
    pending: Vec<[u32; 4]>,
    pending_room: Room,
    /// The kinds of the sums of the stage before the first one here.
    carried: Vec<u32>,
    /// The number of stages that were run before.
    run: u32,
    /// The number of checks recorded here, and the number of checks run before.
    pub looks: u32,
    looks_run: u32,
    /// The stage whose operations contain the last check.
    look_at: Option<usize>,
    /// The vectors of the last residual.
    looked_at: [u32; 2],
    constants: Vec<f64>,
    noted: Vec<Noted>,
    /// No instruction is added to stages before this one.
    floor: usize,
    /// No sum is added to stages before this one: the last stage with a sum, a product or the pairs. The bits of a sum
    /// depend on its stage, which must not depend on which stages have already been run.
    sums_floor: usize,
    /// The stage at whose beginning a scalar is known.
    ready: HashMap<u32, usize>,
    vectors: Vec<Uses>,
    /// Whether a product may choose its vector, and whether sums persist between runs. A single workgroup supports
    /// neither.
    apart: bool,
    /// Whether velocities are computed in two parts.
    exact: bool,
}

/// The last stages that used a vector, and the first one that may change it.
#[derive(Clone, Copy, Debug, Default)]
struct Uses {
    written: usize,
    read: usize,
    held: usize,
}

impl Tape {
    /// An empty tape, for one dispatch per stage (`apart`) or for one workgroup, with velocities in two parts (`exact`)
    /// or in one.
    pub fn new(apart: bool, exact: bool) -> Self {
        Tape { apart, exact, ..Tape::default() }
    }

    /// Whether each stage is a separate dispatch.
    pub fn is_apart(&self) -> bool {
        self.apart
    }

    /// Whether velocities are computed in two parts.
    pub fn exact(&self) -> bool {
        self.exact
    }

    /// Adds the arithmetic recorded since the last call.
    fn catch_up(&mut self) {
        number::drain(&mut self.noted);
        for noted in std::mem::take(&mut self.noted) {
            let operands = noted.operands.map(|operand| self.number(operand));
            let [a, b, c] = operands;
            let known = operands.map(|place| self.known_at(place)).into_iter().max().unwrap_or(0);
            let stage = self.operations_stage(known.max(self.floor));
            let out = number::place(noted.out);
            self.operation(stage, [noted.operation as u32 | out << 8, a, b, c]);
            self.ready.insert(out, stage);
        }
    }

    /// The offset of a scalar.
    pub fn number(&mut self, number: Number) -> u32 {
        match number {
            Number::At(nth) => number::place(nth),
            Number::Tolerance => TOLERANCE,
            Number::Known(x) => {
                let known = self.constants.iter().position(|y| y.to_bits() == x.to_bits());
                let place = known.unwrap_or_else(|| {
                    // Solvers use some ten constants.
                    if self.constants.len() + 1 >= CONSTANTS as usize {
                        number::report("a solver uses more constants than a device holds");
                        self.constants.truncate(CONSTANTS as usize - 2);
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

    /// The stage at whose beginning a scalar is known.
    fn known_at(&self, place: u32) -> usize {
        self.ready.get(&place).copied().unwrap_or(0)
    }

    /// The first stage, from one on, with space for an operation; it may be the next stage.
    fn operations_stage(&mut self, first: usize) -> usize {
        if let Some(stage) = (first..self.stages.len()).find(|nth| !self.is_full(*nth)) {
            return stage;
        }
        if self.pending_room.is_full() {
            self.finish();
        }
        self.stages.len()
    }

    /// Adds an operation on scalars to a stage, which may be the next one.
    fn operation(&mut self, stage: usize, words: [u32; 4]) {
        match (self.stages.get_mut(stage), self.rooms.get_mut(stage)) {
            (Some(stage), Some(room)) => {
                stage.operations.push(words);
                room.operation(&words);
            }
            _ => {
                self.pending.push(words);
                self.pending_room.operation(&words);
            }
        }
    }

    /// Adds an instruction on rows.
    pub fn row(&mut self, action: Action, out: u32, vectors: [u32; 3], numbers: [Number; 2]) {
        let (words, first) = self.words(action, out, vectors, numbers);
        let first = first.max(self.changes(out));
        let stage = self.rows_stage(first, |_| true);
        self.push(stage, words);
        self.uses(out).written = stage;
    }

    /// Adds a sum (or least, or worst) over the rows.
    pub fn sum(&mut self, action: Action, vectors: [u32; 3]) -> Number {
        let (mut words, first) = self.words(action, 0, vectors, [Number::Known(0.0); 2]);
        let stage = self.rows_stage(first.max(self.sums_floor), |rows| rows.kinds.len() < REDUCTIONS as usize);
        self.sums_floor = stage;
        let Some(Work::Rows(rows)) = self.stages.get_mut(stage).map(|stage| &mut stage.work) else {
            return Number::Known(f64::NAN);
        };
        let sum = rows.kinds.len() as u32;
        rows.kinds.push(action.kind());
        words[1] = sum;
        self.push(stage, words);
        let nth = number::new();
        let place = number::place(nth);
        self.operation(stage + 1, [Operation::Take as u32 | place << 8, sum, 0, 0]);
        self.ready.insert(place, stage + 1);
        if action == Action::Residual {
            self.looked_at = [vectors[0], vectors[1]];
        }
        Number::At(nth)
    }

    /// Adds the small problems of the pairs.
    pub fn pairs(&mut self, block: Block) {
        self.catch_up();
        let Block { x, w, g, out } = block;
        let read: Vec<u32> = [Some(x), w, g].into_iter().flatten().collect();
        let mut first = self.floor.max(self.changes(out));
        for vector in &read {
            first = first.max(self.uses(*vector).written);
        }
        let stage = self.rows_stage(first, |rows| rows.product.is_none() && rows.block.is_none());
        if let Some(Work::Rows(rows)) = self.stages.get_mut(stage).map(|stage| &mut stage.work) {
            rows.block = Some(block);
            self.rooms[stage].block(block);
        }
        self.sums_floor = stage.max(self.sums_floor);
        for vector in read {
            self.uses(vector).read = stage.max(self.uses(vector).read);
        }
        self.uses(out).written = stage;
    }

    /// Adds the local LCPs of the clusters, executed if a scalar is positive: `out` becomes the sum of their
    /// displacements, otherwise `instead`.
    pub fn clusters(&mut self, condition: Number, [x, g]: [u32; 2], tolerance: f64, [instead, out]: [u32; 2]) {
        self.catch_up();
        let [condition, tolerance] = [condition, Number::Known(tolerance)].map(|number| self.number(number));
        let clusters = Work::Clusters(Clusters { condition, tolerance, x, g });
        // Copies that depend on a scalar are executed with the sum.
        let mut before = Vec::new();
        let last = self.stages.len().wrapping_sub(1);
        let apart = |words: &Words| !words[1..5].contains(&out) && words[1] != instead;
        match self.copies().filter(|copies| copies.iter().all(apart)) {
            Some(copies) if self.known_at(condition) <= last => {
                before = copies.clone();
                self.stages[last].work = clusters;
                self.rooms[last] = Room::of(&self.stages[last]);
            }
            _ => self.begin(clusters),
        }
        self.begin(Work::Rows(Rows {
            gather: Some(Gather { condition, instead, out }),
            before: before.clone(),
            ..Rows::default()
        }));
        let last = self.stages.len() - 1;
        self.sums_floor = last;
        for vector in before.iter().flat_map(|words| words[1..5].to_vec()).chain([x, g, instead, out]) {
            self.uses(vector).read = last;
        }
        for out in before.iter().map(|words| words[1]).chain([out]) {
            self.uses(out).written = last;
        }
    }

    /// Adds `out = [q +] A x`, optionally with the rounding error `low` of `x`.
    pub fn product(&mut self, x: u32, low: Option<u32>, out: u32, add_q: bool) {
        self.catch_up();
        let exact = self.exact;
        // A kernel may have only eight buffers.
        if exact && self.pending.iter().any(|words| words[0] & 0xff == Operation::Look as u32) {
            self.begin(Work::Numbers);
        }
        let mut rows = Rows { product: Some(Product { out, add_q, exact }), ..Rows::default() };
        match self.choice(x) {
            // The copies that depend on the same scalars are executed with the product's rows.
            Some((choice, copies)) => {
                let last = self.stages.len() - 1;
                self.stages[last].work = choice;
                self.rooms[last] = Room::of(&self.stages[last]);
                rows.before = copies;
            }
            None => self.begin(Work::Bodies(Bodies { x, low, instead: None, exact })),
        }
        self.begin(Work::Rows(rows.clone()));
        let last = self.stages.len() - 1;
        self.sums_floor = last;
        let touched = rows.before.iter().flat_map(|words| words[1..5].to_vec()).chain([x]).chain(low);
        for vector in touched {
            self.uses(vector).read = last;
        }
        for out in rows.before.iter().map(|words| words[1]).chain([out]) {
            self.uses(out).written = last;
        }
    }

    /// The pass over the bodies that chooses its vector itself, and the copies of the last stage. `None` unless the
    /// last stage only has copies that depend on a scalar, one of which writes `x`.
    fn choice(&mut self, x: u32) -> Option<(Work, Vec<Words>)> {
        let copies = self.copies()?;
        let mut of_x = copies.iter().filter(|words| words[1] == x);
        let (Some(copy), None) = (of_x.next(), of_x.next()) else { return None };
        // The source must not be the target of another copy.
        let from = copy[2];
        let steady = copies.iter().all(|words| words[1] != from);
        let bodies = Bodies { x, low: None, instead: Some([copy[5], from]), exact: self.exact };
        steady.then(|| (Work::Bodies(bodies), copies.clone()))
    }

    /// The copies of the last stage, if it only has copies that depend on a scalar.
    fn copies(&self) -> Option<&Vec<Words>> {
        let last = self.stages.len().checked_sub(1).filter(|last| self.apart && *last >= self.floor)?;
        let Work::Rows(rows) = &self.stages[last].work else { return None };
        let alone = rows.product.is_none() && rows.gather.is_none() && rows.block.is_none() && rows.kinds.is_empty();
        let conditional = rows.before.iter().all(|words| words[0] == Action::CopyIf as u32);
        (alone && conditional).then_some(&rows.before)
    }

    /// Adds another stage.
    pub fn stage(&mut self, work: Work) {
        self.finish();
        self.begin(work);
        self.finish();
    }

    /// Records a check of a residual. Returns whether there was space.
    pub fn look(&mut self, residual: Number, tolerance: f64) -> bool {
        self.catch_up();
        if self.looks == LOOKS {
            return false;
        }
        let [residual, tolerance] = [residual, Number::Known(tolerance)].map(|number| self.number(number));
        let stage = self.known_at(residual).max(self.floor);
        let nth = self.looks_run + self.looks;
        self.looks += 1;
        let out = HALT + 1 + nth % LOOKS;
        self.operation(stage, [Operation::Look as u32 | out << 8, residual, tolerance, nth + 1]);
        self.look_at = Some(stage);
        for vector in self.looked_at {
            self.uses(vector).held = stage;
        }
        true
    }

    /// Ends the last stage, completes all sums and adds all operations.
    pub fn finish(&mut self) {
        self.catch_up();
        if !self.pending.is_empty() {
            self.begin(Work::Numbers);
        }
        self.floor = self.stages.len();
        self.ready.clear();
        self.vectors.clear();
    }

    /// Returns everything that is recorded.
    pub fn all(&mut self) -> Segment {
        self.finish();
        self.first(self.stages.len())
    }

    /// Returns the stages before the last check, which then needs no separate stage; everything if there are none.
    pub fn ready(&mut self) -> Segment {
        self.catch_up();
        match self
            .look_at
            .and_then(|stage| stage.checked_sub(1))
            .filter(|stage| self.apart && *stage >= self.floor.max(1))
        {
            Some(stages) => self.first(stages),
            None => self.all(),
        }
    }

    /// Returns the first stages.
    fn first(&mut self, count: usize) -> Segment {
        let rest = self.stages.split_off(count);
        let stages = std::mem::replace(&mut self.stages, rest);
        for (room, stage) in self.rooms.drain(..count).zip(&stages) {
            debug_assert_eq!(room.places(), Room::of(stage).places());
        }
        let looks = stages.iter().map(Stage::looks).sum();
        let kinds = stages.last().map_or_else(|| self.carried.clone(), Stage::kinds);
        let carried = std::mem::replace(&mut self.carried, kinds);
        let segment = Segment { stages, carried, run: self.run, looks_before: self.looks_run, looks };
        self.run = self.run.wrapping_add(count as u32);
        (self.looks, self.looks_run) = (self.looks - looks, self.looks_run + looks);
        let later = |stage: usize| stage.saturating_sub(count);
        (self.floor, self.sums_floor) = (later(self.floor), later(self.sums_floor));
        self.look_at = self.look_at.filter(|stage| *stage >= count).map(later);
        self.ready.retain(|_, stage| *stage >= count);
        self.ready.values_mut().for_each(|stage| *stage = later(*stage));
        for uses in &mut self.vectors {
            *uses = Uses { written: later(uses.written), read: later(uses.read), held: later(uses.held) };
        }
        segment
    }

    /// Drops everything that was recorded and not run.
    pub fn forget(&mut self) {
        self.catch_up();
        self.stages.clear();
        self.rooms.clear();
        self.pending.clear();
        self.pending_room = Room::default();
        self.carried.clear();
        self.ready.clear();
        self.vectors.clear();
        (self.looks, self.look_at, self.floor, self.sums_floor) = (0, None, 0, 0);
    }

    /// The vectors of the last residual: the iterate and its gradient.
    pub fn looked_at(&self) -> [u32; 2] {
        self.looked_at
    }

    /// An instruction, and the first stage at which all its inputs are known.
    fn words(&mut self, action: Action, out: u32, vectors: [u32; 3], numbers: [Number; 2]) -> (Words, usize) {
        self.catch_up();
        let [s, t] = numbers.map(|number| self.number(number));
        let [a, b, c] = vectors;
        let mut first = self.floor.max(self.known_at(s)).max(self.known_at(t));
        for vector in vectors {
            first = first.max(self.uses(vector).written);
        }
        ([action as u32, out, a, b, c, s, t, 0], first)
    }

    /// The first stage that may change a vector.
    fn changes(&mut self, vector: u32) -> usize {
        let Uses { written, read, held } = *self.uses(vector);
        written.max(read).max(held)
    }

    fn uses(&mut self, vector: u32) -> &mut Uses {
        let nth = vector as usize;
        if self.vectors.len() <= nth {
            self.vectors.resize(nth + 1, Uses::default());
        }
        &mut self.vectors[nth]
    }

    /// The first stage on rows, from one on, that fits; a new one if there is none.
    fn rows_stage(&mut self, first: usize, fits: impl Fn(&Rows) -> bool) -> usize {
        for nth in first..self.stages.len() {
            if let Work::Rows(rows) = &self.stages[nth].work
                && fits(rows)
                && !self.is_full(nth)
            {
                return nth;
            }
        }
        self.begin(Work::Rows(Rows::default()));
        self.stages.len() - 1
    }

    /// Adds a stage, with the operations that wait for it.
    fn begin(&mut self, work: Work) {
        let mut room = std::mem::take(&mut self.pending_room);
        room.work(&work);
        let operations = std::mem::take(&mut self.pending);
        self.stages.push(Stage { operations, work });
        self.rooms.push(room);
    }

    /// Whether one more instruction might exceed the parameters of a stage's dispatch.
    fn is_full(&self, nth: usize) -> bool {
        self.rooms[nth].is_full()
    }

    fn push(&mut self, stage: usize, words: Words) {
        for vector in [words[2], words[3], words[4]] {
            self.uses(vector).read = stage.max(self.uses(vector).read);
        }
        if let Some(Work::Rows(rows)) = self.stages.get_mut(stage).map(|stage| &mut stage.work) {
            if rows.block.is_some() {
                rows.after.push(words)
            } else {
                rows.before.push(words)
            }
            self.rooms[stage].instruction(&words);
        }
    }
}
