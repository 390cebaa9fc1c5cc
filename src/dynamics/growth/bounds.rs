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
    /// multiplies the length by up to `e^(rate time) / 2`.
    pub fn longest_division(&self, start: f64, thickness: f64, (dt, duration): (f64, f64)) -> f64 {
        let [least, most] = self.targets();
        match self.rule {
            DivisionRule::Sizer => most,
            DivisionRule::Adder => start.max(most) + most,
            DivisionRule::Timer => {
                let cycle = (self.fastest_rate() * (most + dt)).exp();
                let cycles = (duration / least).ceil().clamp(0.0, MOST_CYCLES);
                start.max(2.0 * thickness) * cycle * (0.5 * cycle).max(1.0).powf(cycles)
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
