//! Numbers as a lattice point and a remainder.

use crate::gpu::GpuError;

/// The pitch of orientations: a quaternion's numbers are multiples of it and a remainder. As in `shaders/common/orientation.wgsl`.
pub(super) const TURN_PITCH: f64 = 1.0 / 1_048_576.0;

/// Lattice points a body's thickness: 2^31 of them reach two million thicknesses to either side, and the remainder's rounding
/// is 3e-11 of a thickness.
const POINTS_PER_THICKNESS: f64 = 1024.0;

/// A lattice of points a power of two apart, so that its points are exact numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    pitch: f64,
}

impl Lattice {
    /// The lattice for bodies of this least thickness.
    pub fn new(thickness: f64) -> Self {
        let exponent = (thickness / POINTS_PER_THICKNESS).log2().round();
        Lattice { pitch: exponent.clamp(-100.0, 100.0).exp2() }
    }

    /// The distance of two points.
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// A coordinate's nearest lattice point and what is left.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where the point's number does not fit 32 bits.
    pub fn split(&self, x: f64) -> Result<(i32, f64), GpuError> {
        let cell = (x / self.pitch).round();
        if cell.abs() >= f64::from(i32::MAX) {
            return Err(GpuError::Unsupported { what: format!("room for a body at {x}, two million thicknesses from the origin") });
        }
        Ok((cell as i32, x - cell * self.pitch))
    }

    /// The coordinate again.
    pub fn join(&self, cell: i32, remainder: f64) -> f64 {
        f64::from(cell) * self.pitch + remainder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_come_back() {
        let lattice = Lattice::new(0.5);
        for x in [0.0, 1e-9, -0.1, 300.123_456_789, -2000.7] {
            let (cell, remainder) = lattice.split(x).unwrap();
            assert!(remainder.abs() <= 0.5 * lattice.pitch());
            assert_eq!(lattice.join(cell, remainder), x);
        }
        assert!(lattice.split(1e9).is_err());
    }
}
