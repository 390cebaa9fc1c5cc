//! The loop around an iterative method: when to stop, what to return.

use super::verbs::{Looks, Scalar, Verbs};
use super::{Settings, Status};
use std::collections::VecDeque;
use std::ops::Range;

/// A solve stops without success when the best residual has not come down by [`PROGRESS`] over this many iterations, or
/// over as many as the last gain took to come, if those are more. The slowest stored instances pause for some hundred
/// iterations between two gains; systems without a solution never gain.
const PATIENCE: u64 = 3_000;

/// The same for methods that only contract slowly: projected Jacobi pauses for 20,000 iterations on a packing of 24
/// ellipsoids, while the set of touching pairs settles, and then converges.
pub(crate) const PATIENCE_OF_SLOW_METHODS: u64 = 50_000;

/// Iterations after which a gradient kept by recurrence is computed afresh: the rounding of that many updates stays
/// near 1e-14 of the gradient's terms, for a thousandth of the products.
const RENEWAL: u64 = 1_000;

/// The same where rounding is coarser than in 64 bits.
const RENEWAL_OF_COARSE_NUMBERS: u64 = 50;

/// A start whose residual is within the tolerance is iterated on all the same, this often at most. Multipliers that
/// open rows keep from the last step count little each time, and unchanged over many small steps they would be a force
/// between bodies that have parted: two ellipsoids came 0.03 off their path at steps of 1e-5. One iteration takes such
/// multipliers away; the few more are where it leaves a residual above the tolerance.
const ITERATIONS_FROM_A_SOLUTION: u64 = 50;

/// So many claims one after the other that fresh gradients refuse, none with a smaller residual than those before, are
/// the floor of rounding. The pressed systems of `tests/data/lcp` need none in f64 and none in f32 with multipliers in two
/// parts; with multipliers in one part up to 1,800 were refused and changed nothing.
const MOST_REFUSED: u32 = 16;

/// With a residual of more tolerances than this it is not rounding that refuses a claim, but rows that contradict each
/// other and multipliers that grow without bounds.
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

/// One iterative method over the verbs `V`. Its vectors live as long as it does, and `begin` makes them ready.
pub trait Method<V: Verbs> {
    /// Begins, or begins anew, at a point whose gradient is fresh.
    fn begin(&mut self, verbs: &mut V, at: &Point<V::Vector>);
    /// Takes one iteration.
    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>);
    /// Brings `at.g` up to date before it is looked at. Says whether it is a fresh gradient; otherwise it is a
    /// recurrence's.
    fn refresh(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) -> bool;
    /// Iterations without improvement after which a solve ends as `NoProgress`.
    fn patience(&self) -> u64 {
        PATIENCE
    }
}

/// What a solve had come to where its residual was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualSample {
    /// Iterations taken.
    pub iterations: u64,
    /// Products made. On a device, which reads many residuals at once, those until it read this one.
    pub products: u64,
    /// The residual of the iterate: that of a gradient kept by recurrence, where a method keeps one.
    pub residual: f64,
}

/// The vectors of the driver.
#[derive(Default)]
pub struct Drive<T> {
    /// The iterate: the start when [`Drive::run`] is called, the best one found after it.
    pub at: Point<T>,
    best: T,
    start: T,
    /// The looks of the last solve, where someone asked for them.
    pub history: Option<Vec<ResidualSample>>,
}

impl Drive<Vec<f64>> {
    /// What it needs to go on with some of the rows.
    pub fn share(&self, rows: Range<usize>) -> Self {
        let of = |numbers: &[f64]| numbers[rows.clone()].to_vec();
        let at = Point { x: of(&self.at.x), g: of(&self.at.g) };
        Drive { at, best: of(&self.best), start: Vec::new(), history: None }
    }

    /// Takes back what [`Drive::share`] gave.
    pub fn take_back(&mut self, rows: Range<usize>, share: &Self) {
        self.at.x[rows.clone()].copy_from_slice(&share.at.x);
        self.at.g[rows.clone()].copy_from_slice(&share.at.g);
        self.best[rows].copy_from_slice(&share.best);
    }
}

impl<T> Drive<T> {
    /// Iterates until the true residual is at most the tolerance, or there is no hope. Returns the status, the
    /// iterations, and the residual of a fresh gradient at `self.at.x`, which has the smallest residual of all iterates
    /// looked at.
    ///
    /// The residual is read every `check_every` iterations. A start is a solution without any only where its residual
    /// is zero.
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

