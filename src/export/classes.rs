//! Particle types of a GSD file: the size classes of each kind of shape.
//!
//! GSD assigns a shape to a *type*, not to a particle. If a run has few sizes of a kind, each has its own type, and is
//! exact. If it has many, as a colony of growing rods, their range is divided into equal classes, each drawn with the
//! size in its middle; superellipsoids, which GSD has only as meshes, are then drawn as ellipsoids.

use super::surface::{FACES, Surface};
use crate::shape::{Centreline, Geometry, Shape, Tag};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// The kinds of shape that a file can hold.
const KINDS: [Tag; 5] = [Tag::Sphere, Tag::Spherocylinder, Tag::Ellipsoid, Tag::Torus, Tag::Superellipsoid];
/// The largest number of types of a kind. OVITO 3.17 opens 256 types at once and takes 2 s for 20,000.
const MOST_TYPES: usize = 256;
/// The largest number of types of rings, each a mesh of 80 KB.
const MOST_RINGS: usize = 16;
/// The largest number of types of superellipsoids, each a mesh of 55 KB.
const MOST_SUPERELLIPSOIDS: usize = 48;
/// Faces of a ring's mesh along it and around its tube. Its corners are on the surface, and its faces are inside by at
/// most `(R + r) (1 - cos(pi/96))` and `r (1 - cos(pi/24))`: 0.05 % of the ring's radius, 0.9 % of the tube's.
const RING_FACES: [usize; 2] = [96, 24];

/// The smallest length of a class of rods, in diameters.
const LEAST_ROD: f64 = 1.0 + 1e-6;

/// A shape's sizes and exponents as bits, which have the order of the sizes because these are positive.
type Key = [u64; 5];

fn key(shape: &Shape) -> Key {
    let ([a, b, c], [n1, n2]) = (shape.code().1, shape.exponents().unwrap_or_default());
    [a, b, c, n1, n2].map(f64::to_bits)
}

/// The place of a shape's kind in [`KINDS`].
fn place(shape: &Shape) -> usize {
    // States with custom shapes were refused earlier.
    KINDS.iter().position(|kind| *kind == shape.tag()).unwrap_or_default()
}

/// The sizes of a run, by kind.
#[derive(Clone, Debug, Default)]
pub(super) struct Survey([Sizes; KINDS.len()]);

#[derive(Clone, Debug)]
struct Sizes {
    /// The distinct sizes, while they are few.
    distinct: BTreeSet<Key>,
    least: [f64; 3],
    most: [f64; 3],
}

impl Default for Sizes {
    fn default() -> Self {
        Sizes { distinct: BTreeSet::new(), least: [f64::INFINITY; 3], most: [0.0; 3] }
    }
}

fn most_types(kind: Tag) -> usize {
    match kind {
        Tag::Torus => MOST_RINGS,
        Tag::Superellipsoid => MOST_SUPERELLIPSOIDS,
        _ => MOST_TYPES,
    }
}

impl Survey {
    /// Records a shape.
    pub(super) fn add(&mut self, shape: &Shape) {
        let of = &mut self.0[place(shape)];
        for (i, size) in shape.code().1.into_iter().enumerate() {
            of.least[i] = of.least[i].min(size);
            of.most[i] = of.most[i].max(size);
        }
        if of.distinct.len() <= most_types(shape.tag()) {
            of.distinct.insert(key(shape));
        }
    }

    /// The types for all of them.
    pub(super) fn classes(&self) -> Classes {
        let mut first = 0;
        let kinds = std::array::from_fn(|k| {
            let kind = Kind::new(KINDS[k], first, &self.0[k]);
            first += kind.shapes.len() as u32;
            kind
        });
        Classes(kinds)
    }
}

/// The types of a file.
#[derive(Clone, Debug)]
pub(super) struct Classes([Kind; KINDS.len()]);

/// The types of one kind of shape.
#[derive(Clone, Debug)]
struct Kind {
    kind: Tag,
    /// The index of its first type in the file.
    first: u32,
    /// The shapes of its types.
    shapes: Vec<Shape>,
    /// The sizes of each type, if they are exact.
    exact: Option<Vec<Key>>,
    /// Otherwise: the smallest size, the width of a class and the number of classes along each size.
    grid: [(f64, f64, usize); 3],
}

impl Kind {
    fn new(kind: Tag, first: u32, sizes: &Sizes) -> Self {
        let most = most_types(kind);
        let grid = [(0.0, 0.0, 1); 3];
        if sizes.distinct.len() <= most {
            let keys: Vec<Key> = sizes.distinct.iter().copied().collect();
            let shape = |key: &Key| {
                let [a, b, c, n1, n2] = key.map(f64::from_bits);
                Shape::from_numbers(kind as u32, [a, b, c], Some([n1, n2]))
            };
            return Kind { kind, first, shapes: keys.iter().filter_map(shape).collect(), exact: Some(keys), grid };
        }
        let drawn = if kind == Tag::Superellipsoid { Tag::Ellipsoid } else { kind };
        let widths = [0, 1, 2].map(|i| sizes.most[i] - sizes.least[i]);
        let varying = widths.iter().filter(|width| **width > 0.0).count().max(1);
        // The largest number of classes per size whose power is within the limit.
        let along = (1..=most).rev().find(|n| n.pow(varying as u32) <= most).unwrap_or(1);
        let grid = [0, 1, 2].map(|i| {
            let count = if widths[i] > 0.0 { along } else { 1 };
            (sizes.least[i], widths[i] / count as f64, count)
        });
        let shapes = (0..grid.iter().map(|(_, _, count)| count).product()).filter_map(|class| {
            let mut rest = class;
            let middle = grid.map(|(least, width, count)| {
                let at = rest % count;
                rest /= count;
                least + width * (at as f64 + 0.5)
            });
            Shape::from_code(drawn as u32, middle).map(lengthened)
        });
        Kind { kind, first, shapes: shapes.collect(), exact: None, grid }
    }

