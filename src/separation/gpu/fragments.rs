//! The fragments of a kernel that computes a pair of families.

use super::{PairFamilies, add_bodies_to, add_tolerances_to};
use crate::gpu::{Fragment, Precision, Source, fragment};

/// A gain of the climb that counts, in roundings of the sizes.
const GAIN_IN_ROUNDINGS: f64 = 0.5;

impl PairFamilies {
    /// Adds `separate` and `is_of_families` for this pair of families; `planar` for bodies that cannot leave the plane.
    #[must_use]
    pub fn add_to(self, source: Source, planar: bool) -> Source {
        let mut source = add_tolerances_to(add_bodies_to(source));
        if self == PairFamilies::Circles {
            source = add_minima_of_circles_to(source.include(fragment!("separation/nearest.wgsl")));
        }
        if self == PairFamilies::CircleEllipsoid {
            let circles = add_minima_of_circles_to(source.include(fragment!("separation/nearest.wgsl")));
            source = add_minima_of_circle_and_ellipsoid_to(circles);
        }
        if self.has_superellipsoids() {
            source = add_climb_to(source);
        }
        let either_order = [fragment!("separation/entry.wgsl")];
        for fragment in self.fragments().iter().chain(&either_order).chain(self.entry(planar)) {
            source = source.include(*fragment);
        }
        source.text(&self.test_text())
    }

    /// The fragments that compute it in space, for a pair in its fixed order.
    fn fragments(self) -> &'static [Fragment] {
        match self {
            PairFamilies::Segments => &[
                fragment!("separation/nearest.wgsl"),
                fragment!("separation/order.wgsl"),
                fragment!("separation/segments.wgsl"),
            ],
            PairFamilies::CircleSegment => &[
                fragment!("separation/nearest.wgsl"),
                fragment!("separation/ring.wgsl"),
                fragment!("separation/circle_segment_minima.wgsl"),
                fragment!("separation/circle_segment.wgsl"),
            ],
            PairFamilies::CircleEllipsoid => &[fragment!("separation/circle_ellipsoid.wgsl")],
            PairFamilies::SegmentEllipsoid => &[
                fragment!("separation/nearest.wgsl"),
                fragment!("separation/basis.wgsl"),
                fragment!("separation/support.wgsl"),
                fragment!("separation/peak.wgsl"),
                fragment!("separation/point_ellipsoid.wgsl"),
                fragment!("separation/segment_ellipsoid.wgsl"),
            ],
            PairFamilies::Circles => &[fragment!("separation/order.wgsl"), fragment!("separation/circles.wgsl")],
            PairFamilies::Ellipsoids => &[
                fragment!("separation/nearest.wgsl"),
                fragment!("separation/order.wgsl"),
                fragment!("separation/basis.wgsl"),
                fragment!("separation/support.wgsl"),
                fragment!("separation/peak.wgsl"),
                fragment!("separation/ellipsoids.wgsl"),
            ],
            PairFamilies::SegmentSuperellipsoid => &[fragment!("separation/segment_convex.wgsl")],
            PairFamilies::EllipsoidSuperellipsoid | PairFamilies::Superellipsoids => {
                &[fragment!("separation/order.wgsl"), fragment!("separation/convex.wgsl")]
            }
        }
    }

    /// The fragments with the function `separate`.
    fn entry(self, planar: bool) -> &'static [Fragment] {
        match self {
            // Rings are handled as in space.
            _ if !planar => &[fragment!("separation/entry_space.wgsl")],
            PairFamilies::CircleSegment | PairFamilies::CircleEllipsoid | PairFamilies::Circles => {
                &[fragment!("separation/entry_space.wgsl")]
            }
            PairFamilies::Segments => &[
                fragment!("separation/planar.wgsl"),
                fragment!("separation/planar_normal.wgsl"),
                fragment!("separation/planar_segments.wgsl"),
                fragment!("separation/entry_planar.wgsl"),
            ],
            // No scene has these, see `unsupported`.
            _ if self.has_superellipsoids() => &[fragment!("separation/entry_space.wgsl")],
            _ => &[
                fragment!("separation/planar.wgsl"),
                fragment!("separation/planar_normal.wgsl"),
                fragment!("separation/planar_outlines.wgsl"),
                fragment!("separation/entry_planar.wgsl"),
            ],
        }
    }
}

/// Adds the climb of bodies that are flat in places, to a source with tolerances and superellipsoids.
pub(crate) fn add_climb_to(source: Source) -> Source {
    // A gain, as a fraction of the sizes, that counts.
    let gain = GAIN_IN_ROUNDINGS * source.precision().epsilon();
    let fragments =
        [fragment!("separation/nearest.wgsl"), fragment!("separation/basis.wgsl"), fragment!("separation/flat.wgsl")];
    fragments.into_iter().fold(source.real("GAIN", gain), Source::include)
}

/// The largest number of halvings of an interval in the search along a ring: a minimum hidden in the last interval has
/// the width of the root of a rounding, and is nearer by at most its square.
fn halvings(precision: Precision) -> u32 {
    (-0.5 * precision.epsilon().log2()).ceil() as u32
}

/// Adds the search for the minima of the distance between two circles, to a source with bodies and `nearest.wgsl`.
pub(crate) fn add_minima_of_circles_to(source: Source) -> Source {
    let halvings = halvings(source.precision());
    let source = source.integer("RING_HALVINGS", halvings).include(fragment!("separation/ring.wgsl"));
    source.include(fragment!("separation/circle_minima.wgsl"))
}

/// Adds the search for the minima of the distance between a circle and an ellipsoid, to a source with that for circles.
pub(crate) fn add_minima_of_circle_and_ellipsoid_to(source: Source) -> Source {
    let fragments = [
        fragment!("separation/basis.wgsl"),
        fragment!("separation/support.wgsl"),
        fragment!("separation/point_ellipsoid.wgsl"),
        fragment!("separation/circle_ellipsoid_minima.wgsl"),
    ];
    fragments.into_iter().fold(source, Source::include)
}
