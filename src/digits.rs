//! Numbers for people: few digits, right to the last one shown. Files for programs have all of them.

/// Digits of a number that stands alone.
const DIGITS: usize = 6;
/// Digits of a measured length beside its bound.
const FEW: usize = 3;
/// Digits that tell any two 64-bit floats apart.
const ALL: usize = 17;

/// A number of six digits, without zeros at its end: 6.584 for 6.5840000000000005, 1e-5 for 0.00001.
///
/// ```
/// assert_eq!(relcp::digits::short(6.584_000_000_000_000_5), "6.584");
/// assert_eq!(relcp::digits::short(0.0), "0");
/// ```
pub fn short(value: f64) -> String {
    significant(value, DIGITS)
}

/// A number as its user wrote it: the fewest digits that read back as the same.
pub fn exact(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-4..1e7).contains(&size) || !value.is_finite() {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A measured length, of three digits.
pub fn few(value: f64) -> String {
    significant(value, FEW)
}

/// A number of so many digits, without zeros at its end.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let scientific = format!("{value:.*e}", digits.max(1) - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-3..DIGITS as i32).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        // Rounded once, to the digits of the mantissa.
        let rounded: f64 = scientific.parse().unwrap_or(value);
        return trimmed(&format!("{rounded:.decimals$}")).into();
    }
    format!("{}e{exponent}", trimmed(mantissa))
}

/// A number with three digits or more: as many as show on which side of `bound` it is. 1.0004e-5 beside 1e-5.
///
/// ```
/// assert_eq!(relcp::digits::beside(1.000_4e-5, 1e-5), "1.0004e-5");
/// assert_eq!(relcp::digits::beside(3.141_59e-6, 1e-5), "3.14e-6");
/// ```
pub fn beside(value: f64, bound: f64) -> String {
    let side = |x: f64| x.partial_cmp(&bound);
    let texts = (FEW..ALL).map(|digits| significant(value, digits));
    let shows = |text: &String| text.parse().is_ok_and(|shown: f64| side(shown) == side(value));
    texts.into_iter().find(shows).unwrap_or_else(|| significant(value, ALL))
}

/// A largest allowed number, rounded down: what is shown is allowed.
pub fn at_most(limit: f64) -> String {
    towards(limit, |shown| shown <= limit)
}

/// A smallest allowed number, rounded up: what is shown is allowed.
pub fn at_least(limit: f64) -> String {
    towards(limit, |shown| shown >= limit)
}

/// The number of six digits that holds and is nearest: the rounded one, or a neighbour of it.
fn towards(limit: f64, holds: impl Fn(f64) -> bool) -> String {
    let text = short(limit);
    let Ok(rounded) = text.parse::<f64>() else { return text };
    if !limit.is_finite() || holds(rounded) {
        return text;
    }
    let unit = 10_f64.powi(limit.abs().log10().floor() as i32 + 1 - DIGITS as i32);
    let step = if rounded > limit { -unit } else { unit };
    let moved = short(rounded + step);
    if moved.parse().is_ok_and(holds) { moved } else { format!("{limit:?}") }
}

/// A time, to a hundredth of the step or finer.
///
/// ```
/// assert_eq!(relcp::digits::time(6.584_000_000_000_000_5, 0.008), "6.584");
/// assert_eq!(relcp::digits::time(1e6 / 3.0, 1.0 / 3.0), "333333.333");
/// ```
pub fn time(time: f64, step: f64) -> String {
    let decimals = if step > 0.0 { (2.0 - step.log10().floor()).clamp(0.0, 15.0) as usize } else { DIGITS };
    match trimmed(&format!("{time:.decimals$}")) {
        "-0" => "0".into(),
        text => text.into(),
    }
}

/// Without zeros at the end of its decimals.
fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_noise_and_no_zeros_at_their_ends() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (6.584_000_000_000_000_5, "6.584"),
            (0.1 + 0.2, "0.3"),
            (1e-5, "1e-5"),
            (12_345.678_9, "12345.7"),
            (999_999.6, "1e6"),
            (99_999.96, "100000"),
            (-2.5, "-2.5"),
            (0.001, "0.001"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
            (100.0, "100"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn the_last_digit_shown_is_right() {
        for i in 1..2_000 {
            let value = f64::from(i).powi(7) * 1.234_567e-12;
            for digits in [3, 6, 9] {
                let shown: f64 = significant(value, digits).parse().unwrap();
                assert!((shown / value - 1.0).abs() <= 0.5 * 10_f64.powi(1 - digits as i32) * 1.000_001, "{value:?}");
            }
        }
    }

    #[test]
    fn what_a_user_wrote_is_shown_as_it_was_written() {
        for text in ["0", "-1", "0.1", "1e-300", "6.5840000000000005", "1e12", "0.00025", "-2.5"] {
            assert_eq!(exact(text.parse().unwrap()), text);
        }
    }

    #[test]
    fn limits_that_are_shown_are_allowed() {
        for i in 1..2_000 {
            let limit = f64::from(i).powi(5) / 7e9;
            let [most, least]: [f64; 2] = [at_most(limit), at_least(limit)].map(|text| text.parse().unwrap());
            assert!(most <= limit && least >= limit, "{most:?} {limit:?} {least:?}");
            assert!(most > limit * 0.999_98 && least < limit * 1.000_02);
        }
    }

    #[test]
    fn a_measured_length_shows_on_which_side_of_its_bound_it_is() {
        assert_eq!(beside(0.0, 1e-5), "0");
        assert_eq!(beside(1e-5, 1e-5), "1e-5");
        assert_eq!(beside(9.999_96e-6, 1e-5), "9.99996e-6");
        assert_eq!(beside(1.000_000_1e-5, 1e-5), "1.0000001e-5");
        assert_eq!(beside(f64::INFINITY, 1e-5), "inf");
    }

    #[test]
    fn times_are_as_fine_as_the_steps() {
        assert_eq!(time(0.1 + 0.2, 0.1), "0.3");
        assert_eq!(time(39.99999, 1e-5), "39.99999");
        assert_eq!(time(-1e-20, 0.1), "0");
        assert_eq!(time(100.0, 5.0), "100");
    }
}
