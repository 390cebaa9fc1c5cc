//! A team of several processes.

use super::part::WORK_OF_A_BODY;
use super::{Domain, MARGIN, Part, Step};
use crate::backend::cpu::Cpu;
use crate::backend::cpu::setup::Setup;
use crate::backend::cpu::start::Start;
use crate::backend::cpu::team::{LocalProblem, Team, Worst, all_places};
use crate::backend::cpu::trouble::Trouble;
use crate::bodies::{Bodies, Lineage};
use crate::broad_phase::{Aabb, Candidates};
use crate::constraint::{RowSource, RowSourceError};
use crate::dynamics::{Twist, Waiting};
use crate::lcp::gathered::OfDomain;
use crate::periodic::CellShear;
use crate::processes::{Processes, STEP};
use crate::step::{
    Divided, Effect, Fault, LIFE_WORDS, Lives, Model, Overlap, Piece, Rows, State, StepReport, Stepping,
    farthest_and_thinnest, may_pass,
};
use crate::walls::{Walls, surface_of};
use crate::warm::Warm;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};

/// What a process that has a part of the bodies starts from.
pub(crate) struct LocalState {
    pub part: Part,
    /// The cutoff and the smallest thickness of all bodies.
    pub cutoff: f64,
    pub thinnest: f64,
}

/// Whether the bodies of a simulation can be distributed. Rows of sub-spheres and of the paper cannot. Nor can bonds
/// under the midpoint rule: a bond there pulls from positions that other bonds have moved.
pub(crate) fn shares(model: &Model, processes: Processes) -> bool {
    let rows_of_surfaces = model.contact.rows_of_method() == Rows::Auto
        && matches!(model.contact.method.row_source(), RowSource::Surfaces);
    let bonds_in_middle = model.time.stepping == Stepping::Midpoint && !model.bonds.is_empty();
    processes.size() > 1 && rows_of_surfaces && !bonds_in_middle
}

impl<const D: usize> Cpu<D, Domain> {
    /// A backend of one process of several. Steps are distributed if `shares` allows it and there are enough bodies.
    /// `local` is this process's part of the state; none if every process has all bodies.
    pub(crate) fn together(
        model: &Model,
        state: State,
        (processes, shares): (Processes, bool),
        local: Option<LocalState>,
    ) -> Result<Self, RowSourceError> {
        let of_all = local.as_ref().map(|local| (local.cutoff, local.thinnest));
        let team = Domain::new(processes, shares, local.map(|local| local.part));
        let mut cpu = Cpu::of_team(model, state, team)?;
        if let Some(of_all) = of_all {
            (cpu.setup.cutoff, cpu.setup.thinnest) = of_all;
        }
        Ok(cpu)
    }
}

impl Team for Domain {
    type Portion<const D: usize> = OfDomain<D>;

    fn announce_step(&mut self) {
        if self.processes.rank() == 0 && self.processes.size() > 1 {
            self.processes.broadcast(&[STEP]);
        }
    }

    fn check_agreement(&mut self, stepped: Result<StepReport, Fault>) -> Result<StepReport, Fault> {
        if self.processes.size() == 1 {
            return stepped;
        }
        let mut all = vec![0; self.processes.size()];
        self.processes.all_gather_even(&[digest(&stepped)], &mut all);
        match all.iter().position(|other| *other != all[0]) {
            Some(other) => Err(Fault::Processes(format!(
                "rank {other} computed other numbers than rank 0: its processor or its mathematical library differs"
            ))),
            None => stepped,
        }
    }

    fn needs_retry(&self) -> bool {
        self.retry
    }

    fn work_alone(&mut self, state: &mut State) -> bool {
        let shared = self.is_distributed();
        self.make_whole(state);
        self.alone = true;
        shared
    }

    fn work_together(&mut self) {
        self.alone = false;
    }

    fn begin(&mut self, setup: &Setup, start: &mut Start, state: &mut State, taken: (Piece, Waiting)) {
        if self.take_up(state) {
            start.begin(setup, state, &self.by_place(&state.warm), taken);
            self.leave_own(start);
            let mothers = start.divide(setup);
            self.number_daughters(start, state, &mothers);
        } else {
            start.begin(setup, state, &state.warm, taken);
            start.divide(setup);
        }
    }

