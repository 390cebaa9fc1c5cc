//! Errors of a trajectory, their order of convergence, and the cost of an error.

use serde::Serialize;

/// `sqrt(integral of (a - b)^2 dt)` over samples that are `interval` apart, by the trapezoidal rule. Where one has more
/// samples, those count that both have.
pub fn l2(a: &[f64], b: &[f64], interval: f64) -> f64 {
    let squares: Vec<f64> = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).collect();
    let [first, .., last] = squares[..] else { return 0.0 };
    (interval * (squares.iter().sum::<f64>() - 0.5 * (first + last))).sqrt()
}

/// The order `p` of errors `C dt^p` at two steps; `None` where it has none, as an error is zero or the steps are the
/// same.
pub fn order(dt: [f64; 2], error: [f64; 2]) -> Option<f64> {
    let order = (error[0] / error[1]).ln() / (dt[0] / dt[1]).ln();
    order.is_finite().then_some(order)
}

/// The limit of a sequence of order `order` from its values at two steps, the coarse one `ratio` times the fine one
/// (Richardson).
pub fn extrapolated(coarse: &[f64], fine: &[f64], ratio: f64, order: f64) -> Vec<f64> {
    let weight = 1.0 / (ratio.powf(order) - 1.0);
    coarse.iter().zip(fine).map(|(coarse, fine)| fine + weight * (fine - coarse)).collect()
}

/// The source of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reached {
    /// An upper bound: the coarsest run is already more accurate.
    Already,
    /// Between two runs.
    Between,
    /// Beyond the finest run, along the line through the two finest.
    Beyond,
}

/// A cost and its source.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// The cost.
    pub value: f64,
    /// Its source.
    pub reached: Reached,
}

/// What `error` costs by runs of `(cost, error)`, coarse ones first: along straight lines in logarithms. `None` where
/// the runs do not get there, or are fewer than two.
pub fn cost_at(runs: &[(f64, f64)], error: f64) -> Option<Cost> {
    let usable: Vec<(f64, f64)> = runs.iter().copied().filter(|(cost, error)| *cost > 0.0 && *error > 0.0).collect();
    let [first, .., last] = usable[..] else { return None };
    if first.1 <= error {
        return Some(Cost { value: first.0, reached: Reached::Already });
    }
    let along = |[a, b]: [(f64, f64); 2]| {
        let part = (error / a.1).ln() / (b.1 / a.1).ln();
        a.0 * (b.0 / a.0).powf(part)
    };
    if let Some(pair) = usable.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error) {
        return Some(Cost { value: along([pair[0], pair[1]]), reached: Reached::Between });
    }
    let before = usable[usable.len() - 2];
    (last.1 < before.1 && last.0 > before.0).then(|| Cost { value: along([before, last]), reached: Reached::Beyond })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs().max(1.0)
    }

    #[test]
    fn the_norm_of_known_functions() {
        // A constant: |c| sqrt(T). A sine over whole periods: sqrt(T / 2), exactly by the trapezoidal rule.
        let zeros = vec![0.0; 101];
        assert!(near(l2(&vec![-0.5; 101], &zeros, 0.4), 0.5 * 40f64.sqrt()));
        let sine: Vec<f64> = (0..=100).map(|k| (2.0 * PI * f64::from(k) / 50.0).sin()).collect();
        assert!(near(l2(&sine, &zeros, 0.4), 20f64.sqrt()));
        assert!(near(l2(&zeros, &sine, 0.4), 20f64.sqrt()));
        // t from 0 to 1: 1 / sqrt(3), from above and at second order.
        let line = |n: u32| (0..=n).map(|k| f64::from(k) / f64::from(n)).collect::<Vec<f64>>();
        let error = |n: u32| l2(&line(n), &vec![0.0; n as usize + 1], 1.0 / f64::from(n)) - (1.0f64 / 3.0).sqrt();
        assert!(error(10) > 0.0 && (3.9..4.1).contains(&(error(10) / error(20))));
        assert_eq!((l2(&[1.0], &[0.0], 1.0), l2(&[], &[], 1.0)), (0.0, 0.0));
    }

    #[test]
    fn the_order_of_known_sequences() {
        for p in [1.0, 2.0, 2.5] {
            let error = |dt: f64| 3.0 * dt.powf(p);
            assert!(near(order([0.1, 0.01], [error(0.1), error(0.01)]).unwrap(), p));
            assert!(near(order([0.4, 0.2], [error(0.4), error(0.2)]).unwrap(), p));
        }
        assert_eq!(order([0.1, 0.01], [1e-3, 0.0]), None);
        assert_eq!(order([0.1, 0.1], [1e-3, 1e-4]), None);
    }

    #[test]
    fn extrapolation_takes_the_leading_error_away() {
        let value = |dt: f64, p: f64| vec![2.0 + 0.7 * dt.powf(p), -1.0 - 5.0 * dt.powf(p)];
        for (ratio, p) in [(2.0, 1.0), (10.0, 1.0), (2.0, 2.0)] {
            let limit = extrapolated(&value(0.1 * ratio, p), &value(0.1, p), ratio, p);
            assert!(near(limit[0], 2.0) && near(limit[1], -1.0), "{limit:?}");
        }
    }

    #[test]
    fn the_cost_of_an_error_along_power_laws() {
        // First order: cost 1 / dt, error dt.
        let runs: Vec<(f64, f64)> = [1e-1, 1e-2, 1e-3].map(|dt| (1.0 / dt, dt)).into();
        let at = |error: f64| cost_at(&runs, error).unwrap();
        assert!(near(at(3e-2).value, 1.0 / 3e-2) && at(3e-2).reached == Reached::Between);
        assert!(near(at(1e-3).value, 1e3) && at(1e-3).reached == Reached::Between);
        assert!((at(1e-5).value / 1e5 - 1.0).abs() < 1e-9 && at(1e-5).reached == Reached::Beyond);
        assert_eq!(at(0.5), Cost { value: 10.0, reached: Reached::Already });
        // Errors that no longer decrease have no cost, nor does a single run.
        assert_eq!(cost_at(&[(10.0, 1e-2), (100.0, 1e-2)], 1e-3), None);
        assert_eq!(cost_at(&runs[..1], 1e-3), None);
        // A run without error has no place in a plot of logarithms.
        assert!(near(cost_at(&[runs[0], runs[1], (1e9, 0.0)], 1e-3).unwrap().value, 1e3));
    }
}
