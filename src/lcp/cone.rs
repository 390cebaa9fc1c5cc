//! The admissible multipliers, defined once for all solvers. Kernels have the same functions in
//! `shaders/lcp/cone.wgsl`.
//!
//! The multiplier `gamma` of a row lies in a cone, its gap `g` in the dual cone, and the two are complementary:
//!
//! ```text
//! K contains gamma  _|_  g in K*
//! ```
//!
//! Contact only pushes: `K` is the ray `gamma >= 0`. Its dual is the same ray, so each function serves multipliers and
//! gaps alike. NaN is neither in the cone nor outside.

/// The projection onto the cone.
#[inline]
pub(crate) fn project(x: f64) -> f64 {
    x.max(0.0)
}

/// The distance to the cone, `project(x) - x`. For a gap this is the overlap.
#[inline]
pub(crate) fn lack(x: f64) -> f64 {
    (-x).max(0.0)
}

/// A start value as a multiplier: zero if it is not admissible.
#[inline]
pub(crate) fn admit(x: f64) -> f64 {
    if is_free(x) && x.is_finite() { x } else { 0.0 }
}

/// Whether `x` is in the cone.
#[inline]
pub(crate) fn contains(x: f64) -> bool {
    x >= 0.0
}

/// Whether `x` is outside the cone.
#[inline]
pub(crate) fn is_outside(x: f64) -> bool {
    x < 0.0
}

/// Whether `x` is in the interior: such a multiplier pushes, and may change both ways.
#[inline]
pub(crate) fn is_free(x: f64) -> bool {
    x > 0.0
}

/// Whether `x` is at the bound or outside.
#[inline]
pub(crate) fn is_bound(x: f64) -> bool {
    x <= 0.0
}

/// The largest `t` with `x + t d` in the cone, for `x` in it; infinite if there is none. Both sides are computed
/// without a branch, because the sign is not predictable.
#[inline]
pub(crate) fn room(x: f64, d: f64) -> f64 {
    if d < 0.0 { x / -d } else { f64::INFINITY }
}

/// The natural residual of a row, `|min(g, s x)|` with `s` its diagonal entry of `A`: a length, zero if the row by
/// itself is solved. A row with `s = 0` does not depend on its multiplier: its residual is `|min(g, 0)|`. NaN if `g` or
/// `s x` is.
#[inline]
pub(crate) fn residual(g: f64, s: f64, x: f64) -> f64 {
    let scaled = s * x;
    // Not `f64::min`, which would hide a NaN, and no branch, because the smaller of the two is not predictable.
    let least = if (g < scaled) | g.is_nan() { g } else { scaled };
    least.abs()
}

/// The larger of two residuals, NaN if one is.
#[inline]
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if (a >= b) | a.is_nan() { a } else { b }
}

/// Whether the gap is larger than the scaled multiplier, so that a solution has the multiplier at the bound. A row that
/// does not depend on its multiplier is open.
#[inline]
pub(crate) fn is_open(g: f64, s: f64, x: f64) -> bool {
    s * x < g || s == 0.0
}

/// A multiplier and its slack, which replaces the gap. An interior-point method keeps both positive.
#[derive(Clone, Copy)]
pub(crate) struct Inner {
    pub gamma: f64,
    pub slack: f64,
}

impl Inner {
    /// The pair of a row without a multiplier at this gap; both are at least `shift` inside their bounds.
    #[inline]
    pub fn at(gap: f64, shift: f64) -> Self {
        let slack = project(gap) + shift;
        Inner { gamma: lack(gap) + shift * (shift / slack), slack }
    }

    /// The pair with a complementarity of `shift` squared that is nearest to this multiplier and gap in its difference.
    #[inline]
    pub fn near(gamma: f64, gap: f64, shift: f64) -> Self {
        let half = 0.5 * (gamma - project(gap));
        let root = half.hypot(shift);
        // The larger one first: the other would be a difference of nearly equal numbers.
        let larger = half.abs() + root;
        let smaller = shift * (shift / larger);
        if half > 0.0 { Inner { gamma: larger, slack: smaller } } else { Inner { gamma: smaller, slack: larger } }
    }

    /// Zero if the two are complementary.
    #[inline]
    pub fn complementarity(self) -> f64 {
        self.gamma * self.slack
    }

    /// The rate at which the slack falls as the multiplier grows at constant complementarity: a step adds this to the
    /// diagonal of `A`.
    #[inline]
    pub fn compliance(self) -> f64 {
        self.slack / self.gamma
    }

    /// The slack with which the complementarity is `pull`.
    #[inline]
    pub fn slack_for(self, pull: f64) -> f64 {
        pull / self.gamma
    }

    /// The change of the slack that goes with one of the multiplier, for a complementarity of `pull` to first order.
    #[inline]
    pub fn change_of_slack(self, pull: f64, change: f64) -> f64 {
        (pull - self.slack * change) / self.gamma - self.slack
    }

    /// The largest step of both along a direction.
    #[inline]
    pub fn room(self, along: Inner) -> f64 {
        room(self.gamma, along.gamma).min(room(self.slack, along.slack))
    }

