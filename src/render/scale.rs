//! A colour scale: the mapping from values to colours, the same in all pictures that share it.

use super::Quantity;
use super::colour::{self, ramp};
use super::quantity::Ends;
use crate::bodies::Bodies;
use glam::Vec3;
use rayon::prelude::*;

/// The part of a state's bodies within a scale of [`Ends::Most`].
const MOST: f64 = 0.99;

/// The values at the ends of a colour ramp; values beyond get the colours of the ends.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Scale {
    /// The value at its start, dark blue.
    pub low: f64,
    /// The value at its end, yellow.
    pub high: f64,
    /// The largest value of a body, which may be beyond the end.
    pub largest: f64,
}

impl Scale {
    /// The scale for a state's values, by the quantity's rule; NaN does not count.
    pub(crate) fn of(values: &[f64], ends: Ends) -> Option<Scale> {
        let mut finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        let least = finite.iter().copied().reduce(f64::min)?;
        let largest = finite.iter().copied().reduce(f64::max)?;
        let (low, high) = match ends {
            Ends::Least => (least, largest),
            Ends::Zero => (0.0, largest),
            Ends::Most => {
                let place = ((finite.len() - 1) as f64 * MOST).ceil() as usize;
                (0.0, *finite.select_nth_unstable_by(place, f64::total_cmp).1)
            }
        };
        Some(Scale { low, high, largest })
    }

    /// The scale of two states together.
    pub(crate) fn with(self, other: Scale) -> Scale {
        Scale {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            largest: self.largest.max(other.largest),
        }
    }

    /// The position of a value, from 0 to 1; NaN is at the start.
    pub fn place(&self, value: f64) -> f64 {
        let place = (value - self.low) / (self.high - self.low);
        if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) }
    }
}

/// The linear colours of a state's bodies with these values.
pub(super) fn colours(quantity: Quantity, bodies: &Bodies, values: &[f64], scale: Option<Scale>) -> Vec<Vec3> {
    match scale {
        Some(scale) => values.par_iter().map(|value| ramp(scale.place(*value) as f32)).collect(),
        None if quantity == Quantity::Orientation => colour::of_bodies(bodies, super::Colour::Orientation),
        None => colour::of_bodies(bodies, super::Colour::Plain),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_far_values_do_not_take_the_scale() {
        let mut values: Vec<f64> = (0..1000).map(f64::from).collect();
        values[3] = 1e9;
        values.push(f64::NAN);
        let most = Scale::of(&values, Ends::Most).unwrap();
        assert!(most.largest == 1e9 && most.low == 0.0 && most.high < 1000.0 && most.high >= 989.0, "{most:?}");
        assert_eq!((most.place(0.0), most.place(1e9), most.place(f64::NAN)), (0.0, 1.0, 0.0));
        assert_eq!(Scale::of(&values, Ends::Zero), Some(Scale { low: 0.0, high: 1e9, largest: 1e9 }));
        assert_eq!(Scale::of(&[2.0, 3.0], Ends::Least), Some(Scale { low: 2.0, high: 3.0, largest: 3.0 }));
        assert_eq!(Scale::of(&[f64::NAN], Ends::Zero), None);
    }

    #[test]
    fn a_scale_of_one_value_has_the_first_colour() {
        let scale = Scale::of(&[0.0, 0.0], Ends::Most).unwrap();
        assert_eq!((scale.place(0.0), scale.place(1.0)), (0.0, 1.0));
    }
}
