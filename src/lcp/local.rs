//! Continues an LCP locally: a later LCP of a step differs from the one before in a few rows, and most of it stays
//! solved.
//!
//! Rows whose residual is near or above the tolerance are seeds. Their bodies, and some layers of bodies around them
//! that are connected by rows with multipliers, are free. All rows of free bodies are solved again with everything else
//! fixed, each connected part by itself:
//!
//! ```text
//! 0 <= q' + A_SS x_S  _|_  x_S >= 0,   q' = g_S - A_SS x_S at the present x
//! ```
//!
//! This is a block step of a descent method: the objective `1/2 x . A x + q . x` never rises (overlapping domains,
//! chosen adaptively; Schwarz's alternating method for obstacle problems as in L. Badea, SIAM J. Numer. Anal. 41, 1052
//! (2003)). Rows that a part disturbs around it are seeds of the next round.
//!
//! Degenerate cases: bodies with a zero block in a row (walls) connect nothing; a part as large as the whole is left to
//! the caller.

use super::Problem;
use super::cone::{is_free, residual};
use super::cpu::Cpu;
use super::drive::{Drive, Point, Progress};
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::product::{add, dot};
use super::taken::{Part, Taken};
use super::team::{self, Team};
use super::verbs::Verbs;
use super::{Settings, Status};
use rayon::prelude::*;

/// A row is a seed from this part of the tolerance on, so that rows just below the tolerance do not become seeds of the
/// next round.
const SEED: f64 = 0.95;

/// Parts are solved to this part of the tolerance, because the residual of the whole problem includes their rows.
const INNER: f64 = 0.5;

/// Layers of bodies around the seeds, and the additional layers per round.
const LAYERS: usize = 2;
const MORE_LAYERS: usize = 2;

/// The largest part of the rows that a round may solve again: beyond it, an iteration on all rows costs about as much.
const MOST_ROWS: f64 = 0.35;

/// The largest number of rounds.
const MOST_ROUNDS: usize = 12;

/// The largest number of iterations in a part.
const MOST_ITERATIONS: u64 = 500;

/// The search for seeds among fewer rows than this runs on one thread: a row takes some 2 ns.
const LEAST_ROWS_A_TASK: usize = 8_192;

/// The result of the rounds.
pub(super) struct Rounds {
    /// Whether the residual of the whole problem is within the tolerance.
    pub solved: bool,
    pub residual: f64,
    /// Iterations of the slowest part of each round.
    pub iterations: u64,
    /// Iterations times rows.
    pub work: u64,
}

/// The bodies and rows of a round; its buffers are reused.
pub(super) struct Local {
    free: Vec<bool>,
    taken: Vec<bool>,
    team: Option<Team>,
}

impl Default for Local {
    fn default() -> Self {
        Local { free: Vec::new(), taken: Vec::new(), team: Some(Team::default()) }
    }
}

