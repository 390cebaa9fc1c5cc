//! The loop around an iterative method: when to stop, what to return.

use super::verbs::{Scalar, Verbs};
use super::{Settings, Status};

/// A solve stops without success when the best residual has not come down by [`PROGRESS`] over this many iterations, or over as many as
/// the last gain took to come, if those are more. The slowest stored instances pause for some hundred iterations between two gains;
/// systems without a solution never gain.
const PATIENCE: u64 = 3_000;

/// The same for methods that only contract slowly: projected Jacobi pauses for 20,000 iterations on a packing of 24 ellipsoids, while
/// the set of touching pairs settles, and then converges.
pub(crate) const PATIENCE_OF_SLOW_METHODS: u64 = 50_000;

/// Iterations after which a gradient kept by recurrence is computed afresh: the rounding of that many updates stays near 1e-14 of the
/// gradient's terms, for a thousandth of the products.
const RENEWAL: u64 = 1_000;

/// The same where rounding is coarser than in 64 bits.
const RENEWAL_OF_COARSE_NUMBERS: u64 = 50;

/// A start whose residual is within the tolerance is iterated on all the same, this often at most. Multipliers that open rows keep from the last step
/// count little each time, and unchanged over many small steps they would be a force between bodies that have parted: two ellipsoids came
/// 0.03 off their path at steps of 1e-5. One iteration takes such multipliers away; the few more are where it leaves a residual above the tolerance.
const ITERATIONS_FROM_A_SOLUTION: u64 = 50;

/// The part of the best residual that counts as a gain.
const PROGRESS: f64 = 0.99;

/// An iterate and the gradient there.
#[derive(Default)]
pub(crate) struct Point<T> {
    /// Multipliers, none negative.
    pub x: T,
    /// `q + A x`, perhaps by a recurrence.
    pub g: T,
}

/// One iterative method over the verbs `V`. Its vectors live as long as it does, and `begin` makes them ready.
pub(crate) trait Method<V: Verbs> {
    /// Begins, or begins anew, at a point whose gradient is fresh.
    fn begin(&mut self, verbs: &mut V, at: &Point<V::Vector>);
    /// Takes one iteration.
    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>);
    /// Brings `at.g` up to date before it is looked at. Says whether it is a fresh gradient; otherwise it is a recurrence's.
    fn refresh(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) -> bool;
    /// Iterations without a gain after which there is no hope.
    fn patience(&self) -> u64 {
        PATIENCE
    }
}

/// What a solve had come to where its residual was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Iterations taken.
    pub iterations: u64,
    /// Products made. On a device, which reads many residuals at once, those until it read this one.
    pub products: u64,
    /// The residual of the iterate: that of a gradient kept by recurrence, where a method keeps one.
    pub residual: f64,
}

/// The vectors of the driver.
#[derive(Default)]
pub(crate) struct Drive<T> {
    /// The iterate: the start when [`Drive::run`] is called, the best one found after it.
    pub at: Point<T>,
    best: T,
    start: T,
    /// The looks of the last solve, where someone asked for them.
    pub history: Option<Vec<Look>>,
}