    fn name(&self) -> &'static str {
        match self.kind {
            Tag::Superellipsoid => "superellipsoid",
            _ => self.shapes.first().map_or("", Shape::name),
        }
    }

    fn of(&self, shape: &Shape) -> u32 {
        let class = match &self.exact {
            Some(keys) => keys.partition_point(|of| *of < key(shape)),
            None => {
                let mut stride = 1;
                let mut class = 0;
                for (size, (least, width, count)) in shape.code().1.into_iter().zip(self.grid) {
                    let at = if width > 0.0 { ((size - least) / width) as usize } else { 0 };
                    class += stride * at.min(count - 1);
                    stride *= count;
                }
                class
            }
        };
        self.first + class.min(self.shapes.len().saturating_sub(1)) as u32
    }
}

/// The middle of a class of short and thick rods may be shorter than thick; it is lengthened to remain a rod.
fn lengthened(shape: Shape) -> Shape {
    match shape {
        Shape::Spherocylinder { diameter, length } => {
            Shape::Spherocylinder { diameter, length: length.max(diameter * LEAST_ROD) }
        }
        shape => shape,
    }
}

impl Classes {
    /// The type of a shape.
    pub(super) fn of(&self, shape: &Shape) -> u32 {
        self.0[place(shape)].of(shape)
    }

    /// Whether every type is exact, as far as GSD supports its shape.
    pub(super) fn exact(&self) -> bool {
        self.0.iter().all(|kind| kind.exact.is_some())
    }

    /// The number of types.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(|kind| kind.shapes.len()).sum()
    }

    /// Names of the types: that of the shape, numbered if there are several.
    pub(super) fn names(&self) -> Vec<String> {
        let names = self.0.iter().flat_map(|kind| {
            let (several, own) = (kind.shapes.len() > 1, kind.name());
            let name = move |i: usize| if several { format!("{own}_{i:03}") } else { own.to_owned() };
            (0..kind.shapes.len()).map(name)
        });
        names.collect()
    }

    /// Shapes of the types, as JSON for GSD.
    pub(super) fn shapes(&self) -> Vec<String> {
        self.0.iter().flat_map(|kind| &kind.shapes).map(|shape| definition(shape).to_string()).collect()
    }

    /// Notes for the user on the types.
    pub(super) fn notes(&self) -> Vec<String> {
        let classed = self.0.iter().filter(|kind| kind.exact.is_none() && !kind.shapes.is_empty()).map(|kind| {
            let (name, count) = (kind.name(), kind.shapes.len());
            let off = kind.grid.iter().map(|(_, width, _)| 0.5 * width).fold(0.0, f64::max);
            let drawn = if kind.kind == Tag::Superellipsoid { " as ellipsoids" } else { "" };
            format!(
                "{name}s have too many sizes for types of their own: {count} classes, up to {off:.2e} off; the exact sizes are in \
                 log/particles/size, and OVITO draws them{drawn} from log/particles/Aspherical Shape"
            )
        });
        let meshed = self.0.iter().filter(|kind| !kind.shapes.is_empty()).filter_map(|kind| match kind.kind {
            Tag::Torus => {
                let [along, around] = RING_FACES;
                Some(format!(
                    "GSD has no tori: they are meshes of {along} by {around} faces with their corners on the surface"
                ))
            }
            Tag::Superellipsoid if kind.exact.is_some() => Some(format!(
                "GSD has no superellipsoids: they are meshes of {} faces with their corners on the surface",
                6 * FACES * FACES
            )),
            _ => None,
        });
        let unfit = self.0[3].exact.is_none().then(|| "OVITO draws tori by their class, too".to_owned());
        classed.chain(meshed).chain(unfit).collect()
    }
}

