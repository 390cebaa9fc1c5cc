//! Several threads that run the same iterations of a solver, each on some of the rows.
//!
//! A loop over some thousand rows takes a few microseconds, less than the cost of dispatching it to other threads. So
//! threads start once for many iterations and run the solver itself, each on its own rows. A barrier precedes every
//! reduction over all rows, some seven times an iteration. All threads compute the same numbers from the same sums of
//! chunks, so they take the same decisions, and the bits are those of one thread.

mod member;
mod pace;
mod seats;
mod shared;

use super::cpu::Cpu;
use super::drive::{Drive, Point, Progress, SolveState};
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::{Settings, Status};
use pace::Pace;
use seats::Seats;
use std::time::Instant;

/// The smallest number of rows per thread. An iteration on these takes some 15 microseconds, and its barriers two to
/// four.
const LEAST_ROWS: usize = 768;

/// Iterations of a round if nothing else pauses a solve: the speed of a team is measured round by round.
pub(super) const ROUND: u64 = 100;

/// Threads for the iterations of a solver.
#[derive(Clone, Debug, Default)]
pub(super) struct Team {
    pace: Pace,
}

/// The method that it runs, and its state.
type Method = PairBlockCg<Vec<f64>, f64>;

/// Runs conjugate gradients as [`Drive::run_while`] does, with a team on as many threads as are faster. Whenever
/// `pauses` returns true, `goes_on` decides whether to continue.
pub(super) fn run<const D: usize, P: Portion<D>>(
    team: &mut Option<Team>,
    cpu: &mut Cpu<D, P>,
    drive: &mut Drive<Vec<f64>>,
    method: &mut Method,
    settings: &Settings,
    pauses: &(impl Fn(Progress) -> bool + Sync),
    mut goes_on: impl FnMut(&Cpu<D, P>, &Point<Vec<f64>>, Progress) -> bool,
) -> (Status, u64, f64) {
    let mut state = drive.begin(cpu, method, settings);
    let mut seats = Seats::none();
    let status = loop {
        let ended = match team {
            Some(team) if cpu.portion.has_threads() => team.go(cpu, drive, method, (&mut state, &mut seats), pauses),
            _ => drive.go(cpu, method, &mut state, 1, pauses),
        };
        match ended {
            Some(status) => break status,
            None if goes_on(cpu, &drive.at, state.progress()) => {}
            None => break Status::MaxIterations,
        }
    };
    seats.leave(drive, method);
    drive.end(cpu, &state, status)
}

impl Team {
    /// Whether this many rows suffice for more than one thread.
    pub fn has_work(rows: usize) -> bool {
        rows >= 2 * LEAST_ROWS && rayon::current_num_threads() > 1
    }

