//! Decides between one more iteration of conjugate gradients and the safeguard: by counts, never by clocks, so that a
//! scene takes the same path everywhere.

use crate::lcp::cpu::Cpu;
use crate::lcp::drive::Progress;
use crate::lcp::interior_point::InteriorPoint;
use crate::lcp::portion::Portion;

/// Iterations that `auto` takes, and predicted further ones, before it computes the cost of the interior-point method.
/// That computation costs about as much.
pub(super) const ITERATIONS_BEFORE_FORECAST: u64 = 200;

/// Iterations between two measurements of the residual's decrease. The last two predict the remaining iterations.
pub(super) const WINDOW: u64 = 100;

/// The part of the interior-point method's cost that `auto` spends on conjugate gradients at least, because residuals
/// stagnate at times: 0 to 0.3 cost the same within 3 %.
const LEAST_BEFORE_SAFEGUARD: f64 = 0.1;

/// The part of that cost that conjugate gradients may still need, as the residuals predict. A colony to 2,048 cells at
/// dt 0.01 takes the same products with 0 and 0.1. With nearly parallel rows 200 LCPs of colonies take the same time
/// within 4 % with 0 to 0.5, and up to 8 % more with 1.
const MOST_REMAINING: f64 = 0.1;

/// The cost of an iteration beside its rows, which matters if these are few: 176 to 360 rows of a chamber take 10.1
/// nanoseconds a row and iteration on one idle core, 1,500 to 3,400 of a colony 7.3.
const NANOSECONDS_OF_AN_ITERATION: f64 = 600.0;

/// Nanoseconds per row of an iteration of the conjugate gradients, on one idle core: 7.3 to 9.5 for 1,500 to 70,000
/// rows (AMD EPYC, November 2026), in the plane and in space. The number of threads changes no decision, so it changes
/// no bits.
const NANOSECONDS_OF_A_ROW: f64 = 8.0;

/// The same for nearly parallel rows, in the order of their pairs: in busier hours 1.7 times as much as for others.
const NANOSECONDS_OF_A_PARALLEL_ROW: f64 = 13.0;

/// Decides whether to take one more iteration: yes while all iterations together cost less than the safeguard would,
/// and the predicted remaining ones cost less than a part of it. Later problems of a step reuse its first forecast:
/// they have the same pairs and few more.
pub(super) fn affordable<const D: usize, P: Portion<D>>(
    safeguard: &mut InteriorPoint<D>,
    forecast: &mut Option<f64>,
    tolerance: f64,
    parallel_rows: bool,
) -> impl FnMut(&Cpu<D, P>, Progress) -> bool {
    let mut marks = [f64::INFINITY; 2];
    move |cpu, Progress { iterations, least, .. }| {
        if !iterations.is_multiple_of(WINDOW) {
            return true;
        }
        let gain = (marks[0] / least).ln() / (2 * WINDOW) as f64;
        marks = [marks[1], least];
        let left = (least / tolerance).ln() / gain;
        if iterations < ITERATIONS_BEFORE_FORECAST || left <= ITERATIONS_BEFORE_FORECAST as f64 {
            return true;
        }
        let cost = *forecast.get_or_insert_with(|| safeguard.forecast(P::gathered(cpu)).unwrap_or(f64::INFINITY));
        let of_a_row = if parallel_rows { NANOSECONDS_OF_A_PARALLEL_ROW } else { NANOSECONDS_OF_A_ROW };
        let instead = cost / (of_a_row * cpu.all_rows() as f64 + NANOSECONDS_OF_AN_ITERATION);
        let taken = iterations as f64;
        taken < LEAST_BEFORE_SAFEGUARD * instead || (taken < instead && left < MOST_REMAINING * instead)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::chain;
    use super::*;

    /// The iteration at which `auto` gives up if the residual falls by `factor` every hundred iterations and the
    /// safeguard costs as much as 2,000.
    fn given_up(factor: f64) -> u64 {
        let mut cpu = Cpu::<3>::default();
        cpu.rebuild(&chain(1_000));
        let mut forecast = Some(2_000.0 * NANOSECONDS_OF_A_PARALLEL_ROW * 1_000.0);
        let mut safeguard = InteriorPoint::default();
        let mut goes_on = affordable(&mut safeguard, &mut forecast, 1e-6, true);
        let goes_on = |iteration: &u64| {
            let residual = factor.powf(*iteration as f64 / -100.0);
            goes_on(&cpu, Progress { iterations: *iteration, residual, least: residual })
        };
        (0..5_000).take_while(goes_on).count() as u64
    }

    #[test]
    fn a_solve_is_handed_over_where_what_is_left_costs_more_than_it_may() {
        assert_eq!(given_up(1.0), ITERATIONS_BEFORE_FORECAST);
        assert_eq!(given_up(1.5), ITERATIONS_BEFORE_FORECAST);
        // Four decades are left after 200 iterations, at one decade per hundred: a fifth of the cost.
        assert_eq!(given_up(10.0), ITERATIONS_BEFORE_FORECAST);
        assert_eq!(given_up(40.0), 5_000);
    }
}
