//! How long cells become, and how many: bounds that hold whatever is drawn.

use super::{DivisionRule, Growth};
use crate::shape::Shape;
use std::f64::consts::LN_2;

/// More cycles of division than this are counted as so many: lengths and numbers are far over every limit by then.
const MOST_CYCLES: f64 = 1e4;

impl Growth {
    /// The greatest length at which a cell divides that descends from one of length `start` and of this thickness, over
    /// a time of `duration` in steps of `dt`. A cell may be longer by what it grows in a step.
    ///
    /// A sizer's is its own. An adder's cell is born with at most the mean of its mother's length at birth and of what
    /// she adds, so with no more than the greater of `start` and that. A timer's cells have no bound: each cycle
    /// multiplies the length by up to `e^(rate time) / 2`, and the longest cycles make the longest cells. A cell that
    /// divides late was shorter than two of the shortest daughters when it was due.
    pub fn longest_division(&self, start: f64, thickness: f64, (dt, duration): (f64, f64)) -> f64 {
        let [_, most] = self.targets();
        match self.rule {
            DivisionRule::Sizer => most,
            DivisionRule::Adder => start.max(most) + most,
            DivisionRule::Timer => {
                let cycle = most + dt;
                let whole = (duration / cycle).floor().max(0.0);
                // In the cycle after so many divisions, at its end or at that of the run.
                let after = |divisions: f64| {
                    (self.fastest_rate() * duration.min((divisions + 1.0) * cycle) - divisions * LN_2).exp()
                };
                start.max(2.0 * thickness) * after(0.0).max(after((whole - 1.0).max(0.0))).max(after(whole))
            }
        }
    }

    /// A cell at the shortest that it and its descendants are.
    pub fn shortest(&self, shape: &Shape) -> Shape {
        let born = match self.rule {
            DivisionRule::Sizer | DivisionRule::Adder => 0.5 * self.targets()[0],
            // A time says nothing of lengths, but that no cell is shorter than wide.
            DivisionRule::Timer => shape.shortest_length(),
        };
        self.length_of(shape).and_then(|length| shape.grown(length.min(born))).unwrap_or(*shape)
    }

    /// So many cells come of one of length `start` in a time of `duration` at most.
    ///
    /// A sizer's cell of length `L` becomes `2^k` with `k` the least for which `L e^(rate T) / 2^k` is below the
    /// division length. Of an adder no cell is born shorter than the lesser of `start` and what is added, and lengths
    /// add up to `L e^(rate T)`.
    pub fn most_descendants(&self, start: f64, duration: f64) -> f64 {
        let stretch = self.fastest_rate() * duration;
        let least = self.targets()[0];
        match self.rule {
            DivisionRule::Sizer => ((stretch / LN_2 + (start / least).log2()).floor() + 1.0).max(0.0).exp2(),
            DivisionRule::Adder => (start / start.min(least) * stretch.exp()).floor().max(1.0),
            DivisionRule::Timer => ((duration / least).floor() + 1.0).clamp(0.0, MOST_CYCLES).exp2(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn no_lineage_of_a_timer_is_longer_and_its_longest_cycles_nearly_are() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (start, thickness, dt) = (1.2, 0.7, 0.01);
        for case in 0..40 {
            let noise = 0.9 * rng.random::<f64>();
            let (time, duration) = (0.4 + rng.random::<f64>(), 8.0 * rng.random::<f64>());
            let growth = Growth { division_time_noise: noise, ..Growth::timer(0.9, time) };
            let bound = growth.longest_division(start, thickness, (dt, duration));
            let [least, most] = growth.targets();
            let mut longest = start;
            for lineage in 0..400 {
                let (mut length, mut age, mut now) = (start, 0.0, 0.0);
                let mut draw = || if lineage == 0 { most } else { least + (most - least) * rng.random::<f64>() };
                let mut division = draw();
                while now < duration {
                    (now, age, length) = (now + dt, age + dt, length * f64::exp(0.9 * dt));
                    longest = f64::max(longest, length);
                    if age >= division && 0.5 * length >= thickness {
                        (age, length, division) = (0.0, 0.5 * length, draw());
                    }
                }
            }
            let in_a_step = f64::exp(0.9 * dt);
            assert!(longest <= bound * in_a_step, "{case}: {longest} {bound}");
            // The bound begins with twice the thickness, which is more than the start here.
            assert!(bound <= 1.6 * longest, "{case}: {longest} {bound}");
        }
    }
}
