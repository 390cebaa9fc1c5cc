//! The verbs on the device. They append to the tape; only a read executes it.

use super::layout::{FrictionSlots, HALT, LOOKS};
use super::machine::{Confirmation, Machine, Task};
use super::number::Number;
use super::problem::DeviceProblem;
use super::stage::{Action, Block, Bodies, Segment, Work};
use super::tape::Tape;
use crate::gpu::{Gpu, GpuError};
use crate::lcp::friction::Measured;
use crate::lcp::verbs::{Checks, InClusters, Metric, Verbs};
use std::collections::VecDeque;

/// A diagonal entry of at most this many squared rounding errors of the largest belongs to a zero row, as on the CPU.
const ZERO_ROW: f64 = 1.0;

/// The offset of a vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Slot {
    at: Option<u32>,
    /// The offset of the rounding error of the vector.
    low: Option<u32>,
    /// Whether that part is used.
    in_two: bool,
}

impl Slot {
    /// The offset of the second part, if there is one.
    fn second(&self) -> Option<u32> {
        self.low.filter(|_| self.in_two)
    }
}

/// One problem on a device.
pub(crate) struct Device<'a> {
    gpu: &'a Gpu,
    machine: &'a mut Machine,
    problem: &'a DeviceProblem,
    pub(super) tape: Tape,
    /// The number of vectors so far.
    vectors: u32,
    products: u64,
    /// The number of products at each check that was not read.
    looked: VecDeque<u64>,
    /// The second part of the iterate of the last residual.
    looked_at_low: Option<u32>,
    /// Whether a check was recorded since the last ones were read.
    noted: bool,
    /// Whether a batch was read.
    begun: bool,
    /// The number of checks that were read.
    looks_read: usize,
    /// Whether no check has ended a batch whose remaining stages must still be skipped.
    afresh: bool,
    /// The recomputed residual at the last check, if it was confirmed.
    confirmed: Option<(Number, f64)>,
    fault: Option<GpuError>,
    /// Whether the problem's clusters were created.
    has_clusters: bool,
    /// The last residual of the law of friction, and what it is made of.
    measured: Option<(Number, Measured<Number>)>,
}

impl<'a> Device<'a> {
    pub fn new(gpu: &'a Gpu, machine: &'a mut Machine, problem: &'a DeviceProblem) -> Self {
        let vectors = machine.slots().free;
        // Drops arithmetic that remains of a solve that ended early.
        super::number::drain(&mut Vec::new());
        super::number::take_misuse();
        let (apart, exact) = (!machine.is_small(problem), machine.slots().low.is_some());
        Device {
            gpu,
            machine,
            problem,
            tape: Tape::new(apart, exact),
            vectors,
            products: 0,
            looked: VecDeque::new(),
            looked_at_low: None,
            noted: false,
            begun: false,
            looks_read: 0,
            afresh: true,
            confirmed: None,
            fault: None,
            has_clusters: false,
            measured: None,
        }
    }

    /// Reads the problem and inverts its diagonals.
    pub fn prepare(&mut self) {
        self.tape.stage(Work::PrepareRows);
        let slots = self.machine.slots();
        let largest = self.tape.sum(Action::Largest, [slots.diagonal; 3]);
        let zero = largest * Number::Known(ZERO_ROW * self.rounding() * self.rounding());
        let none = Number::Known(0.0);
        let inverted = if slots.friction.is_some() { slots.inverse } else { slots.diagonal };
        self.tape.row(Action::Invert, slots.inverse, [slots.diagonal, inverted, inverted], [zero, none]);
        if let Some([majorant, inverse]) = slots.majorant {
            self.tape.row(Action::Invert, inverse, [slots.diagonal, majorant, majorant], [zero, none]);
        }
        if slots.has_blocks() {
            self.tape.stage(Work::PreparePairs);
        }
    }

    /// The vector of the iterate, which [`Device::prepare`] fills.
    pub fn start(&self) -> Slot {
        let slots = self.machine.slots();
        Slot { at: Some(slots.x), low: slots.low, in_two: slots.low.is_some() }
    }

    fn friction(&self) -> Option<FrictionSlots> {
        self.machine.slots().friction
    }

    /// Adds the compliances to a product.
    fn comply(&mut self, x: u32, out: u32) {
        if let Some(friction) = self.friction() {
            self.tape.row(Action::Comply, out, [out, x, friction.compliance], [NONE; 2]);
        }
    }

