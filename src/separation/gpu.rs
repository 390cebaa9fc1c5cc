//! Separations in WGSL: the families of pairs that a scene needs, and the fragments of a kernel for one of them.
//!
//! A kernel serves one pair of families, so that a scene compiles only the pairs that its shapes can form. It has the
//! functions
//!
//! * `separate(delta, a, b, warm) -> Separation`, as [`super::separation`] or [`super::planar_separation`] for `delta =
//!   x_b - x_a`, with `warm` zero if there is no old normal;
//! * `is_of_families(kind_a, kind_b) -> bool`, whether the kernel computes a pair of such shapes;
//! * and those of [`add_bodies_to`].
//!
//! The source is in `shaders/separation/`. It follows the CPU in every degenerate case; its tolerances are functions of
//! the number type.

mod fragments;
mod tolerances;

pub(crate) use fragments::{add_climb_to, add_minima_of_circle_and_ellipsoid_to, add_minima_of_circles_to};
pub(crate) use tolerances::add_tolerances_to;

use crate::gpu::{Source, fragment};
pub use crate::shape::gpu::Exponents;
use crate::shape::gpu::add_tags_to;
use crate::shape::{Shape, Tag};

pub use super::surface::gpu::{SURFACE_VECTORS, add_places_to, add_surfaces_to, surface_numbers};

/// A pair of families of shapes that one kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PairFamilies {
    /// Spheres and rods.
    Segments,
    /// A ring, and a sphere or rod.
    CircleSegment,
    /// A ring and an ellipsoid.
    CircleEllipsoid,
    /// An ellipsoid, and a sphere or rod.
    SegmentEllipsoid,
    /// Two rings.
    Circles,
    /// Two ellipsoids.
    Ellipsoids,
    /// A superellipsoid, and a sphere or rod.
    SegmentSuperellipsoid,
    /// A superellipsoid and an ellipsoid.
    EllipsoidSuperellipsoid,
    /// Two superellipsoids.
    Superellipsoids,
}

/// A shape's family.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Segment,
    Ellipsoid,
    Circle,
    Superellipsoid,
}

impl Family {
    /// The family of a kind of shape; `None` for a shape that only the CPU supports.
    fn of(kind: Tag) -> Option<Family> {
        match kind {
            Tag::Sphere | Tag::Spherocylinder => Some(Family::Segment),
            Tag::Ellipsoid => Some(Family::Ellipsoid),
            Tag::Torus => Some(Family::Circle),
            Tag::Superellipsoid => Some(Family::Superellipsoid),
            Tag::Custom => None,
        }
    }

    /// The test whether the variable `kind` of a kernel is a shape of this family.
    pub(super) fn test_of(self, kind: &str) -> String {
        if self == Family::Superellipsoid {
            return format!("is_superellipsoid({kind})");
        }
        let tags = Tag::ALL.iter().filter(|tag| Family::of(**tag) == Some(self));
        let tests: Vec<String> = tags.filter_map(|tag| tag.constant()).map(|tag| format!("{kind} == {tag}")).collect();
        format!("({})", tests.join(" || "))
    }

    /// Whether any of these shapes is of this family.
    pub(super) fn has_any(self, shapes: &[Shape]) -> bool {
        shapes.iter().any(|shape| Family::of(shape.tag()) == Some(self))
    }
}

impl PairFamilies {
    /// All pairs of families.
    pub const ALL: [PairFamilies; 9] = [
        PairFamilies::Segments,
        PairFamilies::CircleSegment,
        PairFamilies::SegmentEllipsoid,
        PairFamilies::Circles,
        PairFamilies::Ellipsoids,
        PairFamilies::CircleEllipsoid,
        PairFamilies::SegmentSuperellipsoid,
        PairFamilies::EllipsoidSuperellipsoid,
        PairFamilies::Superellipsoids,
    ];

