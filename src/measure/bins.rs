//! Bins of equal width from zero on.

/// The largest number of bins in a profile; if there would be more, bins are wider.
const MOST: usize = 1000;

/// Bins of one width that cover `0..=range`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bins {
    /// The width.
    pub width: f64,
    /// Their number.
    pub count: usize,
}

impl Bins {
    /// Bins of `width`, or of its smallest whole multiple that gives at most [`MOST`]. None if the width or the range
    /// is not valid.
    pub fn new(width: f64, range: f64) -> Option<Bins> {
        if !(width > 0.0 && width.is_finite() && range >= 0.0 && range.is_finite()) {
            return None;
        }
        let width = width * (range / (width * MOST as f64)).ceil().max(1.0);
        Some(Bins { width, count: ((range / width).ceil() as usize).clamp(1, MOST) })
    }

    /// The bin of a value; the last one holds its upper end.
    pub fn of(&self, value: f64) -> Option<usize> {
        let bin = (value / self.width) as usize;
        match value {
            v if v < 0.0 || v.is_nan() => None,
            _ if bin < self.count => Some(bin),
            // Up to rounding.
            v if v <= self.width * self.count as f64 * (1.0 + 1e-12) => Some(self.count - 1),
            _ => None,
        }
    }

    /// The lower end of bin `bin`.
    pub fn lower(&self, bin: usize) -> f64 {
        self.width * bin as f64
    }

    /// The middle of bin `bin`.
    pub fn middle(&self, bin: usize) -> f64 {
        self.width * (bin as f64 + 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_cover_the_range_and_are_not_too_many() {
        let bins = Bins::new(0.5, 2.0).unwrap();
        assert_eq!(
            (bins.count, bins.of(0.0), bins.of(0.5), bins.of(2.0), bins.of(2.1)),
            (4, Some(0), Some(1), Some(3), None)
        );
        assert_eq!((bins.of(-0.1), bins.of(f64::NAN), bins.lower(1), bins.middle(1)), (None, None, 0.5, 0.75));
        let wide = Bins::new(1.0, 2500.0).unwrap();
        assert_eq!((wide.width, wide.count), (3.0, 834));
        assert_eq!(Bins::new(1.0, 0.0).unwrap().of(0.0), Some(0));
        assert_eq!(Bins::new(0.0, 1.0), None);
    }
}
