//! Goes on with an LCP where it is not solved yet: a later LCP of a step differs from the one before in a few rows, and
//! most of it stays solved.
//!
//! Rows whose residual is near or over the tolerance are seeds. Their bodies, and some layers of bodies that touch
//! those by rows with multipliers, are free; all rows of free bodies are solved again with everything else as it is,
//! each connected part on its own:
//!
//! ```text
//! 0 <= q' + A_SS x_S  _|_  x_S >= 0,   q' = g_S - A_SS x_S at the present x
//! ```
//!
//! This is a block step of a descent method: the objective `1/2 x . A x + q . x` never rises (overlapping domains,
//! chosen by need; Schwarz's alternating method for obstacle problems as in L. Badea, SIAM J. Numer. Anal. 41, 1052
//! (2003)). What a part disturbs around it is the next round's seed.
//!
//! Degenerate cases: bodies without a block in a row (walls) connect nothing; a part as large as the whole is left to
//! the caller.

use super::Problem;
use super::cpu::Cpu;
use super::drive::{Drive, Point, Standing};
use super::pair_block_cg::PairBlockCg;
use super::product::{add, dot};
use super::residual::of_row;
use super::team::{self, Team};
use super::verbs::Verbs;
use super::{Settings, Status};
use rayon::prelude::*;

/// A row is a seed from this part of the tolerance on, so that what a round leaves just under it does not come back in
/// the next.
const SEED: f64 = 0.95;

/// Parts are solved to this part of the tolerance: their rows count again in the residual of the whole.
const INNER: f64 = 0.5;

/// Layers of bodies around the seeds, and how many more a round.
const LAYERS: usize = 2;
const MORE_LAYERS: usize = 2;

/// Most of the rows that a round may solve again: with more, an iteration on all of them costs about as much.
const MOST_ROWS: f64 = 0.35;

/// Most rounds.
const MOST_ROUNDS: usize = 12;

/// Most iterations in a part.
const MOST_ITERATIONS: u64 = 500;

/// Iterations in a part between two looks at how fast they are.
const ROUND: u64 = 100;

/// What the rounds came to.
pub(super) struct Rounds {
    /// Whether the residual of the whole is within the tolerance, and that residual.
    pub solved: bool,
    pub residual: f64,
    /// Iterations of the slowest part of each round.
    pub iterations: u64,
    /// Iterations times rows.
    pub work: u64,
}

/// A connected part: its bodies and rows by their numbers in the whole.
#[derive(Default)]
struct Part {
    bodies: Vec<u32>,
    rows: Vec<u32>,
}

/// Which bodies and rows a round takes; its buffers are used again.
pub(super) struct Local {
    free: Vec<bool>,
    taken: Vec<bool>,
    number: Vec<u32>,
    team: Option<Team>,
}

impl Default for Local {
    fn default() -> Self {
        Local { free: Vec::new(), taken: Vec::new(), number: Vec::new(), team: Some(Team::default()) }
    }
}

impl Local {
    /// Solves where the LCP of `cpu` is not solved at `at`, whose gradient must be fresh, until it is or that is no
    /// local matter.
    pub fn run<const D: usize>(&mut self, cpu: &mut Cpu<D>, at: &mut Point<Vec<f64>>, tolerance: f64) -> Rounds {
        let mut rounds = Rounds { solved: false, residual: cpu.residual(&at.x, &at.g), iterations: 0, work: 0 };
        let rows = at.x.len();
        for round in 0..MOST_ROUNDS {
            let layers = LAYERS + MORE_LAYERS * round;
            let Some(parts) = self.parts(cpu, at, tolerance, layers) else { break };
            let solved = self.solve(cpu, at, &parts, INNER * tolerance);
            let mut slowest = 0;
            for (part, (x, iterations)) in parts.iter().zip(&solved) {
                part.rows.iter().zip(x).for_each(|(row, x)| at.x[*row as usize] = *x);
                rounds.work += iterations * part.rows.len() as u64;
                slowest = slowest.max(*iterations);
            }
            rounds.iterations += slowest;
            cpu.gradient(&at.x, &mut at.g);
            rounds.residual = cpu.residual(&at.x, &at.g);
            rounds.work += rows as u64;
            if rounds.residual <= tolerance {
                rounds.solved = true;
                break;
            }
        }
        rounds
    }

    /// Solves the parts: large ones one by one with all threads, the others each with one.
    fn solve<const D: usize>(
        &mut self,
        cpu: &Cpu<D>,
        at: &Point<Vec<f64>>,
        parts: &[Part],
        tolerance: f64,
    ) -> Vec<(Vec<f64>, u64)> {
        let is_large = |part: &Part| Team::has_work(part.rows.len());
        let small = |part: &Part| (!is_large(part)).then(|| solve_part(cpu, at, part, tolerance, &mut None));
        let solved: Vec<_> = parts.par_iter().map(small).collect();
        let solved = parts.iter().zip(solved);
        solved
            .map(|(part, solved)| solved.unwrap_or_else(|| solve_part(cpu, at, part, tolerance, &mut self.team)))
            .collect()
    }

    /// Whether few rows are to be solved again.
    pub fn is_worth<const D: usize>(&mut self, cpu: &Cpu<D>, at: &Point<Vec<f64>>, tolerance: f64) -> bool {
        self.free_rows(cpu, at, tolerance, LAYERS).is_some()
    }