impl Local {
    /// Solves locally where the LCP of `cpu` is not solved at `at`, whose gradient must be fresh, until all of it is
    /// solved or too many rows are involved.
    pub fn run<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &mut Cpu<D, P>,
        at: &mut Point<Vec<f64>>,
        tolerance: f64,
    ) -> Rounds {
        let mut rounds = Rounds { solved: false, residual: cpu.residual(&at.x, &at.g), iterations: 0, work: 0 };
        for round in 0..MOST_ROUNDS {
            let layers = LAYERS + MORE_LAYERS * round;
            if self.free_rows(cpu, at, tolerance, layers).is_none() {
                break;
            }
            let taken = self.take(cpu, at);
            let parts = taken.parts();
            let solved = self.solve(cpu, &taken, &parts, INNER * tolerance);
            let mut slowest = 0;
            for (part, (x, iterations)) in parts.iter().zip(&solved) {
                for (row, x) in part.rows.iter().zip(x) {
                    if let Some(row) = cpu.portion.row(taken.row[*row as usize]) {
                        at.x[row] = *x;
                    }
                }
                rounds.work += iterations * part.rows.len() as u64;
                slowest = slowest.max(*iterations);
            }
            rounds.iterations += slowest;
            cpu.gradient(&at.x, &mut at.g);
            rounds.residual = cpu.residual(&at.x, &at.g);
            rounds.work += cpu.all_rows() as u64;
            if rounds.residual <= tolerance {
                rounds.solved = true;
                break;
            }
        }
        rounds
    }

    /// Solves the parts: large ones one by one with all threads, the others with one thread each. The parts are
    /// distributed over processes.
    fn solve<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &Cpu<D, P>,
        taken: &Taken<D>,
        parts: &[Part],
        tolerance: f64,
    ) -> Vec<(Vec<f64>, u64)> {
        let sizes: Vec<usize> = parts.iter().map(|part| part.rows.len()).collect();
        let own = cpu.portion.own_parts(&sizes);
        let is_large = |part: &Part| Team::has_work(part.rows.len());
        let small = |(part, own): (&Part, &bool)| {
            (*own && !is_large(part)).then(|| solve_part(taken, part, tolerance, &mut None))
        };
        let solved: Vec<_> = parts.par_iter().zip(&own).map(small).collect();
        let solved = parts.iter().zip(own).zip(solved).map(|((part, own), solved)| match solved {
            None if own => solve_part(taken, part, tolerance, &mut self.team),
            None => (Vec::new(), 0),
            Some(solved) => solved,
        });
        cpu.portion.exchange_parts(&sizes, solved.collect())
    }

    /// Whether few enough rows have to be solved again.
    pub fn is_worth<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &Cpu<D, P>,
        at: &Point<Vec<f64>>,
        tolerance: f64,
    ) -> bool {
        self.free_rows(cpu, at, tolerance, LAYERS).is_some()
    }

    /// Marks free bodies and taken rows. Returns the number of rows, or none if it is zero or too large.
    fn free_rows<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &Cpu<D, P>,
        at: &Point<Vec<f64>>,
        tolerance: f64,
        layers: usize,
    ) -> Option<usize> {
        let rows = cpu.rows();
        let incidence = cpu.incidence();
        let most = (MOST_ROWS * cpu.all_rows() as f64) as usize;
        let moves = |entry: u32| rows.jacobian[(entry / 2) as usize][(entry % 2) as usize] != [0.0; D];
        let bodies = incidence.start.len() - 1;
        self.free.clear();
        self.free.resize(bodies, false);
        self.taken.clear();
        self.taken.resize(rows.q.len(), false);
        let mut front: Vec<u32> = Vec::new();
        let open = |row: &usize| residual(at.g[*row], rows.diagonal[*row], at.x[*row]) > SEED * tolerance;
        let all = (0..rows.q.len()).into_par_iter().with_min_len(LEAST_ROWS_A_TASK);
        for row in all.filter(open).collect::<Vec<_>>() {
            for side in 0..2 {
                let body = rows.pair[row][side];
                if moves(2 * row as u32 + side as u32) && !std::mem::replace(&mut self.free[body as usize], true) {
                    front.push(body);
                }
            }
        }
        cpu.portion.learn_flags(&mut self.free, &mut front);
        let mut taken = 0;
        for layer in 0..=layers {
            let mut next = Vec::new();
            for body in front {
                for &entry in incidence.of(body as usize) {
                    let row = (entry / 2) as usize;
                    if !std::mem::replace(&mut self.taken[row], true) && cpu.portion.counts(row) {
                        taken += 1;
                    }
                    let other = rows.pair[row][1 - (entry % 2) as usize];
                    let reached = layer < layers && is_free(at.x[row]) && moves(entry ^ 1);
                    if reached && !std::mem::replace(&mut self.free[other as usize], true) {
                        next.push(other);
                    }
                }
            }
            if cpu.portion.sum(taken) > most {
                return None;
            }
            cpu.portion.learn_flags(&mut self.free, &mut next);
            front = next;
        }
        Some(cpu.portion.sum(taken)).filter(|taken| *taken > 0)
    }

    /// The marked rows of all processes.
    fn take<const D: usize, P: Portion<D>>(&self, cpu: &Cpu<D, P>, at: &Point<Vec<f64>>) -> Taken<D> {
        let rows = cpu.rows();
        let mut taken = Taken::default();
        for row in (0..rows.q.len()).filter(|row| self.taken[*row] && cpu.portion.counts(*row)) {
            taken.row.push(cpu.portion.number(row));
            taken.pair.push(cpu.portion.among_all(rows.pair[row]));
            taken.jacobian.push(rows.jacobian[row]);
            taken.x.push(at.x[row]);
            taken.g.push(at.g[row]);
        }
        cpu.portion.all_taken(taken)
    }
}

/// Solves the rows of a part with everything else fixed.
fn solve_part<const D: usize>(
    taken: &Taken<D>,
    part: &Part,
    tolerance: f64,
    team: &mut Option<Team>,
) -> (Vec<f64>, u64) {
    // The last position is for everything that does not move.
    let place = |body: u32| part.bodies.binary_search(&body).unwrap_or(part.bodies.len()) as u32;
    let mut problem = Problem::<D> { bodies: part.bodies.len() + 1, ..Problem::default() };
    let mut x = Vec::with_capacity(part.rows.len());
    let mut velocity = vec![[0.0; D]; problem.bodies];
    for &row in &part.rows {
        let row = row as usize;
        let pair = taken.pair[row].map(place);
        problem.pair.push(pair);
        problem.jacobian.push(taken.jacobian[row]);
        x.push(taken.x[row]);
        for (body, block) in pair.into_iter().zip(&taken.jacobian[row]) {
            add(&mut velocity[body as usize], taken.x[row], block);
        }
    }
    for (k, &row) in part.rows.iter().enumerate() {
        let ([a, b], [ja, jb]) = (problem.pair[k], &problem.jacobian[k]);
        let own = dot(ja, &velocity[a as usize]) + dot(jb, &velocity[b as usize]);
        problem.q.push(taken.g[row as usize] - own);
    }
    let mut inner = Cpu::<D>::default();
    inner.rebuild(&problem);
    let mut drive = Drive::default();
    inner.import(&x, &mut drive.at.x);
    let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
    let method = &mut PairBlockCg::new();
    let pauses = |progress: Progress| progress.iterations.is_multiple_of(team::ROUND);
    let run = team::run(team, &mut inner, &mut drive, method, &settings, &pauses, |_, _, _| true);
    let (status, iterations, _) = run;
    if status != Status::NotFinite {
        inner.export(&drive.at.x, &mut x);
    }
    (x, iterations)
}
