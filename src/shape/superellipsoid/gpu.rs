//! Superellipsoids in WGSL. A kernel's shape is three sizes and a number. The number of a superellipsoid is its tag
//! and, above [`TAG_BITS`], the place of its exponents in a table. The table is in the text of the kernels.
//!
//! A source with the table has `power` and the functions of the norm, and the functions of any shape also compute
//! superellipsoids. A source without one is not changed by any of this.

use super::{Norm, Superellipsoid};
use crate::gpu::{Extension, Fragment, Source, fragment};
use crate::shape::{Shape, Tag};
use std::fmt::Write as _;

/// The bits of a shape's number that are its tag; a float holds the others exactly.
const TAG_BITS: u32 = 15;

/// The functions of shapes that also compute superellipsoids.
const EXTENSIONS: [Extension; 3] = [
    Extension {
        of: "separation/body.wgsl",
        functions: &["bounding_radius", "thickness", "half_extents", "hull"],
        with: fragment!("separation/body_superellipsoid.wgsl"),
    },
    Extension {
        of: "shape/shape.wgsl",
        functions: &["solid", "major_axis", "axis_of_revolution"],
        with: fragment!("shape/superellipsoid/shape.wgsl"),
    },
    Extension { of: "walls/find.wgsl", functions: &["places"], with: fragment!("walls/places_superellipsoid.wgsl") },
];

const FRAGMENTS: [Fragment; 2] =
    [fragment!("shape/superellipsoid/power.wgsl"), fragment!("shape/superellipsoid/norm.wgsl")];

/// The exponents of the superellipsoids of a scene, each pair once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exponents(Vec<[f64; 2]>);

impl Exponents {
    /// The exponents of these shapes.
    pub fn of(shapes: &[Shape]) -> Exponents {
        let mut found: Vec<_> = shapes.iter().filter_map(Shape::exponents).collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        found.dedup();
        Exponents(found)
    }

    /// Whether there are no superellipsoids.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A shape as a kernel has it; a superellipsoid whose exponents the table lacks is not a number.
    pub fn numbers(&self, shape: &Shape) -> [f64; 4] {
        let (tag, [x, y, z]) = shape.code();
        let place = |exponents| self.0.iter().position(|of| *of == exponents);
        let number = match shape.exponents() {
            None => f64::from(tag),
            Some(exponents) => {
                place(exponents).map_or(f64::NAN, |place| f64::from(tag + (TAG_BITS + 1) * place as u32))
            }
        };
        [x, y, z, number]
    }

    /// The shape of these numbers; `None` for those of no shape.
    pub fn shape(&self, [x, y, z, number]: [f64; 4]) -> Option<Shape> {
        let number = number as u32;
        let exponents = self.0.get((number / (TAG_BITS + 1)) as usize).copied();
        Shape::from_numbers(number & TAG_BITS, [x, y, z], exponents)
    }

    /// Adds the table and the functions of superellipsoids, if there are any.
    #[must_use]
    pub fn add_to(&self, source: Source) -> Source {
        if self.is_empty() {
            return source;
        }
        let source = source
            .extended(&EXTENSIONS)
            .integer("TAG_BITS", TAG_BITS)
            .integer("SUPERELLIPSOID", Tag::Superellipsoid as u32);
        let table = self.table(&source);
        FRAGMENTS.into_iter().fold(source.text(&table), Source::include)
    }

    /// The function that gives the exponents of a shape's number, with the numbers that only they determine: of the
    /// body with semi-axes of one, the length under every radius of curvature, the volume, and the integrals of the
    /// squared coordinates. An ellipsoid has the exponents 2.
    fn table(&self, source: &Source) -> String {
        let mut text = "struct Exponents {
    exponents: vec2r,
    less: vec2r,
    roundness: real,
    volume: real,
    moments: vec3r,
}

fn exponents_of(kind: u32) -> Exponents {
    if (kind & TAG_BITS) != SUPERELLIPSOID { return Exponents(vec2r(2.0, 2.0), vec2r(1.0, 1.0), 1.0, 0.0, vec3r()); }
    switch kind / (TAG_BITS + 1u) {
"
        .to_owned();
        for (place, exponents) in self.0.iter().enumerate() {
            let norm = Norm::new([1.0; 3], *exponents);
            let inertia = norm.unit_inertia();
            let across = 0.5 * inertia.z;
            let less = exponents.map(|n| 1.0 / (n - 1.0));
            let roundness = Superellipsoid::new([1.0; 3], *exponents).convex().roundness();
            let number = |x: f64| source.literal(x);
            let pair = |v: [f64; 2]| format!("vec2r({}, {})", number(v[0]), number(v[1]));
            let moments = [across, across, inertia.x - across].map(number).join(", ");
            let (exponents, less, volume) = (pair(*exponents), pair(less), number(norm.volume()));
            let roundness = number(roundness);
            let _ = writeln!(
                text,
                "        case {place}u: {{ return Exponents({exponents}, {less}, {roundness}, {volume}, vec3r({moments})); }}"
            );
        }
        text + "        default: {
            let none = vec2r(not_a_number());
            return Exponents(none, none, none.x, none.x, vec3r(none.x));
        }
    }
}

"
    }
}