    fn distribute<'a, const D: usize>(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &'a State,
    ) -> LocalProblem<'a, OfDomain<D>> {
        match self.share(setup, start, state) {
            Some(taken) => {
                LocalProblem { places: taken.places, portion: OfDomain::of(taken.domain), warm: Cow::Owned(taken.warm) }
            }
            None => LocalProblem {
                places: all_places(setup, start),
                portion: OfDomain::default(),
                warm: Cow::Borrowed(&state.warm),
            },
        }
    }

    fn is_distributed(&self) -> bool {
        self.step.is_some()
    }

    fn candidates<'a>(&'a mut self, all: &'a mut Candidates, boxes: &[Aabb]) -> Result<&'a [[u32; 2]], Fault> {
        if !self.contains(boxes) {
            return Err(Fault::Processes("a body left its halo".into()));
        }
        match &self.step {
            Some(step) => Ok(&step.pairs),
            None => Ok(all.ensure(boxes)),
        }
    }

    fn exchange<const N: usize>(&self, of_body: &mut [[f64; N]]) {
        let Some(Step { part, .. }) = &self.step else { return };
        let pack = |places: &[u32]| places.iter().flat_map(|body| of_body[*body as usize]).collect();
        let out: Vec<(usize, Vec<f64>)> = part.out.iter().map(|(to, places)| (*to, pack(places))).collect();
        let room = |(from, places): &(usize, Vec<u32>)| (*from, vec![0.0; N * places.len()]);
        let mut into: Vec<(usize, Vec<f64>)> = part.into.iter().map(room).collect();
        self.processes.exchange(&out, &mut into, || {});
        for ((_, places), (_, numbers)) in part.into.iter().zip(&into) {
            places
                .iter()
                .zip(numbers.as_chunks::<N>().0)
                .for_each(|(body, numbers)| of_body[*body as usize] = *numbers);
        }
    }

    fn first_trouble(&self, own: Option<Trouble>) -> Option<Trouble> {
        if self.is_distributed() { self.first_of_all(own) } else { own }
    }

    fn max(&self, own: f64) -> f64 {
        if self.is_distributed() { self.largest_of_all(own) } else { own }
    }

    fn any(&self, own: bool) -> bool {
        self.max(f64::from(u8::from(own))) > 0.0
    }

    fn all_overlaps(&self, own: Overlap, worst: impl FnOnce() -> Option<Worst>, walls: &Walls) -> Overlap {
        if self.is_distributed() { self.overlaps_of_all(own, worst(), walls) } else { own }
    }

    fn all_effects(&self, own: Effect) -> Effect {
        if self.is_distributed() { self.effects_of_all(own) } else { own }
    }

    fn moving_bodies<'a>(
        &self,
        bodies: &'a Bodies,
        twist: &'a [Twist],
        interval_and_shear: (f64, Option<CellShear>),
    ) -> Option<(Cow<'a, Bodies>, Cow<'a, [Twist]>)> {
        if !self.is_distributed() {
            return Some((Cow::Borrowed(bodies), Cow::Borrowed(twist)));
        }
        let [farthest, thinnest] = farthest_and_thinnest(bodies, twist, interval_and_shear);
        if !may_pass(self.max(farthest), -self.max(-thinnest)) {
            return None;
        }
        // Fast bodies can meet beyond any halo.
        let (bodies, twist) = self.all_moving(bodies, twist)?;
        Some((Cow::Owned(bodies), Cow::Owned(twist)))
    }

    fn with_global_indices(&self, warm: Vec<Warm>) -> Vec<Warm> {
        let Some(Step { part, .. }) = &self.step else { return warm };
        let number = |body: u32| surface_of(body).map_or_else(|| part.members[body as usize], |_| body);
        warm.into_iter().map(|warm| Warm { pair: warm.pair.map(number), ..warm }).collect()
    }

    fn finish_step(&mut self, setup: &Setup, end: &mut Bodies, rows: impl Iterator<Item = u32>) {
        // The next step uses the cost of own bodies and how far they went.
        let Some(Step { mut part, went, .. }) = self.step.take() else { return };
        part.work.fill(WORK_OF_A_BODY);
        rows.for_each(|body| part.work[body as usize] += 1.0);
        part.way = went.iter().map(|went| MARGIN * went).collect();
        if !setup.bonds.is_empty() {
            // Several processes can have the same bond.
            let broken: Vec<u64> = end.broken_bonds.iter().map(|bond| u64::from(*bond)).collect();
            let broken: BTreeSet<u64> = self.processes.all_gather(&broken).into_iter().collect();
            end.broken_bonds = broken.into_iter().map(|bond| bond as u32).collect();
        }
        self.part = Some(part);
        self.ways.clear();
        self.divided = Some(std::mem::take(&mut self.dividing));
    }

    fn body_count(&self, local: usize) -> usize {
        self.part.as_ref().map_or(local, |part| part.all)
    }

    fn whole_state<'a>(&'a self, setup: &Setup, state: &'a State) -> &'a State {
        self.gather_state(setup, state)
    }

    fn all_bodies<'a>(&'a self, local: &'a Bodies) -> &'a Bodies {
        self.gather_bodies(local)
    }

    fn known_bodies<'a>(&self, local: &'a Bodies) -> Option<&'a Bodies> {
        self.part.is_none().then_some(local)
    }

    fn lives<'a>(&self, local: &'a Bodies) -> Lives<'a> {
        let Some(part) = &self.part else { return Lives::of_all(&local.lineage, &local.group) };
        let number = |i: usize| part.is_own(i).then(|| part.members[i] as usize);
        Lives::of_some(&local.lineage, &local.group, (0..local.len()).map(number).collect())
    }

    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]> {
        if self.part.is_none() {
            return own;
        }
        let mut all = self.processes.all_gather(own.as_flattened()).as_chunks().0.to_vec();
        all.sort_unstable();
        all
    }

    fn divided(&mut self, local: &Bodies, before: &[Lineage]) -> Vec<Divided> {
        // After a distributed step the owners have recorded the divisions.
        self.divided.take().unwrap_or_else(|| {
            let lines = self.lines_before.take();
            Divided::between(lines.as_deref().unwrap_or(before), &local.lineage, &local.group)
        })
    }

    fn reset(&mut self) {
        (self.part, self.step, self.retry, self.divided) = (None, None, false, None);
        self.ways.clear();
        self.drop_gathered();
    }

    fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        self.remove_local(state, keep, removed);
    }
}

/// A hash of a step's outcome.
fn digest(stepped: &Result<StepReport, Fault>) -> u64 {
    let mut hasher = DefaultHasher::new();
    match stepped {
        Ok(report) => {
            let StepReport { step, bodies, constraints, iterations, products, max_overlap, residual, .. } = report;
            (step, bodies, constraints, iterations, products).hash(&mut hasher);
            [max_overlap, residual].map(|number| number.to_bits()).hash(&mut hasher);
        }
        Err(fault) => fault.to_string().hash(&mut hasher),
    }
    hasher.finish()
}
