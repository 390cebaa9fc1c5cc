//! The camera: orthographic, so that lengths have the same scale everywhere in a picture.

use super::intersect::reach;
use super::{Side, View};
use crate::bodies::Bodies;
use crate::shape::Geometry;
use glam::{DVec2, DVec3};

/// The margin on each side, as a part of a picture's width and height.
const MARGIN: f64 = 0.04;
/// Bodies farther out or larger than this are not drawn: their squares could overflow.
const DRAWABLE: f64 = 1e100;
/// The camera's azimuth in a spatial scene, about z from the x axis.
const AZIMUTH_DEGREES: f64 = -58.0;
/// The camera's elevation in a spatial scene, above the x-y plane.
const ELEVATION_DEGREES: f64 = 24.0;

/// A parallel projection onto a picture.
///
/// Use one camera for all pictures of a movie, because [`Camera::fit`] follows the bodies.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::{bodies::{Bodies, NO_GROUP}, render::{Camera, View}, separation::Placed, shape::Shape};
/// let mut bodies = Bodies::default();
/// for x in [-10.0, 10.0] {
///     let placed = Placed { shape: Shape::Sphere { radius: 1.0 }, position: DVec3::X * x, orientation: DQuat::IDENTITY };
///     bodies.push(placed, NO_GROUP);
/// }
/// let camera = Camera::fit(&bodies, &View { width: 220, height: 100, planar: true, ..View::default() });
/// assert!(camera.pixels_per_length() < 10.0 && camera.pixels_per_length() > 9.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point at the centre of the picture.
    pub(super) centre: DVec3,
    /// Unit vector to the right of the picture.
    pub(super) right: DVec3,
    /// Unit vector to the top of the picture.
    pub(super) up: DVec3,
    /// Unit vector from the scene to the viewer.
    pub(super) toward: DVec3,
    /// Pixels per length.
    scale: f64,
}

impl Camera {
    /// The camera that shows all bodies of a scene as large as possible in the view.
    ///
    /// A planar scene is seen along z with x to the right and y up, a spatial one from the front and above with z up.
    /// Bodies with a coordinate that is not finite or exceeds 1e100 are ignored; without bodies, the picture shows two
    /// lengths around the origin.
    pub fn fit(bodies: &Bodies, view: &View) -> Camera {
        Camera::along(axes(view.planar), [view.width, view.height], bodies)
    }

    /// As [`Camera::fit`], with other axes: right, up and toward.
    pub(super) fn along(axes: [DVec3; 3], pixels: [u32; 2], bodies: &Bodies) -> Camera {
        Extent::of(axes, bodies).fit(axes, pixels)
    }

    /// The number of pixels per length.
    pub fn pixels_per_length(&self) -> f64 {
        self.scale
    }

    /// A vector's components along right, up and toward.
    pub(super) fn to_view(self, vector: DVec3) -> DVec3 {
        DVec3::new(vector.dot(self.right), vector.dot(self.up), vector.dot(self.toward))
    }

    /// The vector with these components along right, up and toward.
    pub(super) fn to_space(self, parts: DVec3) -> DVec3 {
        self.right * parts.x + self.up * parts.y + self.toward * parts.z
    }

    /// The position and the extent of body `i` along right, up and toward, relative to the camera's centre; `None` for
    /// a body that cannot be drawn.
    pub(super) fn bounds(&self, bodies: &Bodies, i: usize) -> Option<Bounds> {
        let orientation = bodies.orientation[i];
        if !orientation.is_finite() || orientation.length_squared() < 0.5 {
            return None;
        }
        let to_body = orientation.normalize().inverse();
        let axes = [self.right, self.up, self.toward].map(|axis| to_body * axis);
        let geometry = bodies.shape[i].geometry();
        let reach = DVec3::from_array(axes.map(|axis| reach(&geometry, axis)));
        let offset = bodies.position[i] - self.centre;
        let centre = self.to_view(offset);
        let drawable = bodies.position[i].abs().max_element() < DRAWABLE
            && reach.max_element() < DRAWABLE
            && reach.min_element() > 0.0
            && centre.is_finite();
        drawable.then_some(Bounds { geometry, axes, centre, reach })
    }
}

/// A body in the camera's axes, in lengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub geometry: Geometry,
    /// The camera's right, up and toward in body axes.
    pub axes: [DVec3; 3],
    /// Centre along right, up and toward.
    pub centre: DVec3,
    /// Half the extent along right, up and toward.
    pub reach: DVec3,
}

/// The extent of bodies along a camera's right, up and toward, from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    /// The extent of no body.
    pub const NONE: Extent = Extent { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// The extent of all bodies that can be drawn.
    pub fn of([right, up, toward]: [DVec3; 3], bodies: &Bodies) -> Extent {
        let camera = Camera { centre: DVec3::ZERO, right, up, toward, scale: 1.0 };
        let mut all = Extent::NONE;
        for bounds in (0..bodies.len()).filter_map(|i| camera.bounds(bodies, i)) {
            all = all.with(Extent { low: bounds.centre - bounds.reach, high: bounds.centre + bounds.reach });
        }
        all
    }

    /// The union of both.
    pub fn with(self, other: Extent) -> Extent {
        Extent { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The camera with these axes that shows all of the extent in a picture of `pixels`.
    pub fn fit(self, [right, up, toward]: [DVec3; 3], pixels: [u32; 2]) -> Camera {
        let (mut low, mut high) = (self.low, self.high);
        if low.x > high.x {
            (low, high) = (DVec3::NEG_ONE, DVec3::ONE);
        }
        let pixels = DVec2::from_array(pixels.map(|side| f64::from(side.max(1)) * (1.0 - 2.0 * MARGIN)));
        let scale = (pixels / (high - low).truncate()).min_element();
        let camera = Camera { centre: DVec3::ZERO, right, up, toward, scale };
        Camera { centre: camera.to_space((low + high) / 2.0), ..camera }
    }
}

/// The axes of the camera that looks from a side.
pub(super) fn axes_from(side: Side) -> [DVec3; 3] {
    match side {
        Side::Top => DVec3::AXES,
        Side::Front => [DVec3::X, DVec3::Z, DVec3::NEG_Y],
        Side::Right => [DVec3::Y, DVec3::Z, DVec3::X],
        Side::Oblique => axes(false),
    }
}

fn axes(planar: bool) -> [DVec3; 3] {
    if planar {
        return DVec3::AXES;
    }
    let (azimuth, elevation) = (AZIMUTH_DEGREES.to_radians(), ELEVATION_DEGREES.to_radians());
    let toward =
        DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()).normalize();
    let right = DVec3::Z.cross(toward).normalize();
    [right, toward.cross(right), toward]
}
