//! Coordinates in the device's format: a lattice cell, which is an integer, and a remainder of at most half a pitch.
//!
//! Far from the origin, a 32-bit float loses the small differences that determine contacts, and it loses small steps
//! everywhere. Integers lose neither. The pitch is a power of two, so that splitting, joining and carrying are exact
//! (`shaders/common/lattice.wgsl`).

use super::{GpuError, Source, fragment};

/// Pitches per smallest thickness of a scene: the rounding of the remainder is then 2^-34 of the thickness, and
/// coordinates reach 10^6 thicknesses.
const PITCHES: f64 = 1024.0;

/// Cells are smaller than this, so that the difference of two fits an `i32`.
pub(crate) const MOST_CELL: i32 = 1 << 30;

/// The allowed exponents of a pitch: then the pitch and its inverse are far from the limits of 32-bit floats.
const EXPONENTS: std::ops::RangeInclusive<i32> = -80..=80;

/// A lattice of coordinates.
///
/// ```
/// use relcp::internals::gpu::Lattice;
///
/// let lattice = Lattice::for_thickness(0.7)?;
/// assert_eq!(lattice.pitch(), 0.5 / 1024.0);
/// let (cell, remainder) = lattice.split(1.0001)?;
/// assert_eq!(cell, 2048);
/// assert!((lattice.join(cell, remainder) - 1.0001).abs() < 1e-15);
/// # Ok::<(), relcp::gpu::GpuError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    pitch: f64,
}

impl Lattice {
    /// The lattice for bodies with a smallest thickness of about `thickness`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if `thickness` is not a positive number that 32-bit floats represent well.
    pub fn for_thickness(thickness: f64) -> Result<Self, GpuError> {
        let exponent = (thickness / PITCHES).log2().floor();
        let good = f64::from(*EXPONENTS.start())..=f64::from(*EXPONENTS.end());
        if !good.contains(&exponent) {
            return Err(GpuError::Unsupported { what: format!("lattice for bodies of thickness {thickness:e}") });
        }
        Ok(Lattice { pitch: 2.0f64.powi(exponent as i32) })
    }

    /// The distance between cells, a power of two.
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// The cell and the remainder of a coordinate, without rounding.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if the coordinate is beyond 2^30 pitches or not finite.
    pub fn split(&self, x: f64) -> Result<(i32, f64), GpuError> {
        let cell = (x / self.pitch).round_ties_even();
        if cell.abs() < f64::from(MOST_CELL) {
            return Ok((cell as i32, x - cell * self.pitch));
        }
        let reach = f64::from(MOST_CELL) * self.pitch;
        Err(GpuError::Unsupported { what: format!("coordinate {x:e}: it must be within {reach:e} of the origin") })
    }

    /// The coordinate of a cell and a remainder.
    pub fn join(&self, cell: i32, remainder: f64) -> f64 {
        f64::from(cell) * self.pitch + remainder
    }

    /// Adds the lattice to a kernel's source: `PITCH`, `INVERSE_PITCH`, `lattice_difference` and `lattice_add`.
    #[must_use]
    pub fn define(&self, source: Source) -> Source {
        source
            .real("PITCH", self.pitch)
            .real("INVERSE_PITCH", 1.0 / self.pitch)
            .include(fragment!("common/lattice.wgsl"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_come_back_without_rounding() {
        let lattice = Lattice::for_thickness(1.0).unwrap();
        let half = lattice.pitch() / 2.0;
        for x in [0.0, 1e-9, -1e-9, half, -half, 1.0 / 3.0, -12345.678901234, 1048575.3, 1.5 * lattice.pitch()] {
            let (cell, remainder) = lattice.split(x).unwrap();
            assert!(remainder.abs() <= half, "{x}: {remainder}");
            assert_eq!(lattice.join(cell, remainder), x);
        }
    }

    #[test]
    fn refuses_what_it_cannot_hold() {
        let lattice = Lattice::for_thickness(1.0).unwrap();
        let reach = lattice.pitch() * f64::from(MOST_CELL);
        assert!(lattice.split(reach - lattice.pitch()).is_ok() && lattice.split(-reach + lattice.pitch()).is_ok());
        for x in [reach, -reach, 1e300, f64::NAN, f64::INFINITY] {
            assert!(lattice.split(x).is_err(), "{x}");
        }
        for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-30, 1e30] {
            assert!(Lattice::for_thickness(thickness).is_err(), "{thickness}");
        }
        assert_eq!(Lattice::for_thickness(1.0).unwrap().pitch(), 1.0 / 1024.0);
        assert_eq!(Lattice::for_thickness(0.999).unwrap().pitch(), 0.5 / 1024.0);
    }
}