    /// The last residual of the law of friction, and what it is made of; none since iterations were dropped.
    pub fn measured(&self) -> Option<(Number, Measured<Number>)> {
        self.measured
    }

    /// If a scalar is positive, the corrections of contacts with friction follow the slips of the gradient `g`, which
    /// moves along, and so does `q`.
    pub fn follow(&mut self, due: Number, g: &mut Slot) {
        let Some(FrictionSlots { correction, .. }) = self.friction() else { return };
        let (q, g) = (self.machine.slots().q, self.out(g));
        self.tape.row(Action::Follow, correction, [correction, g, g], [due, NONE]);
        for moved in [g, q] {
            self.tape.row(Action::Correct, moved, [moved, correction, correction], [NONE; 2]);
        }
    }

    /// Copies the result into the problem.
    pub fn finish(&mut self, x: &Slot) -> Result<(), GpuError> {
        let (x, low) = (at(x), x.second());
        self.tape.stage(Work::Bodies(Bodies { x, low, instead: None, exact: self.tape.exact() }));
        self.tape.stage(Work::Export { x });
        self.run(Vec::new());
        self.fault.clone().map_or(Ok(()), Err)
    }

    /// Runs everything that is recorded, and reads scalars.
    fn run(&mut self, read: Vec<std::ops::Range<u32>>) -> Vec<f64> {
        let segment = self.tape.all();
        self.run_segment(&segment, None, read)
    }

    /// Runs a part of what is recorded, and reads scalars.
    fn run_segment(
        &mut self,
        segment: &Segment,
        confirm: Option<Confirmation>,
        read: Vec<std::ops::Range<u32>>,
    ) -> Vec<f64> {
        if let (None, Some(misuse)) = (&self.fault, super::number::take_misuse()) {
            self.fault = Some(GpuError::Refused { message: misuse.into() });
        }
        let count = read.iter().map(|range| range.len()).sum();
        let task = Task { vectors: self.vectors, afresh: std::mem::take(&mut self.afresh), confirm, read };
        if self.fault.is_none() {
            match self.machine.run(self.gpu, self.problem, segment, self.tape.constants(), &task) {
                Ok(numbers) => return numbers,
                Err(fault) => self.fault = Some(fault),
            }
        }
        vec![f64::NAN; count]
    }

    /// The offset of a vector to be written.
    fn out(&mut self, slot: &mut Slot) -> u32 {
        slot.in_two = false;
        *slot.at.get_or_insert_with(|| {
            self.vectors += 1;
            self.vectors - 1
        })
    }

    /// The offset of the second part of a vector, which is allocated if necessary.
    fn second_out(&mut self, slot: &mut Slot) -> u32 {
        slot.in_two = true;
        *slot.low.get_or_insert_with(|| {
            self.vectors += 1;
            self.vectors - 1
        })
    }

    /// A new vector with these numbers, for tests.
    #[cfg(test)]
    pub fn uploaded(&mut self, numbers: &[f64]) -> Slot {
        let mut slot = Slot::default();
        let out = self.out(&mut slot);
        self.run(Vec::new());
        self.machine.write(self.gpu, self.problem, out, numbers).unwrap();
        slot
    }

    /// A vector's numbers, for tests.
    #[cfg(test)]
    pub fn downloaded(&mut self, slot: &Slot) -> Vec<f64> {
        self.run(Vec::new());
        self.machine.read(self.gpu, self.problem, at(slot)).unwrap()
    }

    fn metric(&self, metric: Metric) -> [u32; 2] {
        let slots = self.machine.slots();
        match (metric, slots.majorant) {
            (Metric::Majorant, Some(majorant)) => majorant,
            _ => [slots.diagonal, slots.inverse],
        }
    }
}

/// The offset of a vector. For a vector that was never written, it is that of the first.
fn at(slot: &Slot) -> u32 {
    slot.at.unwrap_or(0)
}

const NONE: Number = Number::Known(0.0);
const ONE: Number = Number::Known(1.0);