    /// The pairs of families that bodies of these shapes can form, in a fixed order.
    ///
    /// ```
    /// use relcp::{internals::separation::gpu::PairFamilies, shape::Shape};
    /// let rods = [Shape::Sphere { radius: 1.0 }, Shape::Spherocylinder { diameter: 1.0, length: 3.0 }];
    /// assert_eq!(PairFamilies::needed(rods.into_iter()), [PairFamilies::Segments]);
    /// ```
    pub fn needed(shapes: impl Iterator<Item = Shape>) -> Vec<PairFamilies> {
        let mut kinds: Vec<Tag> = shapes.map(|shape| shape.tag()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let made = |pair: &PairFamilies| kinds.iter().any(|a| kinds.iter().any(|b| pair.is_of_families(*a, *b)));
        PairFamilies::ALL.into_iter().filter(made).collect()
    }

    /// The pair of families of two shapes; `None` for a pair that no kernel computes.
    pub fn of(a: &Shape, b: &Shape) -> Option<PairFamilies> {
        PairFamilies::ALL.into_iter().find(|pair| pair.is_of_families(a.tag(), b.tag()))
    }

    /// Whether a pair of shapes of these kinds is of these families, in either order.
    fn is_of_families(self, kind_a: Tag, kind_b: Tag) -> bool {
        let (Some(a), Some(b)) = (Family::of(kind_a), Family::of(kind_b)) else { return false };
        let (first, second) = self.families();
        (a, b) == (first, second) || (a, b) == (second, first)
    }

    fn families(self) -> (Family, Family) {
        match self {
            PairFamilies::Segments => (Family::Segment, Family::Segment),
            PairFamilies::CircleSegment => (Family::Circle, Family::Segment),
            PairFamilies::CircleEllipsoid => (Family::Circle, Family::Ellipsoid),
            PairFamilies::SegmentEllipsoid => (Family::Ellipsoid, Family::Segment),
            PairFamilies::Circles => (Family::Circle, Family::Circle),
            PairFamilies::Ellipsoids => (Family::Ellipsoid, Family::Ellipsoid),
            PairFamilies::SegmentSuperellipsoid => (Family::Superellipsoid, Family::Segment),
            PairFamilies::EllipsoidSuperellipsoid => (Family::Ellipsoid, Family::Superellipsoid),
            PairFamilies::Superellipsoids => (Family::Superellipsoid, Family::Superellipsoid),
        }
    }

    /// A short name, for the kernel's name.
    pub fn name(self) -> &'static str {
        match self {
            PairFamilies::Segments => "segment-segment",
            PairFamilies::CircleSegment => "segment-circle",
            PairFamilies::CircleEllipsoid => "circle-ellipsoid",
            PairFamilies::SegmentEllipsoid => "segment-ellipsoid",
            PairFamilies::Circles => "circle-circle",
            PairFamilies::Ellipsoids => "ellipsoid-ellipsoid",
            PairFamilies::SegmentSuperellipsoid => "segment-superellipsoid",
            PairFamilies::EllipsoidSuperellipsoid => "ellipsoid-superellipsoid",
            PairFamilies::Superellipsoids => "superellipsoid-superellipsoid",
        }
    }

    /// Whether one of them is the family of superellipsoids, whose kernels need a source with their
    /// [exponents](Exponents::add_to).
    fn has_superellipsoids(self) -> bool {
        let (first, second) = self.families();
        [first, second].contains(&Family::Superellipsoid)
    }

    /// The text of the function `is_of_families`.
    fn test_text(self) -> String {
        let (first, second) = self.families();
        let both = |a: Family, b: Family| format!("{} && {}", a.test_of("kind_a"), b.test_of("kind_b"));
        let mut test = both(first, second);
        if first != second {
            test = format!("{test} || {}", both(second, first));
        }
        format!("fn is_of_families(kind_a: u32, kind_b: u32) -> bool {{\n    return {test};\n}}\n")
    }
}

