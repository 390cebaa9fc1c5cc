//! Islands: rows that share moving bodies, directly or through others.
//!
//! Bodies of different islands do not act on each other, so each island is an LCP of its own, and the residual of all
//! rows is the largest of theirs. Solved together, all iterate as long as the slowest one, and a later LCP of a step,
//! which has new rows in few of them, iterates on all. So each is solved by itself, with `auto`, and one that a later
//! LCP leaves as it was and solved tightly enough is not solved again.
//!
//! Small islands are solved together, in groups of neighbours: a solve has costs beside its rows. Problems of one
//! island, or of one that has nearly all rows, are solved as a whole. Groups are solved by one thread each, large ones
//! by all threads in turn; neither changes bits.

mod groups;

use super::auto::Auto;
use super::cone::worse;
use super::cpu::Cpu;
use super::drive::Drive;
use super::engine::Task;
use super::portion::{Alone, Portion};
use super::team::Team;
use super::{Outcome, Places, Problem, Settings, Status};
use groups::moving;
use rayon::prelude::*;
use std::collections::HashMap;

pub(super) use groups::{NONE, groups};

/// Rows per chunk of an island's sums, as those of whole problems.
const CHUNK: usize = 256;

/// The islands of the last problem.
#[derive(Default)]
pub(super) struct Islands<const D: usize> {
    islands: Vec<Island<D>>,
    /// Whether the last problem was solved by them.
    used: bool,
    /// Whether the next problem may contain islands of the last one.
    known: bool,
    /// The index of each body in the island that is being loaded.
    place: Vec<u32>,
}

/// A group of islands with its solver.
struct Island<const D: usize> {
    /// Its rows in the problem, ascending.
    rows: Vec<u32>,
    /// The positions of its bodies and of what they touch, ascending.
    bodies: Vec<u32>,
    /// Its rows as a problem of these bodies.
    problem: Problem<D>,
    /// The multipliers: the start, then the solution.
    x: Vec<f64>,
    task: Task<D, Alone>,
    auto: Auto<D>,
    /// Whether the task has the problem.
    prepared: bool,
    outcome: Outcome,
}

/// What a solve is given: the position of each body, and what `auto` was made for.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    pub place: &'a [u32],
    pub tightest: f64,
    pub settings: Settings,
}

impl<const D: usize> Islands<D> {
    /// Solves a problem by its islands, if it has several.
    pub fn solve<P: Portion<D>>(
        &mut self,
        problem: &Problem<D>,
        gamma: &mut [f64],
        given: Given<'_>,
        portion: &P,
    ) -> Option<Outcome> {
        let Some((of_row, count)) = groups(moving(problem, given.place), problem.bodies) else {
            self.forget();
            return None;
        };
        let mut rows = vec![Vec::new(); count];
        (0..).zip(&of_row).for_each(|(row, of): (u32, &u32)| rows[*of as usize].push(row));
        let mut old: Vec<Option<Island<D>>> = std::mem::take(&mut self.islands).into_iter().map(Some).collect();
        // Found by the bodies of their first rows, not by the numbers of rows: several processes number the rows of
        // each problem anew.
        let first = |island: &Option<Island<D>>| island.as_ref().and_then(Island::first);
        let by_first: HashMap<[u32; 2], usize> = match self.known {
            true => (0..).zip(&old).filter_map(|(index, island)| first(island).map(|pair| (pair, index))).collect(),
            false => HashMap::new(),
        };
        let mut unchanged = |rows: &[u32]| {
            let pair = problem.pair[rows[0] as usize].map(|body| given.place[body as usize]);
            let before = old.get_mut(*by_first.get(&pair)?)?;
            let mut island = before.take_if(|island| island.is_same(problem, given.place, gamma, rows))?;
            island.rows.clear();
            island.rows.extend(rows);
            Some(island)
        };
        let kept: Vec<Option<Island<D>>> = rows.iter().map(|rows| unchanged(rows)).collect();
        let mut spare = old.into_iter().flatten();
        self.place.clear();
        self.place.resize(problem.bodies, NONE);
        for (kept, rows) in kept.into_iter().zip(rows) {
            self.islands.push(kept.unwrap_or_else(|| {
                let mut island = spare.next().unwrap_or_else(|| Island::new(given.tightest));
                island.load(problem, given.place, gamma, rows, &mut self.place);
                island
            }));
        }
        (self.known, self.used) = (true, true);
        Some(self.run(portion, gamma, given.settings))
    }