impl<T> Drive<T> {
    /// Iterates until the true residual is at most the tolerance, or there is no hope. Returns the status, the iterations, and the
    /// residual of a fresh gradient at `self.at.x`, which has the smallest residual of all iterates looked at.
    ///
    /// The residual is read every `check_every` iterations. A start is a solution without any only where its residual is zero.
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
        self.run_while(verbs, method, settings, check_every, |_, _, _, _| true)
    }

    /// [`Drive::run`] that ends as if the iterations were used up where `goes_on` says so of the iterate, the number of iterations and the residual.
    pub fn run_while<V: Verbs<Vector = T>>(
        &mut self,
        verbs: &mut V,
        method: &mut impl Method<V>,
        settings: &Settings,
        check_every: u64,
        mut goes_on: impl FnMut(&V, &Point<T>, u64, f64) -> bool,
    ) -> (Status, u64, f64)
    where
        T: Default,
    {
        let at = &mut self.at;
        verbs.clear(&mut at.g);
        verbs.gradient(&at.x, &mut at.g);
        method.begin(verbs, at);
        let mut best = verbs.residual(&at.x, &at.g);
        verbs.copy(&at.x, &mut self.best);
        verbs.copy(&at.x, &mut self.start);
        let enough_at_start = if settings.max_iterations > 0 { 0.0 } else { settings.tolerance };
        verbs.look(best, enough_at_start);
        let renewal = if verbs.rounding() > f64::EPSILON { RENEWAL_OF_COARSE_NUMBERS } else { RENEWAL };
        // Looks whose residuals were not read yet: the iterations taken, and whether the gradient was fresh.
        let mut pending = vec![(0, true)];
        let mut iteration = 0;
        let (mut at_start, mut marked, mut marked_at) = (None, f64::INFINITY, 0);
        let status = loop {
            while pending.len() < verbs.looks_at_once().max(1) && iteration < settings.max_iterations {
                for _ in 0..check_every.min(settings.max_iterations - iteration) {
                    method.step(verbs, at);
                    iteration += 1;
                }
                let fresh = method.refresh(verbs, at);
                if !fresh && iteration % renewal < check_every {
                    verbs.gradient(&at.x, &mut at.g);
                }
                let residual = verbs.residual(&at.x, &at.g);
                // On a tie the newer iterate is kept: infeasible systems go on with equal residuals.
                verbs.copy_if_positive(best - residual, &at.x, &mut self.best);
                best = best.min(residual);
                verbs.look(residual, settings.tolerance);
                pending.push((iteration, fresh));
            }
            let (mut now, mut fresh) = (f64::NAN, true);
            for (residual, (taken, was_fresh)) in verbs.looks().into_iter().zip(pending.drain(..)) {
                (now, iteration, fresh) = (residual, taken, was_fresh);
                if let Some(history) = &mut self.history {
                    history.push(Look { iterations: taken, products: verbs.products(), residual });
                }
                at_start.get_or_insert(now);
                if now.is_finite() && now > settings.tolerance && now <= PROGRESS * marked {
                    (marked, marked_at) = (now, iteration);
                }
            }
            if !now.is_finite() {
                break Status::NotFinite;
            }
            let enough = if iteration == 0 { enough_at_start } else { settings.tolerance };
            if now <= enough {
                if fresh {
                    break Status::Solved;
                }
                // The recurrence says so: look with a fresh gradient, and go on from it if it does not.
                verbs.gradient(&at.x, &mut at.g);
                let residual = verbs.residual(&at.x, &at.g);
                if verbs.read(residual) > settings.tolerance {
                    method.begin(verbs, at);
                    best = residual;
                }
                verbs.copy(&at.x, &mut self.best);
                verbs.look(residual, settings.tolerance);
                pending.push((iteration, true));
                continue;
            }
            let solved_at_start = at_start.is_some_and(|residual| residual <= settings.tolerance);
            if solved_at_start && iteration >= ITERATIONS_FROM_A_SOLUTION {
                break Status::NoProgress;
            }
            if iteration >= settings.max_iterations || !goes_on(verbs, at, iteration, now) {
                break Status::MaxIterations;
            }
            if iteration - marked_at >= method.patience().max(marked_at) {
                break Status::NoProgress;
            }
        };
        let at_start = at_start.unwrap_or(f64::NAN);
        if status == Status::Solved {
            let residual = verbs.residual(&at.x, &at.g);
            return (status, iteration, verbs.read(residual));
        }
        // The best iterate was picked by a recurrence, which an infeasible system can lead far astray: look at it afresh.
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
        (if residual <= settings.tolerance { Status::Solved } else { status }, iteration, residual)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Problem;
    use super::super::cpu::Cpu;
    use super::*;

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
        let mut cpu = Cpu::default();
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