    /// [`Drive::go`] on as many threads as are faster.
    fn go<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &mut Cpu<D, P>,
        drive: &mut Drive<Vec<f64>>,
        method: &mut Method,
        (state, seats): (&mut SolveState<f64>, &mut Seats<D>),
        pauses: &(impl Fn(Progress) -> bool + Sync),
    ) -> Option<Status> {
        let rows = drive.at.x.len();
        let members = (rows / LEAST_ROWS).min(rayon::current_num_threads());
        // One thread checks the start first.
        if members < 1 || state.is_new() {
            return drive.go(cpu, method, state, 1, pauses);
        }
        let mut team = members > 1 && self.pace.chooses_team();
        let (begun, before) = (Instant::now(), state.progress().iterations);
        let mut ended = None;
        if team {
            match seats.go(members, cpu, drive, method, state, pauses) {
                Some(of_team) => ended = of_team,
                None => {
                    team = false;
                    self.pace.go_alone();
                }
            }
        }
        if !team {
            seats.leave(drive, method);
            ended = drive.go(cpu, method, state, 1, pauses);
        }
        let (iterations, time) = (state.progress().iterations - before, begun.elapsed());
        let threads = if team { members } else { 1 };
        log::trace!("{iterations} iterations on {rows} rows by {threads} threads in {} us", time.as_micros());
        self.pace.note(team, rows, iterations, time);
        ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::product::dot;
    use crate::lcp::{Problem, ResidualSample, Solver, SolverKind};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// How often a team may fail to assemble.
    const TRIES: usize = 1_000;

    /// Bodies on a ring, each connected to the next few by one to eleven rows, some of them zero.
    fn ring<const D: usize>(bodies: u32) -> Problem<D> {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut problem = Problem { bodies: bodies as usize, ..Problem::default() };
        for a in 0..bodies {
            for b in [1, 2, 5].map(|far| (a + far) % bodies) {
                for _ in 0..1 + (a * b) % 11 {
                    let mut block = || std::array::from_fn(|_| rng.random::<f64>() - 0.5);
                    problem.jacobian.push([block(), if a % 9 == 0 { [0.0; D] } else { block() }]);
                    problem.pair.push(if a % 2 == 0 { [a, b] } else { [b, a] });
                }
            }
        }
        // A problem that has a solution.
        let touches: Vec<bool> = problem.pair.iter().map(|_| rng.random::<bool>()).collect();
        let gamma: Vec<f64> =
            touches.iter().map(|touches| f64::from(u8::from(*touches)) * rng.random::<f64>()).collect();
        let v = crate::lcp::velocity(&problem, &gamma);
        let moved =
            |([a, b], [ja, jb]): (&[u32; 2], &[[f64; D]; 2])| dot(ja, &v[*a as usize]) + dot(jb, &v[*b as usize]);
        let moved = problem.pair.iter().zip(&problem.jacobian).map(moved);
        problem.q = moved.zip(touches).map(|(moved, touches)| f64::from(u8::from(!touches)) - moved).collect();
        problem
    }

    /// A solve that pauses every `period` iterations, with this many members in each of its rounds.
    fn solve<const D: usize>(problem: &Problem<D>, period: u64, members: &[usize]) -> Solved {
        let (mut cpu, mut drive, mut method) = (Cpu::<D>::default(), Drive::default(), Method::new());
        cpu.rebuild(problem);
        cpu.import(&vec![0.1; problem.q.len()], &mut drive.at.x);
        drive.history = Some(Vec::new());
        let settings = Settings { tolerance: 1e-6, max_iterations: 400 };
        let mut state = drive.begin(&mut cpu, &mut method, &settings);
        let pauses = |progress: Progress| progress.iterations.is_multiple_of(period);
        let mut rounds = members.iter().cycle();
        let mut seats = Seats::none();
        let status = loop {
            let ended = match rounds.next() {
                Some(1) | None => {
                    seats.leave(&mut drive, &mut method);
                    drive.go(&mut cpu, &mut method, &mut state, 1, &pauses)
                }
                Some(members) => {
                    // On a busy machine threads may take long to start.
                    let mut come = || seats.go(*members, &mut cpu, &mut drive, &mut method, &mut state, &pauses);
                    let work = || (0..TRIES).find_map(|_| come());
                    rayon::ThreadPoolBuilder::new().num_threads(*members).build().unwrap().install(work)
                }
                .unwrap_or_else(|| drive.go(&mut cpu, &mut method, &mut state, 1, &pauses)),
            };
            if let Some(status) = ended {
                break status;
            }
        };
        seats.leave(&mut drive, &mut method);
        let ended = drive.end(&mut cpu, &state, status);
        let numbers = drive.at.x.iter().chain(&drive.at.g).map(|number| number.to_bits()).collect();
        Solved { ended, products: cpu.products_made(), numbers, history: drive.history }
    }

    #[derive(Debug, PartialEq)]
    struct Solved {
        ended: (Status, u64, f64),
        products: u64,
        numbers: Vec<u64>,
        history: Option<Vec<ResidualSample>>,
    }

    #[test]
    fn the_bits_do_not_depend_on_the_number_of_threads() {
        let (planar, spatial) = (ring::<3>(120), ring::<6>(90));
        let (planar_alone, spatial_alone) = (solve(&planar, 7, &[1]), solve(&spatial, 7, &[1]));
        assert!(planar_alone.ended.2 < 1e-2 && spatial_alone.ended.2 < 1e-2);
        for members in [vec![2], vec![3, 1]] {
            assert!(solve(&planar, 7, &members) == planar_alone, "{members:?}");
            assert!(solve(&spatial, 7, &members) == spatial_alone, "{members:?}");
        }
        assert!(solve(&planar, 1_000, &[5]) == planar_alone);
    }

    #[test]
    fn two_solves_that_share_threads_both_end_with_the_bits_of_one() {
        let problem = ring::<3>(150);
        assert!(problem.q.len() >= 2 * LEAST_ROWS);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let solve = || {
            let mut gamma = Vec::new();
            let settings = Settings { tolerance: 1e-9, max_iterations: 400 };
            let outcome = pool.install(|| Solver::new(SolverKind::PairBlockCg, settings).solve(&problem, &mut gamma));
            (outcome, gamma)
        };
        let alone = solve();
        let both = std::thread::scope(|scope| {
            let threads = [scope.spawn(solve), scope.spawn(solve)];
            threads.map(|thread| thread.join().unwrap())
        });
        assert!(both.iter().all(|solved| *solved == alone));
    }

    #[test]
    fn more_threads_than_chunks_are_no_fault() {
        let problem = ring::<3>(4);
        assert_eq!(solve(&problem, 3, &[6]), solve(&problem, 3, &[1]));
    }
}