    /// Whether the last problem was solved by its islands.
    pub fn are_used(&self) -> bool {
        self.used
    }

    /// The next problem differs from the last one.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// The next problem may be solved as a whole.
    pub fn leave(&mut self) {
        self.used = false;
    }

    /// Solves those that are not solved to the tolerance, from their last iterates; each process some of them.
    pub fn run<P: Portion<D>>(&mut self, portion: &P, gamma: &mut [f64], settings: Settings) -> Outcome {
        let is_open = |island: &&mut Island<D>| {
            island.outcome.status != Status::Solved || island.outcome.residual > settings.tolerance
        };
        let mut open: Vec<&mut Island<D>> = self.islands.iter_mut().filter(is_open).collect();
        let sizes: Vec<usize> = open.iter().map(|island| island.rows.len() + NUMBERS).collect();
        let own = portion.own_parts(&sizes);
        let is_large = |island: &Island<D>| Team::has_work(island.rows.len());
        open.par_iter_mut().zip(&own).for_each(|(island, own)| {
            if *own && !is_large(island) {
                island.solve(settings);
            }
        });
        for (island, _) in open.iter_mut().zip(&own).filter(|(island, own)| **own && is_large(island)) {
            island.solve(settings);
        }
        let solved = open.iter().zip(&own).map(|(island, own)| if *own { island.packed() } else { Default::default() });
        let solved = portion.exchange_parts(&sizes, solved.collect());
        let mut whole = Whole::default();
        for ((island, own), solved) in open.into_iter().zip(own).zip(solved) {
            if !own {
                island.take(solved);
            }
            island.rows.iter().zip(&island.x).for_each(|(row, x)| gamma[*row as usize] = *x);
            whole.add_work(&island.outcome, island.rows.len());
        }
        whole.end(self.islands.iter().map(|island| &island.outcome), gamma.len())
    }
}

/// The costs of a solve.
#[derive(Default)]
struct Whole {
    /// Iterations of the slowest island; products times rows; factorizations.
    iterations: u64,
    work: u64,
    factorizations: u64,
    fallback: bool,
}

impl Whole {
    fn add_work(&mut self, of: &Outcome, rows: usize) {
        self.iterations = self.iterations.max(of.iterations);
        self.work += of.products * rows as u64;
        self.factorizations += of.factorizations;
        self.fallback |= of.fallback;
    }

    /// The outcome: the worst status and the largest residual of all islands.
    fn end<'a>(self, all: impl Iterator<Item = &'a Outcome>, rows: usize) -> Outcome {
        let (mut worst, mut residual) = (STATUSES.len() - 1, 0.0);
        for of in all {
            worst = worst.min(rank(of.status));
            residual = worse(residual, of.residual);
        }
        let Whole { iterations, work, factorizations, fallback } = self;
        let products = work.div_ceil(rows.max(1) as u64);
        Outcome { status: STATUSES[worst], iterations, products, factorizations, fallback, residual }
    }
}

impl<const D: usize> Island<D> {
    fn new(tightest: f64) -> Self {
        let settings = Settings { tolerance: tightest, max_iterations: 0 };
        Island {
            rows: Vec::new(),
            bodies: Vec::new(),
            problem: Problem::default(),
            x: Vec::new(),
            task: Task { cpu: Cpu::default(), drive: Drive::default(), settings },
            auto: Auto::to(tightest),
            prepared: false,
            outcome: OPEN,
        }
    }

    /// Takes rows of a problem.
    fn load(&mut self, all: &Problem<D>, position: &[u32], gamma: &[f64], rows: Vec<u32>, place: &mut [u32]) {
        let Island { bodies, problem, x, .. } = self;
        bodies.clear();
        for row in rows.iter().map(|row| *row as usize) {
            for position in all.pair[row].map(|body| position[body as usize]) {
                if place[position as usize] == NONE {
                    place[position as usize] = 0;
                    bodies.push(position);
                }
            }
        }
        bodies.sort_unstable();
        (0..).zip(&*bodies).for_each(|(index, position)| place[*position as usize] = index);
        problem.bodies = bodies.len();
        problem.pair.clear();
        problem.jacobian.clear();
        problem.q.clear();
        x.clear();
        for row in rows.iter().map(|row| *row as usize) {
            problem.pair.push(all.pair[row].map(|body| place[position[body as usize] as usize]));
            problem.jacobian.push(all.jacobian[row]);
            problem.q.push(all.q[row]);
            x.push(gamma[row]);
        }
        bodies.iter().for_each(|position| place[*position as usize] = NONE);
        (self.rows, self.prepared, self.outcome) = (rows, false, OPEN);
        self.task.cpu.place(places(self.bodies.len(), self.rows.len()), Alone);
    }

