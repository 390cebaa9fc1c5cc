//! When the corrections follow the slips, over the scalars of a backend.

use crate::lcp::verbs::Scalar;

/// The corrections follow where the residual with the present ones is at most this part of the tolerance, even before
/// it is their turn.
const OF_TOLERANCE: f64 = 0.3;

/// So many follows that do not halve the least residual double the iterations between them, up to the most, and halve
/// the part of what corrections are off, down to the least.
const FOLLOWS: f64 = 20.0;
const MOST_BETWEEN: f64 = 100.0;
const LEAST_OF_CHANGE: f64 = 0.1;

/// A residual, and a number of iterations, greater than any other.
const BEYOND: f64 = 1e30;

/// What a residual of the law is made of.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::lcp) struct Measured<S = f64> {
    /// The residual with the corrections as they are.
    pub cones: S,
    /// How far the farthest correction is off.
    pub change: S,
}

/// How often the corrections of a method follow.
#[derive(Clone, Copy, Debug)]
pub(in crate::lcp) struct Paced {
    /// Iterations between two follows, at first.
    pub between: f64,
    /// And they follow where the residual with the present corrections is at most this part of what the farthest of
    /// them is off.
    pub of_change: f64,
}

/// That of `pair_block_cg`.
pub(in crate::lcp) const PACE_OF_PAIRS: Paced = Paced { between: 20.0, of_change: 1.0 };

/// When the corrections follow.
#[derive(Clone, Copy, Debug)]
pub(in crate::lcp) struct Pace<S> {
    between: S,
    of_change: S,
    /// Checks since the last follow.
    since: S,
    /// Follows since the least residual was halved, and what it was then.
    follows: S,
    marked: S,
}

impl<S: Scalar> Pace<S> {
    /// The pace of a method, whose corrections follow `at_once` or later. `number` makes scalars.
    pub fn new(of: Paced, at_once: bool, mut number: impl FnMut(f64) -> S) -> Self {
        let since = number(if at_once { BEYOND } else { 0.0 });
        let [between, of_change, follows, marked] = [of.between, of.of_change, 0.0, BEYOND].map(number);
        Pace { between, of_change, since, follows, marked }
    }

    /// Whether the corrections follow at this check (one, else zero), where `least` is the least residual so far.
    pub fn turn(&mut self, measured: Measured<S>, least: S, tolerance: S) -> S {
        let [zero, one] = [S::from(0.0), S::from(1.0)];
        self.since = self.since + one;
        let near = (self.of_change * measured.change).max(tolerance * OF_TOLERANCE.into());
        let early = (measured.cones - near).if_positive(zero, one);
        let due = (self.between - self.since).if_positive(early, one);
        let follows = self.follows + one;
        let slower = (S::from(FOLLOWS) - follows).if_positive(zero, due);
        let halved = (least - self.marked * 0.5.into()).if_positive(zero, due);
        let slower = halved.if_positive(zero, slower);
        self.between = slower.if_positive((self.between * 2.0.into()).min(MOST_BETWEEN.into()), self.between);
        self.of_change = slower.if_positive((self.of_change * 0.5.into()).max(LEAST_OF_CHANGE.into()), self.of_change);
        self.marked = halved.if_positive(least, self.marked);
        self.follows = (halved + slower).if_positive(zero, due.if_positive(follows, self.follows));
        self.since = due.if_positive(zero, self.since);
        due
    }
}