    /// [`Drive::run`] that ends as if the iterations were used up where `goes_on` refuses the iterate and where the
    /// solve stands.
    pub fn run_while<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
        check_every: u64,
        mut goes_on: impl FnMut(&V, &Point<T>, Standing) -> bool,
    ) -> (Status, u64, f64)
    where
        T: Default,
    {
        let mut course = self.begin(verbs, method, settings);
        let status = loop {
            match self.go(verbs, method, &mut course, check_every, &|_| true) {
                Some(status) => break status,
                None if goes_on(verbs, &self.at, course.standing()) => {}
                None => break Status::MaxIterations,
            }
        };
        self.end(verbs, &course, status)
    }

    /// Goes on until the solve ends, or to where it `pauses`.
    pub fn go<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        course: &mut Course<V::Scalar>,
        check_every: u64,
        pauses: &impl Fn(Standing) -> bool,
    ) -> Option<Status> {
        loop {
            if !std::mem::take(&mut course.paused) {
                self.iterate(verbs, method, course, check_every);
                if !course.take_looks(verbs, &mut self.history) {
                    continue;
                }
                if course.is_claim() {
                    self.confirm(verbs, method, course);
                }
                if let Some(status) = course.verdict() {
                    return Some(status);
                }
                course.least = course.least.min(course.now);
                if pauses(course.standing()) {
                    course.paused = true;
                    return None;
                }
            }
            if course.is_hopeless(method.patience()) {
                return Some(Status::NoProgress);
            }
        }
    }

    /// The first look, at the start.
    pub fn begin<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
    ) -> Course<V::Scalar> {
        let at = &mut self.at;
        verbs.clear(&mut at.g);
        verbs.gradient(&at.x, &mut at.g);
        method.begin(verbs, at);
        let best = verbs.residual(&at.x, &at.g);
        verbs.copy(&at.x, &mut self.best);
        verbs.copy(&at.x, &mut self.start);
        let course = Course::new(settings, best);
        verbs.look(best, course.enough_at_start);
        course
    }

    /// Iterates until as many looks are noted as are best read together.
    fn iterate<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        course: &mut Course<V::Scalar>,
        check_every: u64,
    ) {
        let (at, settings) = (&mut self.at, course.settings);
        let renewal = if verbs.rounding() > f64::EPSILON { RENEWAL_OF_COARSE_NUMBERS } else { RENEWAL };
        while course.pending.len() < verbs.looks_at_once().max(1) && course.noted < settings.max_iterations {
            for _ in 0..check_every.min(settings.max_iterations - course.noted) {
                method.step(verbs, at);
                course.noted += 1;
            }
            let fresh = method.refresh(verbs, at);
            if !fresh && course.noted % renewal < check_every {
                verbs.gradient(&at.x, &mut at.g);
            }
            let residual = verbs.residual(&at.x, &at.g);
            // On a tie the newer iterate is kept: infeasible systems go on with equal residuals.
            verbs.copy_if_positive(course.best - residual, &at.x, &mut self.best);
            course.best = course.best.min(residual);
            verbs.look(residual, settings.tolerance);
            course.pending.push_back((course.noted, fresh));
        }
    }

    /// A recurrence's residual is within the tolerance: looks with a fresh gradient, and goes on from it if it is not.
    fn confirm<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        course: &mut Course<V::Scalar>,
    ) {
        let (residual, known) = verbs.confirm(&self.at.x, &mut self.at.g);
        if known > course.settings.tolerance {
            course.refuse(known);
            method.begin(verbs, &self.at);
            course.best = residual;
        }
        verbs.copy(&self.at.x, &mut self.best);
        course.take((known, course.iteration, true), verbs.products(), &mut self.history);
    }

    /// Chooses the iterate that is returned: the last one of a solve that succeeded, else the best one, else the start.
    pub fn end<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        course: &Course<V::Scalar>,
        status: Status,
    ) -> (Status, u64, f64) {
        let (at, at_start) = (&mut self.at, course.at_start.unwrap_or(f64::NAN));
        // Only the residual of a fresh gradient ends a solve so.
        if status == Status::Solved {
            return (status, course.iteration, course.now);
        }
        // A recurrence picked the best iterate, and an infeasible system can lead it far astray: look at it afresh.
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
        let status = if residual <= course.settings.tolerance { Status::Solved } else { status };
        (status, course.iteration, residual)
    }
}

/// Where a solve stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Iterations taken.
    pub iterations: u64,
    /// The residual after them, and the least one from which a solve went on.
    pub residual: f64,
    pub least: f64,
}

