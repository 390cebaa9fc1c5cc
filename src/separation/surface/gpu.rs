//! Separations from surfaces in WGSL: the encoding of surfaces, and the fragments of a kernel for one place of a body.
//!
//! The kernel has the functions
//!
//! * `surface_at(index)`, `offset_from(surface, cell, remainder)` and `gap_of(surface, offset)`, the gap of a point on
//!   the lattice;
//! * with the shapes, `separate_place(surface, offset, body, place) -> Separation`, as [`Surface::places`]; HUGE if the
//!   body has no such place.
//!
//! Surfaces are read from an array `surfaces: array<vec4r>`, [`SURFACE_VECTORS`] vectors each.

use super::super::direction::perpendicular;
use super::super::gpu::{Family, add_bodies_to, add_climb_to, add_tolerances_to};
use super::Surface;
use crate::gpu::{Fragment, GpuError, Lattice, Source, fragment};
use crate::shape::Shape;
use glam::DVec3;

/// The number of 4-vectors per surface.
pub const SURFACE_VECTORS: usize = 9;

/// The unit of offsets is two to this power in pitches: between half a thickness and one.
const UNIT_BITS: u32 = 10;

/// Unit vectors are multiples of `2^-COARSE_BITS` plus a remainder. Offsets on the lattice are at most 2^21 units, so
/// the remainder contributes at most two units, and its rounding error is that of two units. 32 bits hold sums of up to
/// 2^12 units, and distinguish them with a margin of 2^11 for an estimate in floats.
const COARSE_BITS: u32 = 20;

/// A cell is split into two parts, the lower of 12 bits, so that 32-bit floats hold both.
const CELL_BITS: u32 = 12;

/// The largest radius in units, 2^22: more than the distance between any two points of the lattice, so that no body
/// comes near a larger one.
const LARGEST_RADIUS: f64 = 4_194_304.0;

/// Differences of squares below this, in squared units, are exact in 32 bits, with an equal margin for an estimate in
/// floats.
const LARGEST_SQUARE: f64 = 1_073_741_824.0;

/// The codes of the kinds of surfaces in kernels.
#[derive(Clone, Copy)]
enum Kind {
    Plane,
    Sphere,
    Cylinder,
}

/// The part of a family of shapes in a kernel: its fragment, and the call that makes an `Arm`.
const ARMS: [(Family, Fragment, &str); 4] = [
    (Family::Segment, fragment!("separation/surface_segment.wgsl"), "arm_of_segment(body, place)"),
    (
        Family::Ellipsoid,
        fragment!("separation/surface_ellipsoid.wgsl"),
        "arm_of_ellipsoid(surface, offset, body, place)",
    ),
    (Family::Circle, fragment!("separation/surface_circle.wgsl"), "arm_of_circle(surface, offset, body, place)"),
    (
        Family::Superellipsoid,
        fragment!("separation/surface_convex.wgsl"),
        "arm_of_superellipsoid(surface, offset, body, place)",
    ),
];

/// Adds surfaces, and the gaps of points, to a source that has this [lattice](Lattice::define).
#[must_use]
pub fn add_surfaces_to(source: Source, lattice: &Lattice) -> Source {
    let coarse = f64::from(COARSE_BITS);
    let kinds = [
        ("SURFACE_PLANE", Kind::Plane as u32),
        ("SURFACE_SPHERE", Kind::Sphere as u32),
        ("SURFACE_CYLINDER", Kind::Cylinder as u32),
    ];
    source
        .constants("kinds of surfaces", kinds)
        .integer("SURFACE_VECTORS", SURFACE_VECTORS as u32)
        .integer("UNIT_BITS", UNIT_BITS)
        .real("UNIT", unit(lattice))
        .real("INVERSE_UNIT", 1.0 / unit(lattice))
        .integer("COARSE_BITS", COARSE_BITS)
        .real("COARSE_PITCH", (-coarse).exp2())
        .real("TURNS_A_UNIT", (coarse - 32.0).exp2())
        .real("LARGEST_SQUARE", LARGEST_SQUARE)
        .text(&format!(
            "const COARSE_MASK: i32 = {};\nconst UNITS_A_TURN: i32 = {};\nconst CELL_PARTS: i32 = {};\n",
            (1 << COARSE_BITS) - 1,
            1_i64 << (32 - COARSE_BITS),
            1 << CELL_BITS
        ))
        .include(fragment!("separation/surface.wgsl"))
}

/// Also adds the separations of bodies of these shapes.
#[must_use]
pub fn add_places_to(source: Source, lattice: &Lattice, shapes: &[Shape]) -> Source {
    let mut source = add_surfaces_to(add_tolerances_to(add_bodies_to(source)), lattice)
        .include(fragment!("separation/nearest.wgsl"))
        .include(fragment!("separation/basis.wgsl"))
        .include(fragment!("separation/ring.wgsl"))
        .include(fragment!("separation/point_ellipsoid.wgsl"))
        .include(fragment!("separation/surface_place.wgsl"));
    let mut text = "fn arm_of(surface: Surface, offset: Offset, body: Placed, place: u32) -> Arm {\n".to_owned();
    for (family, fragment, call) in ARMS.into_iter().filter(|(family, ..)| family.has_any(shapes)) {
        if family == Family::Superellipsoid {
            source = add_climb_to(source);
        }
        source = source.include(fragment);
        text.push_str(&format!("    if {} {{ return {call}; }}\n", family.test_of("body.kind")));
    }
    text.push_str("    return Arm(vec3r(not_a_number()), not_a_number(), true);\n}\n");
    source.text(&text)
}

