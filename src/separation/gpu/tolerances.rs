//! The tolerances of separations in WGSL.

use crate::gpu::Source;

/// Adds the tolerances, each a number of roundings, but at least the CPU's tolerance for 64 bits.
pub(crate) fn add_tolerances_to(source: Source) -> Source {
    let epsilon = source.precision().epsilon();
    let tolerances = [
        // Distances and maxima this close, as a fraction of the sizes, are equal: well above rounding.
        ("TIE", 1e-13, 4.0),
        // Distance, as a fraction of the sizes times the sine between two curves, below which the normal follows from
        // the curves instead of the gap between them, which has lost more digits.
        ("MEETING", 1e-6, 1e4),
        // Sine below which axes count as parallel. The ends of segments 1000 diameters long then differ by 1e-9
        // diameters in 64 bits, by 1e-3 in 32 bits, where an axis is rounded to a tenth of this.
        ("PARALLEL_SINE", 1e-12, 16.0),
        // Sine below which a part across a direction is small beside the whole, so that it is projected twice; and
        // below which it is rounding of the whole.
        ("SMALL_SINE", 1e-3, 0.0),
        ("ROUNDING_SINE", 1e-15, 5.0),
        // A position on a segment within this part of its half length of an end is the end.
        ("END_ROUNDING", 1e-12, 8.0),
        // A normal is at right angles to a segment if its cosine is below this.
        ("RIGHT_ANGLE", 1e-9, 16.0),
        // A gradient, and a change of the maximized function, that are rounding, as fractions of the sizes.
        ("GRADIENT_FLOOR", 0.0, 2.0),
        ("VALUE_FLOOR", 0.0, 4.0),
        // The longest last step to a maximum, relative to the angle over which the curvature changes: points leave the
        // surfaces by its square, 1e-8 in 64 bits and 1e-3 in 32 bits.
        ("LAST_CLIMB", 1e-4, 2.5e5),
    ];
    tolerances
        .into_iter()
        .fold(source, |source, (name, least, roundings)| source.real(name, (roundings * epsilon).max(least)))
}