/// A shape in GSD's terms: a spherocylinder is a rounded polyhedron with two corners.
fn definition(shape: &Shape) -> Value {
    if let Some(exponents) = shape.exponents() {
        let Surface { points, faces, .. } = Surface::unit(exponents).scaled(shape.code().1);
        let vertices: Vec<[f32; 3]> = points.iter().map(|point| point.as_vec3().to_array()).collect();
        return json!({"type": "Mesh", "vertices": vertices, "indices": faces});
    }
    match shape.geometry() {
        // A segment of zero length has two equal corners, which readers refuse.
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } if half > 0.0 => {
            let corners = [[0.0, 0.0, -half], [0.0, 0.0, half]];
            json!({"type": "ConvexPolyhedron", "rounding_radius": radius, "vertices": corners})
        }
        Geometry::Centreline { curve: Centreline::Point | Centreline::Segment { .. }, radius } => {
            json!({"type": "Sphere", "diameter": 2.0 * radius})
        }
        Geometry::Centreline { curve: Centreline::Circle { radius: major }, radius } => {
            let (vertices, indices) = ring(major, radius);
            json!({"type": "Mesh", "vertices": vertices, "indices": indices})
        }
        Geometry::Ellipsoid { radii } => json!({"type": "Ellipsoid", "a": radii.x, "b": radii.y, "c": radii.z}),
        // States with custom shapes were refused earlier.
        Geometry::Convex(shape) => json!({"type": "Sphere", "diameter": 2.0 * shape.bounding_radius()}),
    }
}

/// Corners and faces of a ring, with outward orientation. Corners are 32-bit floats, as in readers, and short as text.
fn ring(major: f64, minor: f64) -> (Vec<[f32; 3]>, Vec<[usize; 4]>) {
    let [along, around] = RING_FACES;
    let corner = |i: usize, j: usize| {
        let ((sin, cos), (up, out)) =
            ((TAU * i as f64 / along as f64).sin_cos(), (TAU * j as f64 / around as f64).sin_cos());
        [cos * (major + minor * out), sin * (major + minor * out), minor * up].map(|x| x as f32)
    };
    let number = |i: usize, j: usize| i % along * around + j % around;
    let each = || (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    let faces = each().map(|(i, j)| [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]);
    (each().map(|(i, j)| corner(i, j)).collect(), faces.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn rods(count: usize) -> Vec<Shape> {
        let length = |i: usize| 1.0 + i as f64 / (count - 1) as f64;
        (0..count).map(|i| Shape::Spherocylinder { diameter: 0.5, length: length(i) }).collect()
    }

    fn classes(shapes: &[Shape]) -> Classes {
        let mut survey = Survey::default();
        shapes.iter().for_each(|shape| survey.add(shape));
        survey.classes()
    }

    #[test]
    fn few_sizes_are_exact_types() {
        let mut shapes = rods(MOST_TYPES);
        shapes.push(Shape::Sphere { radius: 2.0 });
        shapes.push(Shape::Torus { major_radius: 2.0, minor_radius: 0.5 });
        let classes = classes(&shapes);
        assert!(classes.exact());
        assert_eq!(classes.len(), MOST_TYPES + 2);
        let (names, drawn) = (classes.names(), classes.shapes());
        for shape in &shapes {
            let of = classes.of(shape) as usize;
            assert_eq!(drawn[of], definition(shape).to_string());
            assert!(names[of].starts_with(shape.name()));
        }
        assert_eq!((names[0].as_str(), names[1].as_str()), ("sphere", "spherocylinder_000"));
        assert_eq!(classes.notes().len(), 1);
    }

    #[test]
    fn many_sizes_are_classed_to_half_a_width() {
        let shapes = rods(10_001);
        let classes = classes(&shapes);
        assert!(!classes.exact());
        assert_eq!(classes.len(), MOST_TYPES);
        let width = 1.0 / MOST_TYPES as f64;
        for shape in &shapes {
            let drawn = classes.0[1].shapes[classes.of(shape) as usize];
            let [true_length, length] = [shape, &drawn].map(|shape| shape.rod_length().unwrap());
            assert!((true_length - length).abs() <= 0.5 * width + 1e-12);
            assert_eq!(drawn.thickness(), 0.5);
        }
        assert!(classes.notes()[0].contains("256 classes, up to 1.95e-3 off"), "{:?}", classes.notes());
    }

    #[test]
    fn ellipsoids_that_vary_in_every_size_stay_within_the_bound() {
        let size = |k: usize, n: usize| 1.0 + (k * n % 997) as f64 / 997.0;
        let shapes: Vec<_> =
            (0..500).map(|k| Shape::Ellipsoid { radii: [size(k, 1), size(k, 31), size(k, 57)] }).collect();
        let classes = classes(&shapes);
        assert_eq!(classes.len(), 216);
        for shape in &shapes {
            let drawn = classes.0[2].shapes[classes.of(shape) as usize];
            let off = shape.code().1.into_iter().zip(drawn.code().1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off <= 0.5 / 6.0 + 1e-12, "{off}");
        }
    }

    #[test]
    fn a_ring_is_closed_and_faces_outwards() {
        let (corners, faces) = ring(2.0, 0.5);
        let at = |i: usize| Vec3::from_array(corners[i]);
        let mut volume = 0.0_f64;
        for [a, b, c, d] in faces.iter().copied() {
            for [p, q, r] in [[a, b, c], [a, c, d]].map(|face| face.map(at)) {
                volume += f64::from(p.cross(q).dot(r)) / 6.0;
            }
        }
        let exact = Shape::Torus { major_radius: 2.0, minor_radius: 0.5 }.volume();
        assert!((0.98..1.0).contains(&(volume / exact)), "{volume} of {exact}");
    }
}
