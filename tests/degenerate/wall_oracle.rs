//! What a separation from a surface must be: the least height over the body's surface, by samples and a search; the
//! height of a point needs no direction.

use glam::{DMat3, DVec3};
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::Surface;
use relcp::separation::{Placed, Separation};
use relcp::shape::Shape;

use super::oracle::{Curve, Errors, climbed, least, support};
use super::placements::turn;

/// How far inside a point is, by definition.
fn height(surface: &Surface, p: DVec3) -> f64 {
    match *surface {
        Surface::Plane { point, normal } => (p - point).dot(normal),
        Surface::Sphere { centre, radius } => radius - p.distance(centre),
        Surface::Cylinder { centre, axis, radius } => radius - (p - centre).cross(axis).length(),
    }
}

/// The point of a body without a centreline that is farthest along `n`, from its centre.
fn point(body: &Placed, n: DVec3) -> DVec3 {
    let axes = DMat3::from_quat(body.orientation);
    let local = axes.transpose() * n;
    match body.shape {
        Shape::Ellipsoid { radii } => {
            let radii = DVec3::from_array(radii);
            axes * (radii * radii * local / (radii * local).length())
        }
        Shape::Convex(shape) => axes * shape.point(local),
        Shape::Superellipsoid(of) => {
            let (radii, [m1, m2]) = (DVec3::from_array(of.radii()), of.exponents().map(|n| n / (n - 1.0)));
            let v = (radii * local).abs();
            let across = (v.x.powf(m2) + v.y.powf(m2)).powf(1.0 / m2);
            let whole = (across.powf(m1) + v.z.powf(m1)).powf(1.0 / m1);
            let part = |x: f64| if across > 0.0 { (x / across).powf(m2 - 1.0) } else { 0.0 };
            let out = (across / whole).powf(m1 - 1.0);
            axes * (radii * DVec3::new(out * part(v.x), out * part(v.y), (v.z / whole).powf(m1 - 1.0)) * local.signum())
        }
        other => panic!("{other:?} has a centreline"),
    }
}

/// The least height of a body without a centreline. From many starts: the direction in which the point lies is the next
/// direction, which never leads back up, as the height falls with a convex function; then steps to all sides.
fn least_of_convex(surface: &Surface, body: &Placed, random: &mut ChaCha8Rng) -> f64 {
    let (centre, axis) = match *surface {
        Surface::Plane { normal, point: at } => return (body.position - at).dot(normal) - support(body, -normal),
        Surface::Sphere { centre, .. } => (centre, DVec3::ZERO),
        Surface::Cylinder { centre, axis, .. } => (centre, axis),
    };
    let outwards = |p: DVec3| {
        let from = p - centre;
        let across = from - axis * axis.dot(from);
        (across - axis * axis.dot(across)).try_normalize()
    };
    let axes = DMat3::from_quat(body.orientation);
    let starts = (0..30).map(|_| turn(random) * DVec3::Z).collect::<Vec<_>>();
    let along = [axes.x_axis, axes.y_axis, axes.z_axis].into_iter().flat_map(|axis| [axis, -axis]);
    let (mut best, mut at) = (f64::INFINITY, DVec3::X);
    for start in starts.into_iter().chain(along) {
        let mut n = start;
        for _ in 0..100 {
            let p = body.position + point(body, n);
            let here = height(surface, p);
            if here < best {
                (best, at) = (here, n);
            }
            let Some(next) = outwards(p) else { break };
            if (next - n).length() < 1e-13 {
                break;
            }
            n = next;
        }
    }
    let depth = |n: DVec3| -height(surface, body.position + point(body, n));
    -climbed(&depth, -best, at, 4000)
}

/// The errors of a found separation of a body from a surface.
pub fn wall_errors(body: &Placed, surface: &Surface, found: &Separation, random: &mut ChaCha8Rng) -> Errors {
    let size = wall_size(body, surface);
    let right = match Curve::of(body) {
        Some((curve, radius)) => least(|t| height(surface, body.position + curve.point(t))) - radius,
        None => least_of_convex(surface, body, random),
    };
    // What is found below is proved by the lever, whose height is that of a point of the body.
    let separation = (found.separation - right).max(0.0) / size;
    Errors { separation, ..Errors::default() }.max(sound_at_wall(body, surface, found))
}

/// The size that errors are fractions of: the body's, and how far its point is from the middle of the surface.
pub fn wall_size(body: &Placed, surface: &Surface) -> f64 {
    let away = match *surface {
        Surface::Plane { point, .. } => body.position.distance(point),
        Surface::Sphere { centre, radius } | Surface::Cylinder { centre, radius, .. } => {
            body.position.distance(centre) + radius
        }
    };
    body.shape.bounding_radius() + away
}

/// The errors of normal and lever, which hold of every place.
pub fn sound_at_wall(body: &Placed, surface: &Surface, found: &Separation) -> Errors {
    let size = wall_size(body, surface);
    let n = found.normal;
    let at = body.position + found.lever_a;
    let across = match *surface {
        Surface::Plane { normal, .. } => (n + normal).length(),
        Surface::Sphere { .. } => 0.0,
        Surface::Cylinder { axis, .. } => n.dot(axis).abs(),
    };
    let (mut on_body, reached) = match Curve::of(body) {
        Some((curve, radius)) => (curve.distance(found.lever_a - n * radius), radius),
        None => (0.0, 0.0),
    };
    if reached == 0.0 {
        on_body = (found.lever_a.dot(n) - support(body, n)).abs();
    }
    // The height at the lever is the separation, and falls by as much as one goes along the normal.
    let told = (height(surface, at) - found.separation).abs();
    let step = 1e-3 * size;
    let falls = (height(surface, at + n * step) - found.separation + step).abs();
    Errors {
        separation: 0.0,
        normal: (n.length() - 1.0).abs().max(across),
        lever: on_body.max(told).max(falls).max(found.lever_b.length()) / size,
    }
}
