//! The loop around an iterative method: when to stop and what to return.

use super::verbs::{Checks, Scalar, Verbs};
use super::{Settings, Status};
use std::collections::VecDeque;
use std::ops::Range;

/// A solve stops without success if the best residual has not fallen by [`PROGRESS`] over this many iterations, or over
/// as many as the last gain took, if that is more. The slowest stored instances pause for some hundred iterations
/// between two gains; systems without a solution never gain.
const PATIENCE: u64 = 3_000;

/// The same for methods that only contract slowly: projected Jacobi pauses for 20,000 iterations on a packing of 24
/// ellipsoids, while the set of touching pairs settles, and then converges.
pub(crate) const PATIENCE_OF_SLOW_METHODS: u64 = 50_000;

/// Iterations after which a gradient kept by recurrence is computed afresh: the rounding of that many updates stays
/// near 1e-14 of the gradient's terms, for a thousandth of the products.
const RENEWAL: u64 = 1_000;

/// The same for scalars coarser than 64 bits.
const RENEWAL_OF_COARSE_NUMBERS: u64 = 50;

/// A start whose residual is within the tolerance is still iterated, at most this often. Multipliers that open rows
/// keep from the last step matter little in one step, but unchanged over many small steps they would act as a force
/// between separated bodies: two ellipsoids deviated by 0.03 from their path at steps of 1e-5. One iteration removes
/// such multipliers; the others serve if it leaves a residual above the tolerance.
const ITERATIONS_FROM_A_SOLUTION: u64 = 50;

/// After fresh gradients have refuted this many consecutive candidates, none with a smaller residual than those before,
/// the solve has reached the rounding floor. The pressed systems of `tests/data/lcp` need none in f64 and none in f32
/// with multipliers in two parts; with multipliers in one part up to 1,800 were refuted without effect.
const MOST_REFUTED: u32 = 16;

/// A candidate with a residual above this many tolerances is not refuted by rounding, but by contradictory rows and
/// multipliers that grow without bounds.
const NEAR: f64 = 100.0;

/// The part of the best residual that counts as a gain.
const PROGRESS: f64 = 0.99;

/// An iterate and the gradient there.
#[derive(Clone, Debug, Default)]
pub struct Point<T> {
    /// Multipliers, none negative.
    pub x: T,
    /// `q + A x`, perhaps by a recurrence.
    pub g: T,
}

/// An iterative method over the verbs `V`. It keeps its vectors between solves, and `begin` prepares them.
pub trait Method<V: Verbs> {
    /// Starts or restarts at a point whose gradient is fresh.
    fn begin(&mut self, verbs: &mut V, at: &Point<V::Vector>);
    /// Takes one iteration.
    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>);
    /// Updates `at.g` before a check. Returns whether it was recomputed rather than updated by recurrence.
    fn refresh(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) -> bool;
    /// The residual after the last iteration, whose gradient is not recomputed since.
    fn residual(&mut self, verbs: &mut V, at: &Point<V::Vector>) -> V::Scalar {
        verbs.residual(&at.x, &at.g)
    }
    /// Iterations without improvement after which a solve ends as `NoProgress`.
    fn patience(&self) -> u64 {
        PATIENCE
    }
}

/// The state of a solve at a check of its residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualSample {
    /// Iterations taken.
    pub iterations: u64,
    /// Products computed. A device reads many residuals at once: those until it read this one.
    pub products: u64,
    /// The residual of the iterate, perhaps from a gradient updated by recurrence.
    pub residual: f64,
}

/// The vectors of the driver.
#[derive(Default)]
pub struct Drive<T> {
    /// The iterate: the start when [`Drive::run`] is called, the best one found after it.
    pub at: Point<T>,
    best: T,
    start: T,
    /// The checks of the last solve, if recorded.
    pub history: Option<Vec<ResidualSample>>,
}

impl Drive<Vec<f64>> {
    /// The part of it that belongs to some of the rows.
    pub fn share(&self, rows: Range<usize>) -> Self {
        let of = |numbers: &[f64]| numbers[rows.clone()].to_vec();
        let at = Point { x: of(&self.at.x), g: of(&self.at.g) };
        Drive { at, best: of(&self.best), start: Vec::new(), history: None }
    }

    /// Merges back a part from [`Drive::share`].
    pub fn take_back(&mut self, rows: Range<usize>, share: &Self) {
        self.at.x[rows.clone()].copy_from_slice(&share.at.x);
        self.at.g[rows.clone()].copy_from_slice(&share.at.g);
        self.best[rows].copy_from_slice(&share.best);
    }
}

