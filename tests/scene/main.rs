//! Scenes: reading, refusing, building, writing.
#![allow(clippy::unwrap_used)]

mod apparatus;
mod bonds_refused;
mod built_in;
mod chainmail;
mod chains;
mod fences;
mod lattices;
mod overrides;
mod placement;
mod random_bodies;
mod refusals;
mod regions;
mod round_trips;
mod schema;
mod warnings;

use relcp::bodies::Bodies;
use relcp::scene::{Generate, Scene, SceneError};
use relcp::shape::Shape;

fn good() -> Scene {
    Scene::built_in("two-ellipsoids").unwrap()
}

fn set(source: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    Scene::load(source, sets.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>())
}

fn isotropic(count: u64, shape: Shape, volume_fraction: f64, planar: bool) -> Scene {
    let mut scene = good();
    scene.bodies.clear();
    scene.forces.clear();
    scene.planar = planar;
    scene.generate = vec![Generate::isotropic(count, shape, Some(volume_fraction))];
    scene
}

fn far_apart(bodies: &Bodies, holds: impl Fn(usize, usize) -> bool) {
    for a in 0..bodies.len() {
        for b in a + 1..bodies.len() {
            assert!(holds(a, b), "bodies {a} and {b}");
        }
    }
}
