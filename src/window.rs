//! When a force acts, or a wall moves.

/// The part of a period in which a force acts, where a scene does not say.
const DEFAULT_DUTY: f64 = 0.5;

/// When a force acts. In a step that the window covers in part, the force counts by that part, so its impulse over the
/// run is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Window {
    /// The time from which it acts. Without it: from the run's start.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub from: Option<f64>,
    /// The time at which it ends. Without it: never.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub to: Option<f64>,
    /// The length of a period, counted from `from` or time 0: it is on at the beginning of each and off for the rest.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub period: Option<f64>,
    /// The part of each period in which it is on, above 0 and at most 1. Without it: 0.5.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)), schemars(range(max = 1)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub duty: Option<f64>,
}

impl Window {
    /// From one time to another.
    pub const fn between(from: f64, to: f64) -> Window {
        Window { from: Some(from), to: Some(to), period: None, duty: None }
    }

    /// On for the part `duty` of each `period`, from time 0 on.
    pub const fn every(period: f64, duty: f64) -> Window {
        Window { from: None, to: None, period: Some(period), duty: Some(duty) }
    }

    /// The part of the time from `begin` to `end` in which the force acts, from 0 to 1; of no time, whether it acts
    /// then.
    ///
    /// ```
    /// use relcp::dynamics::Window;
    /// assert_eq!(Window::between(1.0, 3.0).share([2.0, 6.0]), 0.25);
    /// assert_eq!(Window::every(2.0, 0.25).share([4.0, 6.0]), 0.25);
    /// ```
    pub fn share(&self, [begin, end]: [f64; 2]) -> f64 {
        let (from, to) = (self.from.unwrap_or(f64::NEG_INFINITY), self.to.unwrap_or(f64::INFINITY));
        if begin >= end {
            return f64::from(u8::from(from <= begin && begin < to && self.is_on(begin)));
        }
        let (first, last) = (begin.max(from), end.min(to));
        if first >= last {
            return 0.0;
        }
        let on = match self.period {
            None => last - first,
            Some(period) => self.on_until(last, period) - self.on_until(first, period),
        };
        (on / (end - begin)).clamp(0.0, 1.0)
    }

    /// The longest time that the force acts without a pause, in a run from `start` on; infinite where it does not end.
    pub(crate) fn longest(&self, start: f64) -> f64 {
        let whole = self.to.unwrap_or(f64::INFINITY) - self.from.unwrap_or(start);
        match self.period {
            Some(period) if self.duty() < 1.0 => whole.min(self.duty() * period),
            _ => whole,
        }
    }

    fn origin(&self) -> f64 {
        self.from.unwrap_or(0.0)
    }

    fn duty(&self) -> f64 {
        self.duty.unwrap_or(DEFAULT_DUTY)
    }

    fn is_on(&self, time: f64) -> bool {
        self.period.is_none_or(|period| (time - self.origin()).rem_euclid(period) < self.duty() * period)
    }

    /// How long its periods are on from their origin to `time`.
    fn on_until(&self, time: f64, period: f64) -> f64 {
        let periods = ((time - self.origin()) / period).floor();
        let within = time - self.origin() - periods * period;
        self.duty() * period * periods + within.min(self.duty() * period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_of_steps_add_up_to_the_time_that_a_window_is_on() {
        let windows = [
            (Window::between(0.33, 2.71), 2.38),
            (Window::every(0.7, 0.3), 0.3 * 0.7 * 5.0 + 0.21),
            (Window { from: Some(0.5), ..Window::every(1.0, 0.25) }, 0.25 * 4.0),
            (Window { from: Some(-1.0), to: Some(1.1), ..Window::every(1.0, 0.25) }, 0.25 + 0.1),
        ];
        for (window, on) in windows {
            for steps in [1_u32, 7, 40, 1000] {
                let dt = 4.0 / f64::from(steps);
                let at = |k: u32| f64::from(k) * dt;
                let total: f64 = (0..steps).map(|k| dt * window.share([at(k), at(k + 1)])).sum();
                assert!((total - on).abs() < 1e-12, "{window:?} in {steps} steps: {total}, not {on}");
            }
        }
    }

    #[test]
    fn a_whole_step_within_counts_exactly_and_one_outside_not_at_all() {
        let window = Window::between(0.1, 0.7);
        let shares: Vec<f64> = (0..10).map(|k| window.share([0.1 * f64::from(k), 0.1 * f64::from(k + 1)])).collect();
        assert_eq!(shares[2..6], [1.0; 4]);
        assert_eq!((shares[0], shares[9]), (0.0, 0.0));
        assert_eq!([window.share([0.1; 2]), window.share([0.7; 2])], [1.0, 0.0]);
        assert_eq!([0.0, 0.2, 0.35, 0.9].map(|t| Window::every(0.7, 0.5).share([t; 2])), [1.0, 1.0, 0.0, 1.0]);
    }
}
