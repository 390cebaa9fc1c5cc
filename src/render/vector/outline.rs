//! Outlines of bodies seen along z: exact up to cubic curves in place of arcs, with an error below 3e-4 of a radius.

use crate::bodies::Bodies;
use crate::page::{Path, PathBuilder};
use crate::shape::{Centreline, Geometry};
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The number of corners of an outline without a closed form.
const CORNERS: usize = 96;
/// The longest arc that is drawn as one cubic curve.
const ARC: f64 = 0.5 * PI;
/// A ring is seen edge-on if its axis is this near to the plane, and from above if it is this near to z.
const ALIGNED: f64 = 1e-9;

/// The outline of body `i`; `None` if it is not finite or has no extent.
pub(super) fn of(bodies: &Bodies, i: usize, on_page: &dyn Fn(DVec3) -> DVec2) -> Option<Path> {
    let (centre, turn) = (bodies.position[i], bodies.orientation[i].normalize());
    if !centre.is_finite() || !turn.is_finite() {
        return None;
    }
    let mut pen = Pen { builder: PathBuilder::new(), on_page };
    match bodies.shape[i].geometry() {
        Geometry::Centreline { curve: Centreline::Point, radius } => {
            pen.ellipse(centre, DVec3::X * radius, DVec3::Y * radius)
        }
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
            pen.capsule(centre, (turn * DVec3::Z * half).with_z(0.0), radius);
        }
        Geometry::Centreline { curve: Centreline::Circle { radius: major }, radius } => {
            pen.ring(centre, turn, major, radius)
        }
        Geometry::Ellipsoid { radii } => {
            let [major, minor] = shadow(turn, radii);
            pen.ellipse(centre, major, minor);
        }
        Geometry::Convex(convex) => {
            let corner = |k: usize| {
                let along = DVec2::from_angle(k as f64 / CORNERS as f64 * TAU).extend(0.0);
                centre + turn * convex.point(turn.inverse() * along)
            };
            pen.polygon((0..CORNERS).map(corner));
        }
    }
    pen.builder.finish()
}

/// The semi-axes of an ellipsoid's shadow in the plane: those of the upper left block of `R diag(radii)^2 R^T`.
fn shadow(turn: DQuat, radii: DVec3) -> [DVec3; 2] {
    let columns =
        [(DVec3::X, radii.x), (DVec3::Y, radii.y), (DVec3::Z, radii.z)].map(|(axis, radius)| turn * axis * radius);
    let sum = |of: fn(&DVec3) -> f64| columns.iter().map(of).sum::<f64>();
    let (xx, xy, yy) = (sum(|c| c.x * c.x), sum(|c| c.x * c.y), sum(|c| c.y * c.y));
    let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
    let (long, short) = ((middle + half).sqrt(), (middle - half).max(0.0).sqrt());
    [(along * long).extend(0.0), (along.perp() * short).extend(0.0)]
}

struct Pen<'a> {
    builder: PathBuilder,
    on_page: &'a dyn Fn(DVec3) -> DVec2,
}

impl Pen<'_> {
    fn move_to(&mut self, point: DVec3) {
        let point = (self.on_page)(point).as_vec2();
        self.builder.move_to(point.x, point.y);
    }

    fn line_to(&mut self, point: DVec3) {
        let point = (self.on_page)(point).as_vec2();
        self.builder.line_to(point.x, point.y);
    }

    /// The arc `centre + u cos t + v sin t` for `t` from `from` to `to`, starting at the pen's position.
    fn arc(&mut self, centre: DVec3, [u, v]: [DVec3; 2], from: f64, to: f64) {
        let parts = ((to - from).abs() / ARC).ceil().max(1.0);
        let step = (to - from) / parts;
        // The handles of a cubic curve that meets the arc in its middle.
        let handle = 4.0 / 3.0 * (0.25 * step).tan();
        for part in 0..parts as usize {
            let (start, end) = (from + step * part as f64, from + step * (part + 1) as f64);
            let at = |t: f64| centre + u * t.cos() + v * t.sin();
            let along = |t: f64| v * t.cos() - u * t.sin();
            let [a, b, p] = [at(start) + handle * along(start), at(end) - handle * along(end), at(end)]
                .map(|point| (self.on_page)(point).as_vec2());
            self.builder.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y);
        }
    }

    fn ellipse(&mut self, centre: DVec3, u: DVec3, v: DVec3) {
        self.move_to(centre + u);
        self.arc(centre, [u, v], 0.0, TAU);
        self.builder.close();
    }

    /// All points within `radius` of the segment from `-half` to `half`.
    fn capsule(&mut self, centre: DVec3, half: DVec3, radius: f64) {
        let u = half.normalize_or(DVec3::X) * radius;
        let v = DVec3::Z.cross(u);
        self.move_to(centre + half - v);
        self.arc(centre + half, [u, v], -0.5 * PI, 0.5 * PI);
        self.line_to(centre - half + v);
        self.arc(centre - half, [u, v], 0.5 * PI, 1.5 * PI);
        self.builder.close();
    }

    /// All points within `radius` of the shadow of a circle.
    fn ring(&mut self, centre: DVec3, turn: DQuat, major: f64, radius: f64) {
        let axis = turn * DVec3::Z;
        let flat = axis.truncate().length();
        if flat < ALIGNED {
            let outer = major + radius;
            self.ellipse(centre, DVec3::X * outer, DVec3::Y * outer);
            // In the opposite direction, so that the hole is not filled.
            let inner = major - radius;
            self.ellipse(centre, DVec3::X * inner, DVec3::NEG_Y * inner);
            return;
        }
        let long = DVec3::Z.cross(axis).normalize_or(DVec3::X) * major;
        if axis.z.abs() < ALIGNED {
            return self.capsule(centre, long, radius);
        }
        // The offset curve of an ellipse; inwards it intersects itself if the ellipse is narrow, and then no hole is
        // visible.
        let short = DVec3::Z.cross(long) * axis.z;
        let offset = |side: f64| {
            move |k: usize| {
                let t = side * k as f64 / CORNERS as f64 * TAU;
                let normal =
                    (long * (t.cos() / long.length_squared()) + short * (t.sin() / short.length_squared())).normalize();
                centre + long * t.cos() + short * t.sin() + side * radius * normal
            }
        };
        self.polygon((0..CORNERS).map(offset(1.0)));
        // The least radius of curvature of the ellipse.
        if short.length_squared() / long.length() > radius {
            self.polygon((0..CORNERS).map(offset(-1.0)));
        }
    }

    fn polygon(&mut self, mut corners: impl Iterator<Item = DVec3>) {
        if let Some(first) = corners.next() {
            self.move_to(first);
        }
        corners.for_each(|corner| self.line_to(corner));
        self.builder.close();
    }
}