/// What of shapes that bodies have no kernel computes.
pub(crate) fn unsupported(shapes: impl Iterator<Item = Shape>, planar: bool) -> Option<String> {
    let mut kinds: Vec<(Tag, &'static str)> = shapes.map(|shape| (shape.tag(), shape.name())).collect();
    kinds.sort_unstable();
    kinds.dedup();
    if let Some((_, name)) = kinds.iter().find(|(tag, _)| Family::of(*tag).is_none()) {
        return Some(format!("{name}s"));
    }
    if planar && kinds.iter().any(|(tag, _)| *tag == Tag::Superellipsoid) {
        return Some("superellipsoids in the plane".into());
    }
    let has_kernel = |a: Tag, b: Tag| PairFamilies::ALL.iter().any(|pair| pair.is_of_families(a, b));
    let mut pairs = kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b)));
    let ((_, a), (_, b)) = pairs.find(|((a, _), (b, _))| !has_kernel(*a, *b))?;
    Some(format!("pairs of a {a} and a {b}"))
}

/// Adds bodies in space, for shapes of all families: the structs `Placed` and `Separation`, and the functions
/// `bound(delta, a, b, normal)`, `bounding_radius(p)` and `half_extents(p)`.
#[must_use]
pub fn add_bodies_to(source: Source) -> Source {
    add_tags_to(source).include(fragment!("separation/body.wgsl"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Precision, validate};
    use crate::shape::Superellipsoid;

    fn exponents() -> Exponents {
        let of = |exponents| Shape::Superellipsoid(Superellipsoid::new([1.0, 2.0, 3.0], exponents));
        Exponents::of(&[of([8.0, 2.5]), of([2.0; 2])])
    }

    #[test]
    fn every_kernel_is_valid_in_both_precisions() {
        for precision in [Precision::F32, Precision::F64] {
            for (pair, planar) in PairFamilies::ALL.into_iter().flat_map(|pair| [(pair, false), (pair, true)]) {
                let source = exponents().add_to(Source::new(pair.name(), precision));
                let source = pair.add_to(source, planar).text(
                    "@group(0) @binding(0) var<storage, read_write> out: array<vec4r>;
                     @compute @workgroup_size(WORKGROUP)
                     fn main(@builtin(local_invocation_index) i: u32) {
                         let body = Placed(i % 4u, out[i].xyz, out[i + 1u]);
                         let found = separate(out[i + 2u].xyz, body, body, vec3r(0.0, 0.0, 0.0));
                         if is_of_families(i, 1u) { out[i] = vec4r(found.normal, found.separation); }
                     }",
                );
                validate(&source).unwrap_or_else(|e| panic!("{} {precision:?} {planar}: {e}", pair.name()));
            }
        }
    }

    #[test]
    fn a_scene_needs_what_its_shapes_can_make() {
        let shapes = [
            Shape::Sphere { radius: 1.0 },
            Shape::Spherocylinder { diameter: 1.0, length: 2.0 },
            Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] },
            Shape::Torus { major_radius: 2.0, minor_radius: 1.0 },
        ];
        assert_eq!(PairFamilies::needed(shapes.into_iter()), PairFamilies::ALL[..6]);
        let die = Shape::Superellipsoid(Superellipsoid::new([1.0; 3], [8.0; 2]));
        let with_die = [shapes[0], shapes[2], die];
        assert_eq!(PairFamilies::needed([die].into_iter()), [PairFamilies::Superellipsoids]);
        assert_eq!(PairFamilies::needed(with_die.into_iter()).len(), 6);
        assert_eq!(unsupported(with_die.into_iter(), false), None);
        let unsupported = |shapes: [Shape; 2], planar| unsupported(shapes.into_iter(), planar).unwrap();
        assert_eq!(unsupported([die, shapes[3]], false), "pairs of a torus and a superellipsoid");
        assert_eq!(unsupported([die; 2], true), "superellipsoids in the plane");
        assert_eq!(PairFamilies::needed(shapes[3..].iter().copied()), [PairFamilies::Circles]);
        assert_eq!(PairFamilies::needed(std::iter::empty()), []);
        for (a, b) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (a, b))) {
            let of = |pair: &&PairFamilies| pair.is_of_families(a.tag(), b.tag());
            assert_eq!(PairFamilies::ALL.iter().filter(of).count(), 1, "{a:?} {b:?}");
        }
    }
}