impl<T> Drive<T> {
    /// Iterates until the true residual is at most the tolerance, or the solve has stalled. Returns the status, the
    /// iterations, and the residual of a fresh gradient at `self.at.x`, the best of all checked iterates.
    ///
    /// The residual is checked every `check_every` iterations. A start counts as a solution only if its residual is
    /// zero.
    pub fn run<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
        check_every: u64,
    ) -> (Status, u64, f64)
    where
        T: Default,
    {
        self.run_while(verbs, method, settings, check_every, |_, _, _| true)
    }

    /// [`Drive::run`] that ends as at the iteration limit as soon as `goes_on` returns false.
    pub fn run_while<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
        check_every: u64,
        mut goes_on: impl FnMut(&V, &Point<T>, Progress) -> bool,
    ) -> (Status, u64, f64)
    where
        T: Default,
    {
        let mut state = self.begin(verbs, method, settings);
        let status = loop {
            match self.go(verbs, method, &mut state, check_every, &|_| true) {
                Some(status) => break status,
                None if goes_on(verbs, &self.at, state.progress()) => {}
                None => break Status::MaxIterations,
            }
        };
        self.end(verbs, &state, status)
    }

    /// Continues until the solve ends or `pauses` returns true.
    pub fn go<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        state: &mut SolveState<V::Scalar>,
        check_every: u64,
        pauses: &impl Fn(Progress) -> bool,
    ) -> Option<Status> {
        loop {
            if !std::mem::take(&mut state.paused) {
                self.iterate(verbs, method, state, check_every);
                if !state.read_checks(verbs, &mut self.history) {
                    continue;
                }
                if state.is_candidate() {
                    self.confirm(verbs, method, state);
                }
                if let Some(status) = state.status() {
                    return Some(status);
                }
                state.least = state.least.min(state.now);
                if pauses(state.progress()) {
                    state.paused = true;
                    return None;
                }
            }
            if state.has_stalled(method.patience()) {
                return Some(Status::NoProgress);
            }
        }
    }

    /// Checks the start.
    pub fn begin<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
    ) -> SolveState<V::Scalar> {
        let at = &mut self.at;
        verbs.clear(&mut at.g);
        verbs.gradient(&at.x, &mut at.g);
        method.begin(verbs, at);
        let best = verbs.residual(&at.x, &at.g);
        verbs.copy(&at.x, &mut self.best);
        verbs.copy(&at.x, &mut self.start);
        let state = SolveState::new(settings, best);
        verbs.check(best, state.start_tolerance);
        state
    }

    /// Iterates until enough checks are recorded to read them together.
    fn iterate<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        state: &mut SolveState<V::Scalar>,
        check_every: u64,
    ) {
        let (at, settings) = (&mut self.at, state.settings);
        let renewal = if verbs.rounding() > f64::EPSILON { RENEWAL_OF_COARSE_NUMBERS } else { RENEWAL };
        while state.pending.len() < verbs.checks_at_once().max(1) && state.noted < settings.max_iterations {
            for _ in 0..check_every.min(settings.max_iterations - state.noted) {
                method.step(verbs, at);
                state.noted += 1;
            }
            let fresh = method.refresh(verbs, at);
            let residual = if !fresh && state.noted % renewal < check_every {
                verbs.gradient(&at.x, &mut at.g);
                verbs.residual(&at.x, &at.g)
            } else {
                method.residual(verbs, at)
            };
            // On a tie the newer iterate is kept: infeasible systems continue with equal residuals.
            verbs.copy_if_positive(state.best - residual, &at.x, &mut self.best);
            state.best = state.best.min(residual);
            verbs.check(residual, settings.tolerance);
            state.pending.push_back((state.noted, fresh));
        }
    }

    /// Checks a candidate solution of a recurrence with a fresh gradient, and continues from it if it fails.
    fn confirm<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        state: &mut SolveState<V::Scalar>,
    ) {
        let (residual, known) = verbs.confirm(&self.at.x, &mut self.at.g);
        if known > state.settings.tolerance {
            state.refute(known);
            method.begin(verbs, &self.at);
            state.best = residual;
        }
        verbs.copy(&self.at.x, &mut self.best);
        state.take((known, state.iteration, true), verbs.products(), &mut self.history);
    }

    /// Chooses the iterate to return: the last one if the solve succeeded, else the best one, else the start.
    pub fn end<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        state: &SolveState<V::Scalar>,
        status: Status,
    ) -> (Status, u64, f64) {
        let (at, at_start) = (&mut self.at, state.at_start.unwrap_or(f64::NAN));
        // Only a fresh gradient ends a solve with this status.
        if status == Status::Solved {
            return (status, state.iteration, state.now);
        }
        // A recurrence chose the best iterate and can drift far in an infeasible system: recompute its residual.
        verbs.copy(&self.best, &mut at.x);
        verbs.gradient(&at.x, &mut at.g);
        let residual = verbs.residual(&at.x, &at.g);
        let best = verbs.read(residual);
        let residual = if best <= at_start {
            best
        } else {
            verbs.copy(&self.start, &mut at.x);
            verbs.gradient(&at.x, &mut at.g);
            at_start
        };
        let status = if residual <= state.settings.tolerance { Status::Solved } else { status };
        (status, state.iteration, residual)
    }
}

