//! What bodies take up and secrete in a step, in each cell of a grid.

/// Newton's iterations for the concentration of a cell; they converge from below, and quadratically.
const MOST_ITERATIONS: usize = 60;

/// They end where the concentration changes by less than this part of it.
const SETTLED: f64 = 1e-15;

/// The concentration `c` of a cell at a step's end, by implicit Euler: `c + sum u_k c / (h_k + c) = b`, with the
/// amounts `u_k` that would be taken up where there is plenty, and what there would be without uptake, `b`. The left
/// side rises and is concave, so that Newton's iterations from zero come from below and stay positive.
pub(super) fn after_uptake(b: f64, uptakes: &[(f64, f64)]) -> f64 {
    let mut c = 0.0;
    if b <= 0.0 {
        return b;
    }
    for _ in 0..MOST_ITERATIONS {
        let (mut left, mut slope) = (c, 1.0);
        for (most, half) in uptakes {
            left += most * c / (half + c);
            slope += most * half / ((half + c) * (half + c));
        }
        let change = (b - left) / slope;
        c += change;
        if change.abs() <= SETTLED * c {
            break;
        }
    }
    c.clamp(0.0, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uptake_by_one_species_is_the_root_of_a_quadratic() {
        for (b, most, half) in [(1.0, 0.3, 0.5), (1e-6, 10.0, 0.1), (5.0, 1e6, 1e-3), (2.0, 0.0, 1.0), (1.0, 1.0, 1e-6)]
        {
            let p: f64 = half + most - b;
            // Without cancellation.
            let root = (p * p + 4.0 * b * half).sqrt();
            let expected = if p > 0.0 { 2.0 * b * half / (p + root) } else { 0.5 * (root - p) };
            let found = after_uptake(b, &[(most, half)]);
            assert!((found / expected - 1.0).abs() < 1e-12, "{b} {most} {half}: {found} {expected}");
        }
    }

    #[test]
    fn two_species_share_what_there_is() {
        let c = after_uptake(1.0, &[(2.0, 0.5), (3.0, 0.1)]);
        assert!((c + 2.0 * c / (0.5 + c) + 3.0 * c / (0.1 + c) - 1.0).abs() < 1e-14);
        assert_eq!(after_uptake(0.0, &[(1.0, 1.0)]), 0.0);
    }
}