/// The unit of offsets, a length.
fn unit(lattice: &Lattice) -> f64 {
    lattice.pitch() * f64::from(UNIT_BITS).exp2()
}

/// The encoding of a surface for kernels.
///
/// # Errors
/// [`GpuError::Unsupported`] if its point or centre is beyond the lattice.
pub fn surface_numbers(surface: &Surface, lattice: &Lattice) -> Result<[f64; 4 * SURFACE_VECTORS], GpuError> {
    let (kind, reference, radius, directions) = match *surface {
        Surface::Plane { point, normal } => (Kind::Plane, point, 0.0, [normal, DVec3::ZERO]),
        Surface::Sphere { centre, radius } => (Kind::Sphere, centre, radius, [DVec3::ZERO; 2]),
        Surface::Cylinder { centre, axis, radius } => {
            (Kind::Cylinder, centre, radius, [perpendicular(axis), axis.cross(perpendicular(axis))])
        }
    };
    let radius = (radius / unit(lattice)).min(LARGEST_RADIUS);
    let whole = radius.round();
    let (mut cells, mut remainders) = ([0; 3], [0.0; 3]);
    for (axis, x) in reference.to_array().into_iter().enumerate() {
        (cells[axis], remainders[axis]) = lattice.split(x)?;
    }
    let high = cells.map(|cell| cell >> CELL_BITS);
    let low = std::array::from_fn(|axis| f64::from(cells[axis] - (high[axis] << CELL_BITS)));
    let vector = |v: [f64; 3], last: f64| [v[0], v[1], v[2], last];
    let parts = |direction: DVec3| {
        let scale = f64::from(COARSE_BITS).exp2();
        let coarse = (direction * scale).round();
        [direction, coarse, direction - coarse / scale].map(|v| vector(v.to_array(), 0.0))
    };
    let [first, second] = directions.map(parts);
    let head =
        [vector(remainders, f64::from(kind as u8)), vector(high.map(f64::from), whole), vector(low, radius - whole)];
    let mut numbers = [0.0; 4 * SURFACE_VECTORS];
    for (to, from) in numbers.iter_mut().zip([head, first, second].as_flattened().as_flattened()) {
        *to = *from;
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Precision, validate};
    use crate::shape::Superellipsoid;
    use crate::shape::gpu::Exponents;

    const MAIN: &str = "
        @group(0) @binding(0) var<storage, read> surfaces: array<vec4r>;
        @group(0) @binding(1) var<storage, read_write> out: array<vec4r>;
        @compute @workgroup_size(WORKGROUP)
        fn main(@builtin(local_invocation_index) i: u32) {
            let body = Placed(i % 4u, out[i].xyz, out[i + 1u]);
            let surface = surface_at(i);
            let found = separate_place(surface, offset_from(surface, vec3<i32>(1), out[i].xyz), body, 1u);
            out[i] = vec4r(found.normal, found.separation);
        }";

    #[test]
    fn every_kernel_is_valid_in_both_precisions() {
        let shapes = [
            Shape::Sphere { radius: 1.0 },
            Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] },
            Shape::Torus { major_radius: 2.0, minor_radius: 1.0 },
        ];
        let dice = [Shape::Superellipsoid(Superellipsoid::new([1.0; 3], [8.0; 2])), shapes[0]];
        let lattice = Lattice::for_thickness(1.0).unwrap();
        for precision in [Precision::F32, Precision::F64] {
            for shapes in [&shapes[..], &shapes[..1], &shapes[1..2], &shapes[2..], &dice, &[]] {
                let source = Exponents::of(shapes).add_to(lattice.define(Source::new("places", precision)));
                let source = add_places_to(source, &lattice, shapes).text(MAIN);
                validate(&source).unwrap_or_else(|e| panic!("{precision:?} {shapes:?}: {e}"));
            }
        }
    }

    /// The kernel recovers the surface from its encoding in 32-bit floats.
    #[test]
    fn floats_hold_the_numbers() {
        let lattice = Lattice::for_thickness(0.7).unwrap();
        let centre = DVec3::new(1e5 + 1.0 / 3.0, -3e4 - 0.1, 0.123_456_789);
        let axis = DVec3::new(0.3, -0.5, 0.7).normalize();
        let numbers = surface_numbers(&Surface::Cylinder { centre, axis, radius: 1234.567 }, &lattice).unwrap();
        let floats = numbers.map(|x| f64::from(x as f32));
        let unit = 1024.0 * lattice.pitch();
        for k in 0..3 {
            assert_eq!([floats[4 + k], floats[8 + k]], [numbers[4 + k], numbers[8 + k]]);
            let cell = (4096.0 * floats[4 + k] + floats[8 + k]) as i32;
            assert!((lattice.join(cell, floats[k]) - centre[k]).abs() < 1e-10);
            for place in [12, 24] {
                assert_eq!(floats[place + 4 + k], numbers[place + 4 + k]);
                let split = floats[place + 4 + k] / 1_048_576.0 + floats[place + 8 + k];
                assert!((split - numbers[place + k]).abs() < 1e-13);
            }
        }
        assert!((unit * (floats[7] + floats[11]) - 1234.567).abs() < 1e-7 * unit);
        let directions = [12, 24].map(|at| DVec3::from_slice(&numbers[at..]));
        assert!(directions[0].cross(directions[1]).abs_diff_eq(axis, 1e-15));
        let far = Surface::Sphere { centre: DVec3::X * 1e9, radius: 1.0 };
        assert!(matches!(surface_numbers(&far, &lattice), Err(GpuError::Unsupported { .. })));
    }
}
