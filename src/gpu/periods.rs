//! Periods of space on the lattice of coordinates. They are as exact as coordinates, at any number of periods from the
//! origin.
//!
//! In general a period is not a whole number of pitches. It is stored as whole pitches and four parts of 11 bits, each
//! 2^-11 of the part before. A period of at least 2^11 pitches, as a 64-bit float, has no digit below the last part, so
//! the parts are exact. `n` periods are computed from them in 32-bit integers without rounding: differences are at most
//! 2^20 periods (`shaders/common/nearest_image.wgsl`).
//!
//! The offset of a sheared cell is stored in the same way, with its whole pitches rounded down. A difference subtracts
//! periods across the gradient and along the direction at once. So integers may overflow, and only the remainder
//! matters: there are at most 2^19 periods of at least 2^12 pitches each (`shaders/common/nearest_image_sheared.wgsl`).

use super::function::{Argument, Member, Part, parts};
use super::{GpuError, Lattice, MOST_CELL, Source, fragment};

/// Bits of a part. `n` times a part, plus the carry of the next finer part, fits in 32 bits.
const PART_BITS: i32 = 11;

/// The smallest number of pitches of a period: then fewer than 2^31 pitches are at most 2^20 periods, and the parts
/// hold all digits of a 64-bit float. Bodies are at most half a period long, and at least 1024 pitches thick.
const LEAST_CELLS: f64 = 2048.0;

/// The period along each axis, and the offset along one axis of the images across another.
pub type AxesAndTilt = ([Option<f64>; 3], Option<([usize; 2], f64)>);

/// The periods of a scene on its lattice.
///
/// ```
/// use relcp::internals::gpu::{Lattice, LatticePeriods};
///
/// let lattice = Lattice::for_thickness(1.0)?;
/// assert!(!LatticePeriods::new(lattice, [Some(7.3), None, None])?.is_none());
/// assert!(LatticePeriods::new(lattice, [Some(1.9), None, None]).is_err());
/// assert!(LatticePeriods::new(lattice, [Some(2e6), None, None]).is_err());
/// # Ok::<(), relcp::gpu::GpuError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticePeriods {
    lattice: Lattice,
    /// Zero for an open axis.
    length: [f64; 3],
    cells: [i32; 3],
    parts: [[i32; 3]; 4],
    tilt: Option<Tilted>,
}

/// The offset of a sheared cell, in whole pitches and parts, and its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tilted {
    /// The axis along which images are displaced, and the axis across which they are.
    axes: [usize; 2],
    cells: i32,
    parts: [i32; 4],
}

impl LatticePeriods {
    /// The periods along the periodic axes.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if one is less than 2^11 pitches of the lattice, or 2^30 or more.
    pub fn new(lattice: Lattice, lengths: [Option<f64>; 3]) -> Result<Self, GpuError> {
        let mut periods = LatticePeriods { lattice, length: [0.0; 3], cells: [0; 3], parts: [[0; 3]; 4], tilt: None };
        for (axis, length) in lengths.into_iter().enumerate() {
            let Some(length) = length else { continue };
            let pitches = length / lattice.pitch();
            if !(LEAST_CELLS..f64::from(MOST_CELL)).contains(&pitches) {
                let [least, most] = [LEAST_CELLS, f64::from(MOST_CELL)].map(|cells| cells * lattice.pitch());
                let what =
                    format!("period {length:e} for such bodies: it must be {least:e} or more and under {most:e}");
                return Err(GpuError::Unsupported { what });
            }
            periods.length[axis] = length;
            let (cells, parts) = divided(pitches);
            periods.cells[axis] = cells;
            periods.parts.iter_mut().zip(parts).for_each(|(part, of_axis)| part[axis] = of_axis);
        }
        Ok(periods)
    }

