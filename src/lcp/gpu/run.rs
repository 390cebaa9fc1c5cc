//! One run of a segment: its dispatches in order.

use super::kernels::{Lcp, LcpArgs};
use super::layout::{Parameters, REDUCTIONS};
use super::machine::Machine;
use super::memory::Memory;
use super::problem::DeviceProblem;
use super::shape::{ShapeWork, StageArguments};
use super::stage::{Segment, Stage, Work};
use super::straight::{Part, Rounds};
use crate::gpu::{Recorder, Size, WORKGROUP};
use crate::lcp::clusters::LOCAL_STEPS;
use std::ops::Range;

/// One run of one segment.
pub(super) struct Run<'a, 'g> {
    machine: &'a Machine,
    problem: &'a DeviceProblem,
    pub record: Recorder<'g>,
    base: Parameters,
    /// The numbers of workgroups for rows and for bodies.
    groups: [u64; 2],
    /// The numbers of rows and of bodies beyond one per invocation.
    beyond: [u64; 2],
    /// Whether a check was recorded, so that the remaining stages may be skipped.
    looked: bool,
}

impl<'a, 'g> Run<'a, 'g> {
    pub fn new(machine: &'a Machine, problem: &'a DeviceProblem, record: Recorder<'g>, groups: [u64; 2]) -> Self {
        let items = [problem.rows, problem.bodies];
        let base = Parameters {
            rows: problem.rows as u32,
            pairs: problem.pairs as u32,
            bodies: problem.bodies as u32,
            stride: problem.stride() as u32,
            groups: groups[0] as u32,
            ..Parameters::default()
        };
        let beyond = [0, 1].map(|grid| items[grid].saturating_sub(groups[grid] * u64::from(WORKGROUP)));
        Run { machine, problem, record, base, groups, beyond, looked: false }
    }

    fn call(&mut self, kernel: Option<&Lcp>, size: impl Into<Size<'a>>, dispatch: Parameters) {
        let (memory, problem) = (&self.machine.memory, self.problem);
        if let Some(kernel) = kernel {
            kernel.call(&mut self.record, size, LcpArgs { dispatch, memory, problem });
        }
    }

    /// Records one dispatch per stage.
    pub fn large(&mut self, segment: &Segment, confirmation: &[Stage], arguments: &[StageArguments]) {
        // Where a stage stores its partial sums: in alternating ranges, because those of the stage before are still
        // needed.
        let part = |nth: u64| (nth * u64::from(REDUCTIONS) * self.groups[0]) as u32;
        let [even, odd, last] = [0, 1, 2].map(part);
        let mut looks = segment.looks_before;
        let mut into_odd = segment.run % 2 == 1;
        let (own, after) = arguments.split_at(segment.stages.len().min(arguments.len()));
        for (stage, arguments) in segment.stages.iter().zip(own) {
            let (sums_from, sums_into) = if into_odd { (even, odd) } else { (odd, even) };
            let parameters = Parameters { looks, sums_from, sums_into, ..self.base };
            self.stage(stage, arguments, parameters);
            looks += stage.looks();
            into_odd = !into_odd;
        }
        for (stage, arguments) in confirmation.iter().zip(after) {
            let parameters = Parameters { looks, sums_from: last, sums_into: last, ..self.base };
            self.stage(stage, arguments, parameters);
        }
    }

    fn stage(&mut self, stage: &Stage, arguments: &StageArguments, parameters: Parameters) {
        self.record.stage(stage.name());
        let (kernels, problem) = (&self.machine.kernels, self.problem);
        match stage.work {
            Work::PrepareRows => {
                self.call(kernels.prepare_rows.as_ref(), problem.rows, self.base);
                self.call(kernels.prepare_entries.as_ref(), 2 * problem.rows, self.base);
            }
            Work::PreparePairs => self.call(kernels.prepare_pairs.as_ref(), problem.pairs, self.base),
            Work::Export { x } => self.export(x),
            Work::Clusters(_) | Work::Numbers | Work::Rows(_) | Work::Bodies(_) => self.dispatch(arguments, parameters),
        }
    }