/// The course of one solve: its iterations and residuals.
#[derive(Clone)]
pub struct Course<S> {
    settings: Settings,
    /// The residual that a start may have to be a solution without an iteration.
    enough_at_start: f64,
    /// The smallest residual, as the backend has it.
    best: S,
    /// Looks whose residuals were not read yet: the iterations taken, and whether the gradient was fresh.
    pending: VecDeque<(u64, bool)>,
    /// Iterations noted.
    noted: u64,
    /// Iterations known to be taken, and the residual after them.
    iteration: u64,
    now: f64,
    /// Whether that is the residual of a fresh gradient.
    fresh: bool,
    at_start: Option<f64>,
    least: f64,
    /// Whether it paused after its last look.
    paused: bool,
    /// Claims refused without a gain, and the least residual of those refused before.
    refused: u32,
    least_refused: f64,
    /// The last residual that counted as a gain, and when it came.
    marked: f64,
    marked_at: u64,
}

impl<S> Course<S> {
    fn new(settings: &Settings, best: S) -> Self {
        Course {
            settings: *settings,
            enough_at_start: if settings.max_iterations > 0 { 0.0 } else { settings.tolerance },
            best,
            pending: VecDeque::from([(0, true)]),
            noted: 0,
            iteration: 0,
            now: f64::NAN,
            fresh: true,
            at_start: None,
            least: f64::INFINITY,
            paused: false,
            refused: 0,
            least_refused: f64::INFINITY,
            marked: f64::INFINITY,
            marked_at: 0,
        }
    }

    /// Reads the residuals that are known of pending looks. Says whether there were any.
    fn take_looks(&mut self, verbs: &mut impl Verbs, history: &mut Option<Vec<ResidualSample>>) -> bool {
        let Looks { residuals, ended } = verbs.looks();
        let known = residuals.len().min(self.pending.len());
        let looks: Vec<_> = residuals.into_iter().zip(self.pending.drain(..known)).collect();
        for (residual, (taken, fresh)) in looks {
            self.take((residual, taken, fresh), verbs.products(), history);
        }
        if ended {
            self.pending.clear();
            self.noted = self.iteration;
        }
        known > 0
    }

    /// Takes a residual after so many iterations, of a fresh gradient or not.
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

    /// Whether nobody has looked at the start yet.
    pub fn is_new(&self) -> bool {
        self.at_start.is_none()
    }

    /// Where it stands.
    pub fn standing(&self) -> Standing {
        Standing { iterations: self.iteration, residual: self.now, least: self.least }
    }

    /// Whether the residual of a gradient kept by recurrence is within the tolerance.
    fn is_claim(&self) -> bool {
        !self.fresh && self.now <= self.settings.tolerance
    }

    /// Counts a claim that a fresh gradient refuses.
    fn refuse(&mut self, residual: f64) {
        if residual <= PROGRESS * self.least_refused {
            (self.refused, self.least_refused) = (0, residual);
        }
        if residual <= NEAR * self.settings.tolerance {
            self.refused += 1;
        }
    }

    /// How the solve ends, if it does.
    fn verdict(&self) -> Option<Status> {
        let Settings { tolerance, max_iterations, .. } = self.settings;
        if !self.now.is_finite() {
            return Some(Status::NotFinite);
        }
        let enough = if self.iteration == 0 { self.enough_at_start } else { tolerance };
        if self.now <= enough {
            return Some(Status::Solved);
        }
        let solved_at_start = self.at_start.is_some_and(|residual| residual <= tolerance);
        if solved_at_start && self.iteration >= ITERATIONS_FROM_A_SOLUTION {
            return Some(Status::NoProgress);
        }
        if self.refused >= MOST_REFUSED {
            return Some(Status::RoundingFloor);
        }
        (self.iteration >= max_iterations).then_some(Status::MaxIterations)
    }

    /// Whether its last gain lies too far back.
    fn is_hopeless(&self, patience: u64) -> bool {
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
        let problem = Problem::<3> { bodies: 2, pair: vec![[0, 1]], jacobian: vec![block], q: vec![-1e-8] };
        let mut cpu = Cpu::<3>::default();
        cpu.rebuild(&problem);
        let mut drive = Drive { at: Point { x: vec![0.0], g: Vec::new() }, ..Drive::default() };
        let settings = Settings { tolerance: 1e-9, max_iterations: 10_000 };
        let (status, iterations, residual) = drive.run(&mut cpu, &mut Liar, &settings, 1);
        assert_eq!((status, iterations, residual), (Status::RoundingFloor, u64::from(MOST_REFUSED), 1e-8));
    }

    /// A method whose first iteration leads away from the solution, and the others nowhere.
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
        cpu.rebuild(&Problem { bodies: 2, pair: vec![[0, 1]], jacobian, q: vec![-1.0] });
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
        // One that is exact is not iterated on, and none is where no iteration is allowed.
        assert_eq!(run(0.5, settings).1, (Status::Solved, 0, 0.0));
        assert_eq!(run(0.5001, Settings { max_iterations: 0, ..settings }).1.0, Status::Solved);
        assert_eq!(run(0.6, Settings { max_iterations: 60, ..settings }).1.0, Status::MaxIterations);
    }
}