    /// The pair after this part of a direction.
    #[inline]
    pub fn after(self, part: f64, along: Inner) -> Inner {
        Inner { gamma: self.gamma + part * along.gamma, slack: self.slack + part * along.slack }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMBERS: [f64; 7] = [-3.0, -f64::MIN_POSITIVE, -0.0, 0.0, f64::MIN_POSITIVE, 0.75, 1e300];

    #[test]
    fn a_number_is_free_or_bound_and_in_the_cone_or_outside() {
        for x in NUMBERS {
            assert_eq!(is_free(x), !is_bound(x), "{x:e}");
            assert_eq!(contains(x), !is_outside(x), "{x:e}");
            assert_eq!((is_free(x), contains(x)), (x > 0.0, x >= 0.0), "{x:e}");
        }
        assert!(![contains, is_outside, is_free, is_bound].iter().any(|says| says(f64::NAN)));
    }

    #[test]
    fn the_projection_is_the_nearest_multiplier() {
        for x in NUMBERS {
            let nearest = project(x);
            assert!(contains(nearest) && project(nearest) == nearest, "{x:e}");
            assert_eq!(nearest == x, contains(x), "{x:e}");
            assert_eq!(lack(x), nearest - x, "{x:e}");
            for other in NUMBERS.into_iter().filter(|other| contains(*other)) {
                assert!((nearest - x).abs() <= (other - x).abs(), "{x:e} {other:e}");
            }
        }
    }

    #[test]
    fn what_is_no_multiplier_is_admitted_as_zero() {
        for x in [-1.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(admit(x).to_bits(), 0, "{x}");
        }
        assert_eq!((admit(0.5), admit(f64::MAX)), (0.5, f64::MAX));
    }

    #[test]
    fn the_room_ends_at_the_bound() {
        assert_eq!((room(3.0, -2.0), room(0.0, -1.0)), (1.5, 0.0));
        assert!([0.0, 2.0, f64::NAN].iter().all(|d| room(3.0, *d) == f64::INFINITY));
        for (x, d) in [(0.7, -0.3), (1e-9, -4.0), (5.0, -1e-3)] {
            let end = room(x, d);
            assert!(contains(x + 0.999 * end * d) && !contains(x + 1.001 * end * d), "{x} {d}");
        }
    }

    #[test]
    fn a_row_is_solved_on_either_branch_only() {
        assert_eq!(residual(0.0, 2.0, 5.0), 0.0);
        assert_eq!(residual(3.0, 2.0, 0.0), 0.0);
        assert_eq!(residual(-0.5, 2.0, 5.0), 0.5);
        assert_eq!(residual(3.0, 2.0, 1.0), 2.0);
        assert_eq!(residual(3.0, 2.0, -1.0), 2.0);
    }

    #[test]
    fn a_zero_row_is_solved_if_its_gap_is_open() {
        assert_eq!(residual(0.25, 0.0, 7.0), 0.0);
        assert_eq!(residual(-0.25, 0.0, 7.0), 0.25);
    }

    #[test]
    fn nan_is_never_hidden() {
        assert!(residual(f64::NAN, 1.0, 0.0).is_nan());
        assert!(residual(1.0, 1.0, f64::NAN).is_nan());
        for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
            assert!(worse(a, b).is_nan());
        }
        assert_eq!(worse(1.0, 2.0), 2.0);
    }

    /// It is the displacement of a row by a projected step of unit length.
    #[test]
    fn the_residual_is_a_projected_step() {
        for (g, s, x) in [(0.5, 2.0, 0.125), (-0.5, 2.0, 0.125), (0.25, 1.0, 3.0), (4.0, 0.5, 0.0)] {
            let scaled = s * x;
            assert_eq!(residual(g, s, x), (scaled - project(scaled - g)).abs(), "{g} {s} {x}");
            assert_eq!(is_open(g, s, x), is_bound(scaled - g) && scaled != g, "{g} {s} {x}");
        }
        assert!(is_open(-1.0, 0.0, 1.0));
    }

    #[test]
    fn the_pair_near_an_approximate_solution_has_its_difference_and_the_complementarity_asked_for() {
        for (gamma, gap) in [(0.0, 0.7), (0.7, 0.0), (0.7, -0.2), (0.3, 0.2), (0.0, -0.2), (0.0, 0.0), (5e3, 1e-9)] {
            for shift in [1e-6, 0.1] {
                let pair = Inner::near(gamma, gap, shift);
                assert!(pair.gamma > 0.0 && pair.slack > 0.0, "{gamma} {gap}");
                assert!((pair.complementarity() / (shift * shift) - 1.0).abs() < 1e-14, "{gamma} {gap}");
                let apart = pair.gamma - pair.slack - (gamma - project(gap));
                assert!(apart.abs() <= 1e-15 * (gamma + gap.abs() + shift), "{gamma} {gap}: {apart:e}");
            }
        }
    }

    #[test]
    fn an_inner_pair_stays_inside_and_keeps_its_complementarity_to_first_order() {
        for gap in [-2.0, 0.0, 3.0] {
            let pair = Inner::at(gap, 0.5);
            assert!(pair.gamma > 0.0 && pair.slack >= 0.5, "{gap}");
            let along = Inner { gamma: -0.25 * pair.gamma, slack: -0.5 * pair.slack };
            assert_eq!(pair.room(along), 2.0);
            assert_eq!(pair.after(2.0, along).slack, 0.0);
            assert!((pair.slack_for(pair.complementarity()) - pair.slack).abs() < 1e-15);
            let change = 1e-4 * pair.gamma;
            let slack = pair.change_of_slack(pair.complementarity(), change);
            assert!((slack + pair.compliance() * change).abs() < 1e-15, "{gap}: {slack:e}");
            let moved = pair.after(1.0, Inner { gamma: change, slack });
            assert!((moved.complementarity() / pair.complementarity() - 1.0).abs() < 1e-7, "{gap}");
        }
    }
}
