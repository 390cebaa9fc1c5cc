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

/// With nearly parallel rows, the part of that cost that conjugate gradients may still need. 200 LCPs of colonies take
/// the same time within 4 % with 0 to 0.5, and up to 8 % more with 1.
const MOST_REMAINING: f64 = 0.25;

/// Up to this many rows the interior-point method takes over as soon as the residuals show that conjugate gradients are
/// slow: when cells fill a chamber, nearly singular wedges make residuals fall more and more slowly.
const MOST_ROWS_WITHOUT_PATIENCE: usize = 1024;

/// The cost of an iteration beside its rows, which matters if these are few: 170 rows of a chamber take 9 microseconds
/// per iteration on one core, of which 12 nanoseconds per row (November 2026).
const NANOSECONDS_OF_AN_ITERATION: f64 = 6000.0;

/// Nanoseconds per row of an iteration of the conjugate gradients, on one core: 11 to 16 for 3,000 to 54,000 rows
/// (November 2026), in the plane and in space. The number of threads changes no decision, so it changes no bits.
const NANOSECONDS_OF_A_ROW: f64 = 12.0;

/// The same for nearly parallel rows, in the order of their pairs: 18 to 27, and 55 to 65 if they exceed the cache.
const NANOSECONDS_OF_A_PARALLEL_ROW: f64 = 20.0;

/// Decides whether to take one more iteration: yes while all iterations together cost less than the safeguard would,
/// and, if not `patient`, while the predicted remaining ones cost less than a part of it. Later problems of a step
/// reuse its first forecast: they have the same pairs and few more.
pub(super) fn affordable<const D: usize, P: Portion<D>>(
    safeguard: &mut InteriorPoint<D>,
    forecast: &mut Option<f64>,
    tolerance: f64,
    patient: bool,
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
        let of_a_row = if patient { NANOSECONDS_OF_A_ROW } else { NANOSECONDS_OF_A_PARALLEL_ROW };
        let few = patient && cpu.all_rows() <= MOST_ROWS_WITHOUT_PATIENCE;
        let besides = if few { NANOSECONDS_OF_AN_ITERATION } else { 0.0 };
        let instead = cost / (of_a_row * cpu.all_rows() as f64 + besides);
        let taken = iterations as f64;
        let patient = patient && !few;
        taken < LEAST_BEFORE_SAFEGUARD * instead || (taken < instead && (patient || left < MOST_REMAINING * instead))
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
        let mut goes_on = affordable(&mut safeguard, &mut forecast, 1e-6, false);
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
        // Four decades are left after 200 iterations, at one decade per hundred.
        assert_eq!(given_up(10.0), 5_000);
    }
}
