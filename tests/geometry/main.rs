//! Geometry: which bodies are near each other, how far apart they and walls are, and what shapes are.
#![allow(clippy::unwrap_used)]

mod broad_phase;
#[path = "../common/directions.rs"]
mod directions;
#[path = "../common/reference_pairs.rs"]
mod reference_pairs;
mod separation;
mod shapes;
mod walls;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::shape::Shape;

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

/// A random shape of a kind, its sizes within a factor of `aspect`.
fn random_shape(kind: &str, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        "sphere" => Shape::Sphere { radius: ratio() },
        "spherocylinder" => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        "ellipsoid" => Shape::Ellipsoid { radii: [ratio(), 1.0, ratio()] },
        _ => Shape::Torus { major_radius: 1.0 + ratio(), minor_radius: 0.5 },
    }
}