    /// Dispatches a stage: directly until a check may have ended the batch, then indirectly. A workgroup of a cluster
    /// tests this itself.
    fn dispatch(&mut self, arguments: &StageArguments, mut parameters: Parameters) {
        let (machine, shape) = (self.machine, &arguments.shape);
        parameters.base = arguments.base;
        parameters.pass(&arguments.vectors, &arguments.numbers);
        let grid = usize::from(shape.is_bodies());
        let (mut groups, mut beyond) = (self.groups[grid], self.beyond[grid]);
        match shape.work {
            ShapeWork::Numbers => (groups, beyond) = (1, 0),
            ShapeWork::Clusters { .. } => {
                let clusters = machine.clusters_made;
                parameters.first = clusters as u32;
                // Each step takes about as long as another stage.
                (groups, beyond) = (clusters.max(1), LOCAL_STEPS as u64 * clusters * u64::from(WORKGROUP));
            }
            ShapeWork::Rows { .. } | ShapeWork::Bodies { .. } => {}
        }
        self.record.weigh(beyond);
        let size = match self.looked && !shape.looks() && !shape.confirms && !shape.is_clusters() {
            true => Size::Indirect { said: &machine.memory.grid, offset: 12 * grid as u64, expected: groups },
            false => Size::Groups(groups),
        };
        self.call(machine.kernels.stage(shape), size, parameters);
        self.looked |= shape.looks();
    }

    /// One workgroup executes all stages, in dispatches of limited length.
    pub fn small(&mut self, parts: &[Part]) {
        let (kernels, problem) = (&self.machine.kernels, self.problem);
        for part in parts {
            match part {
                Part::Turns { range, confirms } => {
                    self.record.stage("lcp-small");
                    self.in_one_workgroup(kernels.small.as_ref(), range.clone(), *confirms);
                }
                Part::Rounds(rounds) => self.rounds(rounds),
                Part::Other(Work::PrepareRows) => {
                    self.call(kernels.prepare_rows.as_ref(), problem.rows, self.base);
                    self.make_lists();
                }
                Part::Other(Work::PreparePairs) => {
                    self.call(kernels.prepare_pairs.as_ref(), problem.pairs, self.base);
                }
                Part::Other(Work::Export { x }) => self.export(*x),
                Part::Other(_) => {}
            }
        }
    }

    fn rounds(&mut self, Rounds { shapes, first, rounds, at_once }: &Rounds) {
        let kernel = self.machine.kernels.straight(shapes);
        let place = |round: u32| first + round * shapes.len() as u32;
        self.record.stage("lcp-rounds");
        for round in (0..*rounds).step_by(*at_once as usize) {
            self.in_one_workgroup(kernel, place(round)..place((round + at_once).min(*rounds)), false);
        }
    }

    fn in_one_workgroup(&mut self, kernel: Option<&Lcp>, range: Range<u32>, confirms: bool) {
        let (first, last) = (range.start, range.end);
        let parameters = Parameters { first, last, looks: u32::from(confirms), ..self.base };
        self.call(kernel, Size::Groups(1), parameters);
    }

    /// All lists in one buffer, because a kernel may have only eight.
    fn make_lists(&mut self) {
        let (problem, lists) = (self.problem, &self.machine.memory.lists);
        let parts = [
            (&problem.pair, 2 * problem.rows),
            (&problem.block_start, problem.pairs + 1),
            (&problem.incidence_start, problem.bodies + 1),
            (&problem.incidence, 2 * problem.rows),
        ];
        let mut to = 0;
        for (part, words) in parts {
            self.record.copy(part, 0, lists, 4 * to, 4 * words);
            to += words;
        }
    }

    fn export(&mut self, x: u32) {
        let Memory { vectors, gammas, .. } = &self.machine.memory;
        let (element, with_friction) = (vectors.element() as u64, self.machine.slots().friction.is_some());
        let from = u64::from(x) * u64::from(self.base.stride) * element;
        let to = if with_friction { gammas } else { &self.problem.gamma };
        self.record.copy(vectors, from, to, 0, self.problem.rows * element);
    }
}
