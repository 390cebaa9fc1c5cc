//! The kinds of shapes as numbers: one numbering for arrays in files and for kernels.

use super::Shape;

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
}

impl Tag {
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
            Shape::Convex(_) => Tag::Custom,
        }
    }
}
