//! The proof that rows have no common solution of ordinary size (Farkas).
//!
//! If `J v + q >= 0`, then `0 <= y . (J v + q)` for every `y >= 0`, so `-y . q <= sum over bodies |(J^T y)_b| |v_b|`:
//! some body moves by at least `-y . q / sum |(J^T y)_b|`. If the rows contradict each other, steps of the multipliers
//! grow along such a `y` with `J^T y` near zero.

use super::rows::{UnitRows, sums};
use crate::lcp::product::dot;

/// A solution that moves a body by more than this many times the deepest violation does not count. A chain of `n`
/// bodies that push each other apart moves its ends by `n / 2` violations, and rows that are opposite up to an angle of
/// 1e-3 need a thousand. With 1e8, five of 120 contradictions are given up before they are proven; with 1e6 none is;
/// with 1e5 the proof takes three steps fewer.
const ORDINARY: f64 = 1e6;

/// The rounding error of a sum, relative to the size of its terms.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Whether `y >= 0`, with `J^T y = v`, proves that the rows have no solution.
pub(super) fn proven<const D: usize>(rows: &UnitRows<D>, y: &[f64], v: &[[f64; D]]) -> bool {
    let [gain, terms, weight] = sums(y.len(), |i| {
        let term = y[i] * rows.q[i];
        [-term, term.abs(), y[i]]
    });
    let [pull] = sums(v.len(), |body| [dot(&v[body], &v[body]).sqrt()]);
    gain - ROUNDING * terms > ORDINARY * rows.deepest * (pull + ROUNDING * weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::Problem;
    use crate::lcp::cpu::Cpu;

    #[test]
    fn only_a_contradiction_is_one() {
        let proven = |second: f64, y: [f64; 2]| {
            let problem = Problem::<3> {
                bodies: 2,
                pair: vec![[0, 1]; 2],
                jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]],
                q: vec![-0.1, second],
                ..Problem::default()
            };
            let mut cpu = Cpu::<3>::default();
            cpu.rebuild(&problem);
            let (mut rows, mut v) = (UnitRows::default(), Vec::new());
            rows.rebuild(&cpu.rows());
            rows.velocity(&y, &mut v);
            proven(&rows, &y, &v)
        };
        assert!(proven(-0.1, [1.0, 1.0]) && proven(0.0999, [3e5, 3e5]));
        // The rows leave room, or they leave none but do not contradict each other, or the multipliers do not show it.
        assert!(!proven(0.2, [1.0, 1.0]) && !proven(0.1, [1e9, 1e9]) && !proven(0.1, [0.7, 0.7]));
        assert!(!proven(-0.1, [1.0, 0.9]) && !proven(-0.1, [0.0, 0.0]));
    }
}
