//! The camera: orthographic, so that a length is the same everywhere in a picture.

use super::View;
use super::intersect::reach;
use crate::bodies::Bodies;
use crate::shape::Geometry;
use glam::{DVec2, DVec3};

/// Part of a picture's width and height that stays free on each side.
const MARGIN: f64 = 0.04;
/// Bodies farther out or larger than this are not drawn: their squares are not numbers that can be reckoned with.
const DRAWABLE: f64 = 1e100;
/// Where a spatial scene is seen from: turned about z, from the x axis.
const AZIMUTH_DEGREES: f64 = -58.0;
/// Where a spatial scene is seen from: above the x-y plane.
const ELEVATION_DEGREES: f64 = 24.0;

/// A parallel projection onto a picture.
///
/// Keep one camera for all pictures of a movie: [`Camera::fit`] follows the bodies.
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
    /// What stands in the middle of the picture.
    pub(super) centre: DVec3,
    /// Unit vector to the right of the picture.
    pub(super) right: DVec3,
    /// Unit vector to the top of the picture.
    pub(super) up: DVec3,
    /// Unit vector from the scene to the viewer.
    pub(super) toward: DVec3,
    /// Pixels to a length of one.
    scale: f64,
}

impl Camera {
    /// The camera that shows all bodies of a scene as large as they fit into the view.
    ///
    /// A planar scene is seen along z with x to the right and y up, a spatial one from the front and above with z up.
    /// Bodies with a coordinate that is not finite (or beyond 1e100) are not drawn and do not count; without a body,
    /// the picture shows two lengths around the origin.
    pub fn fit(bodies: &Bodies, view: &View) -> Camera {
        Camera::along(axes(view.planar), [view.width, view.height], bodies)
    }

    /// As [`Camera::fit`], along other axes: right, up and toward.
    pub(super) fn along([right, up, toward]: [DVec3; 3], pixels: [u32; 2], bodies: &Bodies) -> Camera {
        let camera = Camera { centre: DVec3::ZERO, right, up, toward, scale: 1.0 };
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..bodies.len() {
            if let Some(bounds) = camera.bounds(bodies, i) {
                low = low.min(bounds.centre - bounds.reach);
                high = high.max(bounds.centre + bounds.reach);
            }
        }
        if low.x > high.x {
            (low, high) = (DVec3::NEG_ONE, DVec3::ONE);
        }
        let pixels = DVec2::from_array(pixels.map(|side| f64::from(side.max(1)) * (1.0 - 2.0 * MARGIN)));
        let scale = (pixels / (high - low).truncate()).min_element();
        let middle = (low + high) / 2.0;
        Camera { centre: camera.to_space(middle), scale, ..camera }
    }

    /// How many pixels a length of one takes.
    pub fn pixels_per_length(&self) -> f64 {
        self.scale
    }

    /// A vector's parts along right, up and toward.
    pub(super) fn to_view(self, vector: DVec3) -> DVec3 {
        DVec3::new(vector.dot(self.right), vector.dot(self.up), vector.dot(self.toward))
    }

    /// The vector with these parts along right, up and toward.
    pub(super) fn to_space(self, parts: DVec3) -> DVec3 {
        self.right * parts.x + self.up * parts.y + self.toward * parts.z
    }

    /// Where body `i` is and how far it reaches along right, up and toward, relative to the camera's centre;
    /// `None` for a body that cannot be drawn.
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

/// A body as the camera sees it, in lengths.
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