impl Verbs for Device<'_> {
    type Vector = Slot;
    type Scalar = Number;

    fn number(&mut self, x: f64) -> Number {
        super::number::made(x)
    }

    fn clear(&mut self, x: &mut Slot) {
        let out = self.out(x);
        self.tape.row(Action::Zero, out, [out; 3], [NONE; 2]);
    }

    fn copy(&mut self, from: &Slot, to: &mut Slot) {
        let (second, out) = (from.second(), self.out(to));
        self.tape.row(Action::Copy, out, [at(from); 3], [NONE; 2]);
        if let Some(second) = second {
            let out = self.second_out(to);
            self.tape.row(Action::Copy, out, [second; 3], [NONE; 2]);
        }
    }

    fn copy_if_positive(&mut self, condition: Number, from: &Slot, to: &mut Slot) {
        let (second, other) = (from.second(), to.second());
        let out = self.out(to);
        self.tape.row(Action::CopyIf, out, [at(from), at(from), out], [condition, NONE]);
        match (second, other) {
            (None, None) => {}
            (Some(second), Some(_)) => {
                let out = self.second_out(to);
                self.tape.row(Action::CopyIf, out, [second, second, out], [condition, NONE]);
            }
            _ => super::number::report("a solver mixes vectors in one part and in two"),
        }
    }

    fn take(&mut self, from: &mut Slot, to: &mut Slot) {
        // The offsets stay, so that the iterate is found even if the rest of a batch was skipped.
        self.copy(from, to);
    }

    fn product(&mut self, x: &Slot, ax: &mut Slot) {
        self.products += 1;
        let out = self.out(ax);
        self.tape.product(at(x), None, out, false);
        self.comply(at(x), out);
    }

    fn gradient(&mut self, x: &Slot, g: &mut Slot) {
        self.products += 1;
        let out = self.out(g);
        self.looked_at_low = x.second();
        self.tape.product(at(x), x.second(), out, true);
        self.comply(at(x), out);
    }

    fn dot(&mut self, x: &Slot, y: &Slot) -> Number {
        self.tape.sum(Action::Dot, [at(x), at(y), at(y)])
    }

    fn twice_objective(&mut self, x: &Slot, g: &Slot) -> Number {
        self.tape.sum(Action::Objective, [at(x), at(g), self.machine.slots().q])
    }

    fn combine(&mut self, a: Number, x: &Slot, b: Number, y: &Slot, out: &mut Slot) {
        let out = self.out(out);
        self.tape.row(Action::Combine, out, [at(x), at(y), at(y)], [a, b]);
    }

    fn add(&mut self, a: Number, x: &Slot, y: &mut Slot) {
        let out = self.out(y);
        self.tape.row(Action::Combine, out, [at(x), out, out], [a, ONE]);
    }

    fn proximal(&mut self, metric: Metric, x: &Slot, step: Number, g: &Slot, out: &mut Slot) {
        let out = self.out(out);
        let [_, inverse] = self.metric(metric);
        self.tape.row(Action::Proximal, out, [at(x), at(g), inverse], [step, NONE]);
    }

    fn descend(&mut self, x: &Slot, g: &Slot, out: &mut Slot) {
        let out = self.out(out);
        self.tape.pairs(Block { x: at(x), w: None, g: Some(at(g)), out });
    }

    fn displace(&mut self, x: &Slot, terms: [(Number, &Slot); 3], out: &mut Slot, _: &mut Slot) {
        let [(a, first), (b, second), (c, third)] = terms.map(|(number, slot)| (number, at(slot)));
        let out = self.out(out);
        self.tape.row(Action::Combine, out, [first, second, second], [a, b]);
        self.tape.row(Action::Combine, out, [third, out, out], [c, ONE]);
        self.tape.pairs(Block { x: at(x), w: Some(out), g: None, out });
    }

    fn advance(&mut self, a: Number, d: &Slot, x: &mut Slot, _: &mut Slot) {
        let second = x.second();
        let out = self.out(x);
        if let Some(low) = second {
            // Before the first part changes.
            self.tape.row(Action::AdvanceLow, low, [out, at(d), low], [a, NONE]);
            x.in_two = true;
        }
        self.tape.row(Action::Advance, out, [out, at(d), at(d)], [a, NONE]);
    }

    fn square(&mut self, metric: Metric, x: &Slot) -> Number {
        let [diagonal, _] = self.metric(metric);
        self.tape.sum(Action::Triple, [at(x), at(x), diagonal])
    }

    fn inverse_square(&mut self, metric: Metric, x: &Slot) -> Number {
        let [_, inverse] = self.metric(metric);
        self.tape.sum(Action::Triple, [at(x), at(x), inverse])
    }

    fn ratio_test(&mut self, x: &Slot, d: &Slot) -> Number {
        self.tape.sum(Action::Room, [at(x), at(d), at(d)])
    }

    fn residual(&mut self, x: &Slot, g: &Slot) -> Number {
        let Some(FrictionSlots { correction, .. }) = self.friction() else {
            return self.tape.sum(Action::Residual, [at(x), at(g), self.machine.slots().diagonal]);
        };
        let law = self.tape.sum(Action::Residual, [at(x), at(g), correction]);
        let cones = self.tape.sum(Action::ResidualHeld, [at(x), at(g), at(g)]);
        let change = self.tape.sum(Action::Off, [at(g), correction, correction]);
        self.measured = Some((law, Measured { cones, change }));
        law
    }

    fn read(&mut self, scalar: Number) -> f64 {
        match scalar {
            Number::Known(x) => x,
            Number::Tolerance => self.machine.tolerance,
            Number::At(nth) => {
                let place = super::number::place(nth);
                self.run(std::iter::once(place..place + 1).collect())[0]
            }
        }
    }

    fn check(&mut self, residual: Number, tolerance: f64) {
        if self.tape.look(residual, tolerance) {
            self.looked.push_back(self.products);
            self.noted = true;
        }
    }

    fn take_checks(&mut self) -> Checks {
        let segment = if std::mem::take(&mut self.noted) { self.tape.ready() } else { self.tape.all() };
        self.begun = true;
        let [x, g] = self.tape.looked_at();
        let fresh = super::number::new();
        let place = super::number::place(fresh);
        let confirm = Confirmation { x, low: self.looked_at_low, g, residual: place };
        let read = vec![HALT..HALT + 1 + LOOKS, place..place + 1];
        let numbers = self.run_segment(&segment, Some(confirm), read);
        let (halt, residuals, confirmed) = (numbers[0], &numbers[1..=LOOKS as usize], numbers[1 + LOOKS as usize]);
        let ended = halt >= 1.0;
        let looks = if ended { halt as u32 - segment.looks_before } else { segment.looks };
        let residual = |nth: u32| residuals[((segment.looks_before + nth) % LOOKS) as usize];
        let residuals: Vec<f64> = (0..looks).map(residual).collect();
        let products = self.looked.drain(..residuals.len().min(self.looked.len())).next_back();
        self.confirmed = None;
        self.looks_read = segment.looks_before as usize + residuals.len();
        if ended {
            self.machine.last_looks = self.looks_read;
            self.products = products.unwrap_or(self.products);
            self.confirmed = Some((Number::At(fresh), confirmed));
            self.tape.forget();
            self.measured = None;
            self.looked.clear();
            self.afresh = true;
        }
        Checks { residuals, ended }
    }

    fn confirm(&mut self, x: &Slot, g: &mut Slot) -> (Number, f64) {
        if let Some(confirmed) = self.confirmed.take() {
            self.products += 1;
            return confirmed;
        }
        self.gradient(x, g);
        let residual = self.residual(x, g);
        (residual, self.read(residual))
    }

    fn checks_at_once(&self) -> usize {
        let [first, later] = self.machine.looks;
        match (self.tape.is_apart(), self.begun) {
            (true, begun) => [first, later][usize::from(begun)],
            // The work after the last check of a small problem is recorded in vain.
            (false, false) => expected(self.machine.last_looks).min(first),
            (false, true) => self.looks_read.clamp(first, later.max(first)),
        }
    }

    fn rounding(&self) -> f64 {
        self.machine.precision().epsilon()
    }

    fn products(&self) -> u64 {
        self.products
    }
}

/// The expected number of checks of a solve, from that of the last one, with some to spare.
fn expected(last: usize) -> usize {
    last + last / 4 + 2
}

impl InClusters for Device<'_> {
    fn descend_in_clusters(
        &mut self,
        condition: Number,
        point: [&Slot; 2],
        tolerance: f64,
        by_pairs: &Slot,
        out: &mut Slot,
    ) {
        if !std::mem::replace(&mut self.has_clusters, true)
            && let Err(fault) = self.machine.make_clusters(self.gpu, self.problem)
        {
            self.fault.get_or_insert(fault);
        }
        let out = self.out(out);
        self.tape.clusters(condition, point.map(at), tolerance, [at(by_pairs), out]);
    }
}