    /// The same with the offset of a sheared cell: along the first of two axes, for images across the second.
    ///
    /// # Errors
    /// As [`LatticePeriods::new`]; in a sheared cell a period is at least 2^12 pitches.
    pub fn of(lattice: Lattice, (lengths, tilt): AxesAndTilt) -> Result<Self, GpuError> {
        let periods = LatticePeriods::new(lattice, lengths)?;
        let Some((axes, offset)) = tilt else { return Ok(periods) };
        let least = 2.0 * LEAST_CELLS * lattice.pitch();
        if let Some(length) = periods.length.into_iter().find(|length| *length > 0.0 && *length < least) {
            let what = format!("period {length:e} of a sheared cell for such bodies: it must be {least:e} or more");
            return Err(GpuError::Unsupported { what });
        }
        let (cells, parts) = divided(offset / lattice.pitch());
        Ok(LatticePeriods { tilt: Some(Tilted { axes, cells, parts }), ..periods })
    }

    /// Whether no axis has a period.
    pub fn is_none(&self) -> bool {
        self.length == [0.0; 3]
    }

    /// Whether the cell is sheared.
    pub fn is_sheared(&self) -> bool {
        self.tilt.is_some()
    }

    /// Adds `lattice_difference` to the nearest image and `without_periods`, for kernels that compare two bodies. This
    /// replaces the definitions of [`Lattice::define`]. Without periods it adds those of the lattice.
    #[must_use]
    pub fn define(&self, source: Source) -> Source {
        if self.is_none() {
            return self.lattice.define(source);
        }
        let pitch = self.lattice.pitch();
        let inverse = |by: f64| self.length.map(|length| if length > 0.0 { by / length } else { 0.0 });
        let vector = |name: &str, [x, y, z]: [i32; 3]| format!("const {name} = vec3<i32>({x}, {y}, {z});\n");
        let mut integers = vector("PERIOD_CELLS", self.cells);
        for (k, part) in (1..).zip(self.parts) {
            integers.push_str(&vector(&format!("PERIOD_PART_{k}"), part));
        }
        let two_parts = f64::from(1 << (2 * PART_BITS));
        let source = source
            .include(fragment!("common/nearest_integer.wgsl"))
            .real("PITCH", pitch)
            .real("INVERSE_PITCH", 1.0 / pitch)
            .real("UPPER_PARTS", pitch / two_parts)
            .real("LOWER_PARTS", pitch / two_parts / two_parts)
            .vector("INVERSE_PERIOD", inverse(1.0))
            .vector("PERIODS_A_CELL", inverse(pitch));
        let Some(Tilted { axes: [direction, gradient], .. }) = self.tilt else {
            return source.text(&integers).include(fragment!("common/nearest_image.wgsl"));
        };
        let axis = |name: &str, axis: usize| format!("const {name} = {axis}u;\n");
        integers.push_str(&axis("SHEAR_DIRECTION", direction));
        integers.push_str(&axis("SHEAR_GRADIENT", gradient));
        source
            .text(&integers)
            .include(fragment!("common/without_sheared_periods.wgsl"))
            .include(fragment!("common/nearest_sheared_image.wgsl"))
    }
}

/// A number of pitches as a whole number, rounded down, and four parts.
fn divided(pitches: f64) -> (i32, [i32; 4]) {
    // The operations are on powers of two and differences of neighbours: only digits below the last part are rounded.
    let mut rest = pitches - pitches.floor();
    let parts = std::array::from_fn(|_| {
        rest *= f64::from(1 << PART_BITS);
        let part = rest.floor();
        rest -= part;
        part as i32
    });
    (pitches.floor() as i32, parts)
}

/// The constants of a cell, and the expressions that replace them in kernels of a changing cell.
const CHANGING: [(&str, &str); 7] = [
    ("PERIOD_PART_1", "parameters.periods[1].xyz"),
    ("PERIOD_PART_2", "parameters.periods[2].xyz"),
    ("PERIOD_PART_3", "parameters.periods[3].xyz"),
    ("PERIOD_PART_4", "parameters.periods[4].xyz"),
    ("PERIOD_CELLS", "parameters.periods[0].xyz"),
    ("INVERSE_PERIOD", "inverse_period()"),
    ("PERIODS_A_CELL", "(PITCH * inverse_period())"),
];

/// One over the period along each axis, accurate enough to count periods: the second count corrects the first.
const INVERSE_PERIOD: &str = "
fn inverse_period() -> vec3r {
    let period = PITCH * (vec3r(parameters.periods[0].xyz) + vec3r(parameters.periods[1].xyz) / 2048.0);
    return select(vec3r(), 1.0 / period, period > vec3r());
}
";