/// The progress of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations taken.
    pub iterations: u64,
    /// The residual after them, and the least one from which the solve continued.
    pub residual: f64,
    pub least: f64,
}

/// The state of one solve: its iterations and residuals.
#[derive(Clone)]
pub struct SolveState<S> {
    settings: Settings,
    /// The residual up to which the start is a solution without an iteration.
    start_tolerance: f64,
    /// The smallest residual, on the backend.
    best: S,
    /// Checks whose residuals were not read yet: the iterations taken, and whether the gradient was fresh.
    pending: VecDeque<(u64, bool)>,
    /// Iterations issued.
    noted: u64,
    /// Iterations known to be taken, and the residual after them.
    iteration: u64,
    now: f64,
    /// Whether that is the residual of a fresh gradient.
    fresh: bool,
    at_start: Option<f64>,
    least: f64,
    /// Whether the solve paused after its last check.
    paused: bool,
    /// Candidates refuted without a gain, and the least residual of those refuted before.
    refuted: u32,
    least_refuted: f64,
    /// The last residual that counted as a gain, and when it came.
    marked: f64,
    marked_at: u64,
}

impl<S> SolveState<S> {
    fn new(settings: &Settings, best: S) -> Self {
        SolveState {
            settings: *settings,
            start_tolerance: if settings.max_iterations > 0 { 0.0 } else { settings.tolerance },
            best,
            pending: VecDeque::from([(0, true)]),
            noted: 0,
            iteration: 0,
            now: f64::NAN,
            fresh: true,
            at_start: None,
            least: f64::INFINITY,
            paused: false,
            refuted: 0,
            least_refuted: f64::INFINITY,
            marked: f64::INFINITY,
            marked_at: 0,
        }
    }

    /// Reads the known residuals of pending checks. Returns whether there were any.
    fn read_checks(&mut self, verbs: &mut impl Verbs, history: &mut Option<Vec<ResidualSample>>) -> bool {
        let Checks { residuals, ended } = verbs.take_checks();
        let known = residuals.len().min(self.pending.len());
        let checks: Vec<_> = residuals.into_iter().zip(self.pending.drain(..known)).collect();
        for (residual, (taken, fresh)) in checks {
            self.take((residual, taken, fresh), verbs.products(), history);
        }
        if ended {
            self.pending.clear();
            self.noted = self.iteration;
        }
        known > 0
    }

    /// Records a residual after so many iterations, from a fresh gradient or not.
    fn take(
        &mut self,
        (residual, taken, fresh): (f64, u64, bool),
        products: u64,
        history: &mut Option<Vec<ResidualSample>>,
    ) {
        (self.now, self.iteration, self.fresh) = (residual, taken, fresh);
        if let Some(history) = history {
            history.push(ResidualSample { iterations: taken, products, residual });
        }
        self.at_start.get_or_insert(residual);
        let gained = residual > self.settings.tolerance && residual <= PROGRESS * self.marked;
        if residual.is_finite() && gained {
            (self.marked, self.marked_at) = (residual, taken);
        }
    }

    /// Whether the start was not checked yet.
    pub fn is_new(&self) -> bool {
        self.at_start.is_none()
    }

    /// The progress so far.
    pub fn progress(&self) -> Progress {
        Progress { iterations: self.iteration, residual: self.now, least: self.least }
    }

    /// Whether a gradient updated by recurrence meets the tolerance.
    fn is_candidate(&self) -> bool {
        !self.fresh && self.now <= self.settings.tolerance
    }

    /// Counts a candidate that a fresh gradient refutes.
    fn refute(&mut self, residual: f64) {
        if residual <= PROGRESS * self.least_refuted {
            (self.refuted, self.least_refuted) = (0, residual);
        }
        if residual <= NEAR * self.settings.tolerance {
            self.refuted += 1;
        }
    }

