//! The shapes of a drawn scene: kinds that may form pairs, sizes of about one length, and extreme sizes where noted.

use crate::hard::start::{Random, ellipsoid, ring, rod, sphere};
use glam::DQuat;
use relcp::shape::{MAX_ASPECT, Shape};
use std::f64::consts::FRAC_PI_2;

/// Kinds of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Spheres,
    Rods,
    Ellipsoids,
    Rings,
}

/// All kinds and all mixtures that have a separation: a ring cannot meet an ellipsoid.
const MIXTURES: [(&str, &[Kind]); 11] = [
    ("spheres", &[Kind::Spheres]),
    ("rods", &[Kind::Rods]),
    ("ellipsoids", &[Kind::Ellipsoids]),
    ("rings", &[Kind::Rings]),
    ("spheres and rods", &[Kind::Spheres, Kind::Rods]),
    ("spheres and ellipsoids", &[Kind::Spheres, Kind::Ellipsoids]),
    ("spheres and rings", &[Kind::Spheres, Kind::Rings]),
    ("rods and ellipsoids", &[Kind::Rods, Kind::Ellipsoids]),
    ("rods and rings", &[Kind::Rods, Kind::Rings]),
    ("spheres, rods and ellipsoids", &[Kind::Spheres, Kind::Rods, Kind::Ellipsoids]),
    ("spheres, rods and rings", &[Kind::Spheres, Kind::Rods, Kind::Rings]),
];

/// Sizes of each kind at most.
const MOST_SIZES: usize = 3;
/// Longest extent of a body from its centre, a length.
const REACH: [f64; 2] = [0.25, 1.0];
/// Aspect ratios of ordinary bodies, and of extreme ones.
const ASPECT: [f64; 2] = [1.05, 8.0];
const EXTREME_ASPECT: [f64; 2] = [8.0, 0.1 * MAX_ASPECT];
/// How often a scene has bodies of extreme aspect ratios.
const EXTREME: f64 = 0.15;
/// Differences of radii that are nearly equal, as parts of them.
const NEARLY: [f64; 2] = [1e-15, 1e-4];

/// The shapes of a scene's bodies.
pub(super) struct Mixture {
    pub(super) shapes: Vec<Shape>,
    pub(super) what: String,
}

impl Mixture {
    pub(super) fn draw(random: &mut Random) -> Mixture {
        let (name, kinds) = MIXTURES[random.below(MIXTURES.len())];
        let extreme = random.chance(EXTREME);
        let aspect = if extreme { EXTREME_ASPECT } else { ASPECT };
        let mut shapes = Vec::new();
        for kind in kinds {
            for _ in 0..=random.below(MOST_SIZES) {
                shapes.push(kind.draw(random, aspect));
            }
        }
        let what = if extreme { format!("{name}, extreme ones,") } else { name.to_owned() };
        Mixture { shapes, what }
    }

    /// The longest extent from a centre.
    pub(super) fn reach(&self) -> f64 {
        self.shapes.iter().map(Shape::bounding_radius).fold(0.0, f64::max)
    }

    /// The thinnest body's thickness.
    pub(super) fn thinnest(&self) -> f64 {
        self.shapes.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min)
    }

    /// The thickest diameter of a rod, where there is one.
    pub(super) fn thickest_rod(&self) -> Option<f64> {
        self.shapes.iter().filter(|shape| shape.growing_length().is_some()).map(Shape::thickness).reduce(f64::max)
    }
}

impl Kind {
    fn draw(self, random: &mut Random, aspect: [f64; 2]) -> Shape {
        let (reach, aspect) = (random.log_within(REACH[0], REACH[1]), random.log_within(aspect[0], aspect[1]));
        match self {
            Kind::Spheres => sphere(reach),
            // One in eight is as long as it is thick.
            Kind::Rods if random.chance(0.125) => rod(2.0 * reach, 2.0 * reach),
            Kind::Rods => rod(2.0 * reach / aspect, 2.0 * reach),
            Kind::Ellipsoids => ellipsoid(radii(random, reach, aspect)),
            // A tube of nearly the ring's radius leaves nearly no hole.
            Kind::Rings if random.chance(0.125) => ring(0.5 * reach, 0.499 * reach),
            Kind::Rings => {
                let minor = reach / (1.0 + 2.0 * aspect);
                ring(reach - minor, minor)
            }
        }
    }
}

fn radii(random: &mut Random, reach: f64, aspect: f64) -> [f64; 3] {
    let thin = reach / aspect;
    let nearly = 1.0 - random.log_within(NEARLY[0], NEARLY[1]);
    let radii = match random.below(5) {
        0 => [thin, thin, reach],
        1 => [reach, reach, thin],
        2 => [thin, random.within(thin, reach), reach],
        // Nearly a ball, and nearly of revolution.
        3 => [reach, reach * nearly, reach],
        _ => [thin, thin * nearly, reach],
    };
    let first = random.below(3);
    [radii[first], radii[(first + 1) % 3], radii[(first + 2) % 3]]
}

/// Draws the orientation of a body: uniform in space. In a planar scene, the plane is a mirror plane of the body, and a
/// growing rod lies in the plane.
pub(super) fn turned(random: &mut Random, shape: &Shape, planar: bool, grows: bool) -> DQuat {
    if !planar {
        // One in eight lies along the axes of space, where poses are degenerate.
        return match random.below(8) {
            0 => along(random.below(3)),
            _ => random.orientation(),
        };
    }
    let lies = match shape {
        Shape::Spherocylinder { .. } if grows => 2,
        _ => random.below(3),
    };
    let turn = DQuat::from_rotation_z(random.within(-std::f64::consts::PI, std::f64::consts::PI));
    (turn * along(lies)).normalize()
}

/// The body's z along one of the axes of space, z first.
fn along(axis: usize) -> DQuat {
    match axis {
        0 => DQuat::IDENTITY,
        1 => DQuat::from_rotation_x(FRAC_PI_2),
        _ => DQuat::from_rotation_y(FRAC_PI_2),
    }
}
