//! The natural residual of an LCP, `max over rows of |min(g, s gamma)|` with `s` the diagonal of `A`: a length, zero at
//! solutions only.
//!
//! A row whose `s` is zero does not feel its multiplier: its share is `|min(g, 0)|`, so it is satisfied exactly if `g
//! >= 0`.

/// The share of one row. NaN if `g` or `s * gamma` is.
#[inline]
pub(crate) fn of_row(g: f64, s: f64, gamma: f64) -> f64 {
    let scaled = s * gamma;
    // Not `f64::min`, which would hide a NaN; and no branches, which of the two is smaller is not predictable.
    let least = if (g < scaled) | g.is_nan() { g } else { scaled };
    least.abs()
}

/// The larger of two residuals, NaN if one is.
#[inline]
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if (a >= b) | a.is_nan() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_solved_on_either_branch_only() {
        assert_eq!(of_row(0.0, 2.0, 5.0), 0.0);
        assert_eq!(of_row(3.0, 2.0, 0.0), 0.0);
        assert_eq!(of_row(-0.5, 2.0, 5.0), 0.5);
        assert_eq!(of_row(3.0, 2.0, 1.0), 2.0);
        assert_eq!(of_row(3.0, 2.0, -1.0), 2.0);
    }

    #[test]
    fn a_zero_row_is_solved_if_its_gap_is_open() {
        assert_eq!(of_row(0.25, 0.0, 7.0), 0.0);
        assert_eq!(of_row(-0.25, 0.0, 7.0), 0.25);
    }

    #[test]
    fn nan_is_never_hidden() {
        assert!(of_row(f64::NAN, 1.0, 0.0).is_nan());
        assert!(of_row(1.0, 1.0, f64::NAN).is_nan());
        for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
            assert!(worse(a, b).is_nan());
        }
        assert_eq!(worse(1.0, 2.0), 2.0);
    }
}
