//! Periodic space: searches, images, scenes, steps and outputs.
#![allow(clippy::unwrap_used)]

mod broad_phase;
mod outputs;
mod scenes;
mod steps;

use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::separation::{Placed, separation};

/// The largest overlap of a state: every body with every other one at 27 images and more around the nearest, by its own
/// arithmetic.
pub fn audit(bodies: &Bodies) -> f64 {
    let lengths = bodies.periods.lengths();
    let mut worst = 0.0_f64;
    for a in 0..bodies.len() {
        for b in a..bodies.len() {
            let delta = bodies.position[b] - bodies.position[a];
            let near = |axis: usize| -> Vec<f64> {
                let Some(length) = lengths[axis] else { return vec![delta[axis]] };
                let middle = (delta[axis] / length).round();
                (-2..=2).map(|n| delta[axis] - length * (middle + f64::from(n))).collect()
            };
            for (x, y, z) in near(0)
                .iter()
                .flat_map(|x| near(1).into_iter().map(move |y| (*x, y)))
                .flat_map(|(x, y)| near(2).into_iter().map(move |z| (x, y, z)))
            {
                let delta = DVec3::new(x, y, z);
                let reach = bodies.shape[a].bounding_radius() + bodies.shape[b].bounding_radius();
                if (a == b && delta == DVec3::ZERO) || delta.length() > reach {
                    continue;
                }
                let one = Placed { position: DVec3::ZERO, ..bodies.placed(a) };
                let other = Placed { position: delta, ..bodies.placed(b) };
                worst = worst.max(-separation(&one, &other, None).unwrap().separation);
            }
        }
    }
    worst
}

/// Thirty bodies in a small cell, of two groups that are driven through each other.
pub fn suspension(shape: &str) -> Scene {
    let (planar, lengths, shape, fraction) = match shape {
        "ellipsoid" => (false, "[9.5, 10.0, 10.5]", r#"{"ellipsoid": {"radii": [0.8, 1.0, 1.9]}}"#, 0.0957),
        "rod" => (false, "[10.0, 9.0, 11.0]", r#"{"spherocylinder": {"diameter": 1.0, "length": 4.0}}"#, 0.0436),
        _ => (true, "[10.0, 9.0, null]", r#"{"sphere": {"radius": 0.6}}"#, 0.1885),
    };
    let rule = |group: &str| {
        format!(
            r#"{{"isotropic": {{"count": 15, "shape": {shape}, "volume_fraction": {fraction}, "group": "{group}"}}}}"#
        )
    };
    let text = format!(
        r#"{{"name": "suspension", "seed": 11, "planar": {planar}, "time": {{"dt": 0.05, "end": 3.0}}, "contact": {{"method": "relcp"}},
        "periodic": {{"lengths": {lengths}}},
        "forces": [{{"uniform": {{"force": [3.0, 1.0, 0.0], "group": "up"}}}}, {{"uniform": {{"force": [-3.0, 0.5, 0.0], "group": "down"}}}}],
        "generate": [{}, {}]}}"#,
        rule("up"),
        rule("down")
    );
    Scene::parse(&text, "suspension").unwrap()
}