    /// Marks free bodies and taken rows; their number, where it is few enough and not none.
    fn free_rows<const D: usize>(
        &mut self,
        cpu: &Cpu<D>,
        at: &Point<Vec<f64>>,
        tolerance: f64,
        layers: usize,
    ) -> Option<usize> {
        let rows = cpu.rows();
        let incidence = cpu.incidence();
        let most = (MOST_ROWS * rows.q.len() as f64) as usize;
        let moves = |entry: u32| rows.jacobian[(entry / 2) as usize][(entry % 2) as usize] != [0.0; D];
        let bodies = incidence.start.len() - 1;
        self.free.clear();
        self.free.resize(bodies, false);
        self.taken.clear();
        self.taken.resize(rows.q.len(), false);
        let mut front: Vec<u32> = Vec::new();
        for row in 0..rows.q.len() {
            if of_row(at.g[row], rows.diagonal[row], at.x[row]) > SEED * tolerance {
                for side in 0..2 {
                    let body = rows.pair[row][side];
                    if moves(2 * row as u32 + side as u32) && !std::mem::replace(&mut self.free[body as usize], true) {
                        front.push(body);
                    }
                }
            }
        }
        let mut taken = 0;
        for layer in 0..=layers {
            let mut next = Vec::new();
            for body in front {
                for &entry in incidence.of(body as usize) {
                    let row = (entry / 2) as usize;
                    if !std::mem::replace(&mut self.taken[row], true) {
                        taken += 1;
                    }
                    let other = rows.pair[row][1 - (entry % 2) as usize];
                    let reached = layer < layers && at.x[row] > 0.0 && moves(entry ^ 1);
                    if reached && !std::mem::replace(&mut self.free[other as usize], true) {
                        next.push(other);
                    }
                }
            }
            if taken > most {
                return None;
            }
            front = next;
        }
        (taken > 0).then_some(taken)
    }

    /// The connected parts of what is solved again, where that is few enough, in the order of their first bodies.
    fn parts<const D: usize>(
        &mut self,
        cpu: &Cpu<D>,
        at: &Point<Vec<f64>>,
        tolerance: f64,
        layers: usize,
    ) -> Option<Vec<Part>> {
        self.free_rows(cpu, at, tolerance, layers)?;
        let rows = cpu.rows();
        let incidence = cpu.incidence();
        let moves = |entry: u32| rows.jacobian[(entry / 2) as usize][(entry % 2) as usize] != [0.0; D];
        let mut parts = Vec::new();
        self.number.clear();
        self.number.resize(self.free.len(), u32::MAX);
        for first in 0..self.free.len() {
            if !self.free[first] || self.number[first] != u32::MAX {
                continue;
            }
            let mut part = Part::default();
            let mut waiting = vec![first as u32];
            self.number[first] = 0;
            while let Some(body) = waiting.pop() {
                part.bodies.push(body);
                for &entry in incidence.of(body as usize) {
                    let row = (entry / 2) as usize;
                    if !self.taken[row] {
                        continue;
                    }
                    // A row is listed once, by the first of its sides that moves.
                    if entry % 2 == 0 || !moves(entry ^ 1) {
                        part.rows.push(row as u32);
                    }
                    let other = rows.pair[row][1 - (entry % 2) as usize];
                    if moves(entry ^ 1) && self.number[other as usize] == u32::MAX {
                        self.number[other as usize] = 0;
                        waiting.push(other);
                    }
                }
            }
            part.bodies.sort_unstable();
            part.rows.sort_unstable();
            part.rows.dedup();
            parts.push(part);
        }
        Some(parts)
    }
}

/// Solves the rows of a part with everything else as it is.
fn solve_part<const D: usize>(
    cpu: &Cpu<D>,
    at: &Point<Vec<f64>>,
    part: &Part,
    tolerance: f64,
    team: &mut Option<Team>,
) -> (Vec<f64>, u64) {
    let rows = cpu.rows();
    // The last place is for what does not move.
    let place = |body: u32| part.bodies.binary_search(&body).unwrap_or(part.bodies.len()) as u32;
    let mut problem = Problem::<D> { bodies: part.bodies.len() + 1, ..Problem::default() };
    let mut x = Vec::with_capacity(part.rows.len());
    let mut velocity = vec![[0.0; D]; problem.bodies];
    for &row in &part.rows {
        let row = row as usize;
        let pair = rows.pair[row].map(place);
        problem.pair.push(pair);
        problem.jacobian.push(rows.jacobian[row]);
        x.push(at.x[row]);
        for (body, block) in pair.into_iter().zip(&rows.jacobian[row]) {
            add(&mut velocity[body as usize], at.x[row], block);
        }
    }
    for (k, &row) in part.rows.iter().enumerate() {
        let ([a, b], [ja, jb]) = (problem.pair[k], &problem.jacobian[k]);
        let own = dot(ja, &velocity[a as usize]) + dot(jb, &velocity[b as usize]);
        problem.q.push(at.g[row as usize] - own);
    }
    let mut inner = Cpu::default();
    inner.rebuild(&problem);
    let mut drive = Drive::default();
    inner.import(&x, &mut drive.at.x);
    let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
    let method = &mut PairBlockCg::new();
    // A team's pace is judged round by round.
    let pauses = |standing: Standing| standing.iterations.is_multiple_of(ROUND);
    let run = team::run(team, &mut inner, &mut drive, method, &settings, &pauses, |_, _, _| true);
    let (status, iterations, _) = run;
    if status != Status::NotFinite {
        inner.export(&drive.at.x, &mut x);
    }
    (x, iterations)
}