/// The offset of a sheared cell divided by the period along its direction.
const TILT_PERIODS: &str = "
fn tilt_periods() -> real {
    let offset = PITCH * (real(parameters.periods[0].w) + real(parameters.periods[1].w) / 2048.0);
    return offset * inverse_period()[SHEAR_DIRECTION];
}
";

impl LatticePeriods {
    /// A kernel's source for periods that change between steps: they are not constants but the last member of its
    /// parameters, `periods: array<vec4<i32>, 5>`, with the contents of [`LatticePeriods::words`]. Kernels of a sheared
    /// cell also read its offset there.
    #[must_use]
    pub fn changing(source: Source) -> Source {
        source.mapped(|text| {
            let lines = text
                .lines()
                .filter(|line| !line.starts_with("const PERIOD") && !line.starts_with("const INVERSE_PERIOD:"));
            let mut text = lines.collect::<Vec<_>>().join("\n") + "\n";
            for (constant, read) in CHANGING {
                text = text.replace(constant, read);
            }
            let tilt = if text.contains("tilt_periods()") { TILT_PERIODS } else { "" };
            text + INVERSE_PERIOD + tilt
        })
    }

    /// The WGSL type of `periods`.
    pub(crate) const TYPE: &str = "array<vec4<i32>, 5>";

    /// The periods in the format of such a kernel.
    pub fn words(&self) -> [[i32; 4]; 5] {
        let (cells, parts) = self.tilt.map_or((0, [0; 4]), |tilted| (tilted.cells, tilted.parts));
        let four = |[x, y, z]: [i32; 3], w: i32| [x, y, z, w];
        let [a, b, c, d] = std::array::from_fn(|k| four(self.parts[k], parts[k]));
        [four(self.cells, cells), a, b, c, d]
    }
}

/// Kernels with constant periods do not use this argument.
impl Argument for LatticePeriods {
    fn parts() -> Vec<Part> {
        parts(&[("periods", LatticePeriods::TYPE)])
    }

    fn write(&self, _: usize, to: Member<'_>) {
        to.words(bytemuck::cast_slice(&self.words()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Precision, validate};

    #[test]
    fn the_parts_are_the_period() {
        let lattice = Lattice::for_thickness(0.7).unwrap();
        for length in [1.0, 1.0 + f64::EPSILON, 10.0 / 3.0, 1e3 / 7.0, 123_456.789, 5.2e5] {
            let periods = LatticePeriods::new(lattice, [None, Some(length), None]).unwrap();
            let part = |sum: f64, part: &[i32; 3]| (sum + f64::from(part[1])) / 2048.0;
            let fraction = periods.parts.iter().rev().fold(0.0, part);
            assert_eq!((f64::from(periods.cells[1]) + fraction) * lattice.pitch(), length);
            assert!(periods.parts.iter().all(|part| (0..2048).contains(&part[1]) && part[0] == 0));
        }
    }

    #[test]
    fn refuses_what_integers_cannot_hold() {
        let lattice = Lattice::for_thickness(1.0).unwrap();
        for length in [2.0, 1_048_575.9] {
            assert!(LatticePeriods::new(lattice, [None, None, Some(length)]).is_ok(), "{length}");
        }
        for length in [1.999, 1_048_576.0, f64::NAN, f64::INFINITY, -4.0] {
            let refused = LatticePeriods::new(lattice, [None, None, Some(length)]).unwrap_err();
            assert!(refused.to_string().contains("period"), "{refused}");
        }
    }

    #[test]
    fn its_source_is_valid_and_without_periods_that_of_the_lattice() {
        for precision in [Precision::F32, Precision::F64] {
            // The finest lattice has parts near the smallest floats.
            for thickness in [1.0, 1e-21] {
                let lattice = Lattice::for_thickness(thickness).unwrap();
                let periods = LatticePeriods::new(lattice, [Some(7.3 * thickness), None, None]).unwrap();
                let source = periods.define(Source::new("periods", precision));
                validate(&source.text("@compute @workgroup_size(WORKGROUP) fn main() {}")).unwrap();
                let none = LatticePeriods::new(lattice, [None; 3]).unwrap().define(Source::new("none", precision));
                assert_eq!(none.code(), lattice.define(Source::new("none", precision)).code());
            }
        }
    }
}