    /// The final status, if the solve has ended.
    fn status(&self) -> Option<Status> {
        let Settings { tolerance, max_iterations, .. } = self.settings;
        if !self.now.is_finite() {
            return Some(Status::NotFinite);
        }
        let enough = if self.iteration == 0 { self.start_tolerance } else { tolerance };
        if self.now <= enough {
            return Some(Status::Solved);
        }
        let solved_at_start = self.at_start.is_some_and(|residual| residual <= tolerance);
        if solved_at_start && self.iteration >= ITERATIONS_FROM_A_SOLUTION {
            return Some(Status::NoProgress);
        }
        if self.refuted >= MOST_REFUTED {
            return Some(Status::RoundingFloor);
        }
        (self.iteration >= max_iterations).then_some(Status::MaxIterations)
    }

    /// Whether the last gain is too long ago.
    fn has_stalled(&self, patience: u64) -> bool {
        self.iteration - self.marked_at >= patience.max(self.marked_at)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Problem;
    use super::super::cpu::Cpu;
    use super::*;

    /// A method whose gradient is always zero.
    struct Liar;

    impl Method<Cpu<3>> for Liar {
        fn begin(&mut self, _: &mut Cpu<3>, _: &Point<Vec<f64>>) {}
        fn step(&mut self, _: &mut Cpu<3>, at: &mut Point<Vec<f64>>) {
            at.g.fill(0.0);
        }
        fn refresh(&mut self, _: &mut Cpu<3>, _: &mut Point<Vec<f64>>) -> bool {
            false
        }
    }

    #[test]
    fn claims_that_are_always_refused_end_at_the_rounding_floor() {
        let block = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let problem =
            Problem::<3> { bodies: 2, pair: vec![[0, 1]], jacobian: vec![block], q: vec![-1e-8], ..Problem::default() };
        let mut cpu = Cpu::<3>::default();
        cpu.rebuild(&problem);
        let mut drive = Drive { at: Point { x: vec![0.0], g: Vec::new() }, ..Drive::default() };
        let settings = Settings { tolerance: 1e-9, max_iterations: 10_000 };
        let (status, iterations, residual) = drive.run(&mut cpu, &mut Liar, &settings, 1);
        assert_eq!((status, iterations, residual), (Status::RoundingFloor, u64::from(MOST_REFUTED), 1e-8));
    }

    /// A method whose first iteration leads away from the solution, and whose others do nothing.
    struct Worse;

    impl Method<Cpu<3>> for Worse {
        fn begin(&mut self, _: &mut Cpu<3>, _: &Point<Vec<f64>>) {}
        fn step(&mut self, _: &mut Cpu<3>, at: &mut Point<Vec<f64>>) {
            at.x.fill(7.0);
        }
        fn refresh(&mut self, verbs: &mut Cpu<3>, at: &mut Point<Vec<f64>>) -> bool {
            verbs.gradient(&at.x, &mut at.g);
            true
        }
    }

    fn run(start: f64, settings: Settings) -> (Vec<f64>, (Status, u64, f64)) {
        let along = |x: f64| [x, 0.0, 0.0];
        let jacobian = vec![[along(-1.0), along(1.0)]];
        let mut cpu = Cpu::<3>::default();
        cpu.rebuild(&Problem { bodies: 2, pair: vec![[0, 1]], jacobian, q: vec![-1.0], ..Problem::default() });
        let mut drive = Drive::default();
        cpu.import(&[start], &mut drive.at.x);
        let ended = drive.run(&mut cpu, &mut Worse, &settings, 1);
        (drive.at.x, ended)
    }

    #[test]
    fn a_start_within_the_tolerance_is_what_remains_where_iterations_are_no_better() {
        let settings = Settings { tolerance: 1e-3, max_iterations: 1_000 };
        let (x, (status, iterations, residual)) = run(0.5001, settings);
        assert_eq!((x[0], status, iterations), (0.5001, Status::Solved, ITERATIONS_FROM_A_SOLUTION));
        assert!((residual - 2e-4).abs() < 1e-12, "{residual:e}");
        // An exact start is not iterated, and no start is if no iteration is allowed.
        assert_eq!(run(0.5, settings).1, (Status::Solved, 0, 0.0));
        assert_eq!(run(0.5001, Settings { max_iterations: 0, ..settings }).1.0, Status::Solved);
        assert_eq!(run(0.6, Settings { max_iterations: 60, ..settings }).1.0, Status::MaxIterations);
    }
}