    /// The positions of the bodies of its first row.
    fn first(&self) -> Option<[u32; 2]> {
        self.problem.pair.first().map(|pair| pair.map(|body| self.bodies[body as usize]))
    }

    /// Whether these rows are its own, as it left them, whatever their numbers.
    fn is_same(&self, all: &Problem<D>, position: &[u32], gamma: &[f64], rows: &[u32]) -> bool {
        let own = &self.problem;
        let same = |k: usize, row: usize| {
            own.q[k] == all.q[row]
                && self.x[k] == gamma[row]
                && own.jacobian[k] == all.jacobian[row]
                && own.pair[k].map(|body| self.bodies[body as usize])
                    == all.pair[row].map(|body| position[body as usize])
        };
        self.rows.len() == rows.len() && (0..).zip(rows).all(|(k, row)| same(k, *row as usize))
    }

    fn solve(&mut self, settings: Settings) {
        let Island { problem, x, task, auto, prepared, outcome, .. } = self;
        task.settings = settings;
        if std::mem::replace(prepared, true) {
            task.cpu.restart_count();
        } else {
            task.cpu.rebuild(problem);
        }
        // Another process may have had it before, so nothing but the multipliers goes on.
        task.cpu.import(x, &mut task.drive.at.x);
        auto.forget();
        *outcome = auto.solve(task);
        task.cpu.export(&task.drive.at.x, x);
    }

    /// The multipliers and the outcome, in numbers for other processes.
    fn packed(&self) -> (Vec<f64>, u64) {
        let Outcome { status, iterations, products, factorizations, fallback, residual } = self.outcome;
        let more: [f64; NUMBERS] =
            [rank(status) as f64, products as f64, factorizations as f64, fallback.into(), residual];
        (self.x.iter().copied().chain(more).collect(), iterations)
    }

    /// Takes what another process has solved.
    fn take(&mut self, (mut numbers, iterations): (Vec<f64>, u64)) {
        let rows = self.rows.len();
        if let Some([status, products, factorizations, fallback, residual]) = numbers[rows..].first_chunk::<NUMBERS>() {
            let (products, factorizations) = (*products as u64, *factorizations as u64);
            let (status, fallback, residual) = (STATUSES[*status as usize], *fallback > 0.0, *residual);
            self.outcome = Outcome { status, iterations, products, factorizations, fallback, residual };
        }
        numbers.truncate(rows);
        self.x = numbers;
    }
}

/// How `auto` ends, the worst first: rows without a common solution in one island are those of the whole problem.
const STATUSES: [Status; 7] = [
    Status::NotFinite,
    Status::TooLarge,
    Status::Infeasible,
    Status::NoProgress,
    Status::RoundingFloor,
    Status::MaxIterations,
    Status::Solved,
];

/// The place of a status among [`STATUSES`].
fn rank(status: Status) -> usize {
    STATUSES.iter().position(|of| *of == status).unwrap_or(0)
}

/// The numbers of an outcome beside its iterations.
const NUMBERS: usize = 5;

/// Before a solve.
const OPEN: Outcome = Outcome {
    status: Status::MaxIterations,
    iterations: 0,
    products: 0,
    factorizations: 0,
    fallback: false,
    residual: f64::INFINITY,
};

/// An island's bodies in their order, in blocks for chunks of [`CHUNK`] rows.
fn places(bodies: usize, rows: usize) -> Places {
    let blocks = rows.div_ceil(CHUNK).next_power_of_two();
    Places {
        place: (0..bodies as u32).collect(),
        blocks: (0..=blocks).map(|block| (block * bodies / blocks) as u32).collect(),
    }
}

#[cfg(test)]
mod tests;
