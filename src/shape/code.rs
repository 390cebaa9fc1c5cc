//! Shapes as numbers: a tag and up to three sizes, for arrays in files and for kernels.

use super::{Shape, Superellipsoid};

macro_rules! tags {
    ($($(#[$doc:meta])* $Kind:ident = $number:literal, $constant:expr;)*) => {
        /// The kind of a shape. Its number stands in files, so that it never changes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u32)]
        pub enum Tag {
            $($(#[$doc])* $Kind = $number,)*
        }

        impl Tag {
            /// All kinds.
            pub const ALL: &'static [Tag] = &[$(Tag::$Kind,)*];

            /// The name of its number in kernels; `None` for a kind that only the CPU computes with.
            #[cfg(feature = "gpu")]
            pub fn constant(self) -> Option<&'static str> {
                match self {
                    $(Tag::$Kind => $constant,)*
                }
            }
        }
    };
}

tags! {
    /// [`Shape::Sphere`].
    Sphere = 0, Some("SPHERE");
    /// [`Shape::Spherocylinder`].
    Spherocylinder = 1, Some("SPHEROCYLINDER");
    /// [`Shape::Ellipsoid`].
    Ellipsoid = 2, Some("ELLIPSOID");
    /// [`Shape::Torus`].
    Torus = 3, Some("TORUS");
    /// [`Shape::Convex`]: one number for all custom shapes, which no shape is made from.
    Custom = 4, None;
    /// [`Shape::Superellipsoid`]. Its exponents are beside its sizes, see [`Shape::exponents`].
    Superellipsoid = 5, None;
}

impl Tag {
    /// The name in capitals of a kind that files can hold.
    #[cfg(feature = "python")]
    pub fn upper_name(self) -> Option<&'static str> {
        if self == Tag::Superellipsoid { Some("SUPERELLIPSOID") } else { self.constant() }
    }

    /// The kind of this number.
    pub fn of_number(number: u32) -> Option<Tag> {
        Tag::ALL.iter().copied().find(|tag| *tag as u32 == number)
    }
}

impl Shape {
    /// The shape's kind.
    pub fn tag(&self) -> Tag {
        match self {
            Shape::Sphere { .. } => Tag::Sphere,
            Shape::Spherocylinder { .. } => Tag::Spherocylinder,
            Shape::Ellipsoid { .. } => Tag::Ellipsoid,
            Shape::Torus { .. } => Tag::Torus,
            Shape::Superellipsoid(_) => Tag::Superellipsoid,
            Shape::Convex(_) => Tag::Custom,
        }
    }

    /// The shape's tag and sizes, in the order of its fields; what a shape does not need is zero. A custom shape and
    /// a superellipsoid are more than that.
    pub fn code(&self) -> (u32, [f64; 3]) {
        let sizes = match *self {
            Shape::Sphere { radius } => [radius, 0.0, 0.0],
            Shape::Spherocylinder { diameter, length } => [diameter, length, 0.0],
            Shape::Ellipsoid { radii } => radii,
            Shape::Torus { major_radius, minor_radius } => [major_radius, minor_radius, 0.0],
            Shape::Superellipsoid(superellipsoid) => superellipsoid.radii(),
            Shape::Convex(convex) => [convex.bounding_radius(), convex.thickness(), convex.volume()],
        };
        (self.tag() as u32, sizes)
    }

    /// The shape of a [tag and sizes](Shape::code); `None` where no shape has them: an unknown or a custom tag, that of
    /// a superellipsoid, or a size that is not finite and positive.
    ///
    /// ```
    /// use relcp::shape::Shape;
    /// let rod = Shape::Spherocylinder { diameter: 1.0, length: 3.0 };
    /// let (tag, sizes) = rod.code();
    /// assert_eq!(Shape::from_code(tag, sizes), Some(rod));
    /// assert_eq!(Shape::from_code(tag, [1.0, f64::NAN, 0.0]), None);
    /// ```
    pub fn from_code(tag: u32, sizes: [f64; 3]) -> Option<Shape> {
        let (shape, used) = Shape::of_code(tag, sizes)?;
        sizes[..used].iter().all(|size| size.is_finite() && *size > 0.0).then_some(shape)
    }

    /// The exponents of a superellipsoid, the only numbers of a shape beside its sizes.
    pub fn exponents(&self) -> Option<[f64; 2]> {
        if let Shape::Superellipsoid(of) = self { Some(of.exponents()) } else { None }
    }

    /// As [`Shape::from_code`], with the exponents of a superellipsoid.
    pub fn from_numbers(tag: u32, sizes: [f64; 3], exponents: Option<[f64; 2]>) -> Option<Shape> {
        match (Tag::of_number(tag)?, exponents) {
            (Tag::Superellipsoid, Some(exponents)) => {
                Some(Shape::Superellipsoid(Superellipsoid::new(sizes, exponents))).filter(|of| of.validate().is_ok())
            }
            _ => Shape::from_code(tag, sizes),
        }
    }

    /// As [`Shape::from_code`], of sizes that a shape had, whatever they are; and how many of them it needs.
    pub(crate) fn of_code(tag: u32, sizes: [f64; 3]) -> Option<(Shape, usize)> {
        let [x, y, _] = sizes;
        Some(match Tag::of_number(tag)? {
            Tag::Sphere => (Shape::Sphere { radius: x }, 1),
            Tag::Spherocylinder => (Shape::Spherocylinder { diameter: x, length: y }, 2),
            Tag::Ellipsoid => (Shape::Ellipsoid { radii: sizes }, 3),
            Tag::Torus => (Shape::Torus { major_radius: x, minor_radius: y }, 2),
            Tag::Custom | Tag::Superellipsoid => return None,
        })
    }
}
