//! Random shapes, pairs and scenes, from a seed.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::scene::Scene;
use relcp::separation::{Placed, Separation, separation};
use relcp::shape::Shape;
use serde_json::json;

pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    pub fn orientation(&mut self) -> DQuat {
        loop {
            let v = DVec3::splat(0.0) + self.vector();
            let w = self.within(-1.0, 1.0);
            let q = DQuat::from_xyzw(v.x, v.y, v.z, w);
            if q.length() > 0.1 && q.length() < 1.0 {
                return q.normalize();
            }
        }
    }

    pub fn shape(&mut self, kind: &str) -> Shape {
        match kind {
            "sphere" => Shape::Sphere { radius: self.within(0.3, 1.0) },
            "spherocylinder" => {
                let diameter = self.within(0.3, 1.0);
                Shape::Spherocylinder { diameter, length: diameter + self.within(0.5, 2.0) }
            }
            "ellipsoid" => {
                Shape::Ellipsoid { radii: [self.within(0.4, 1.2), self.within(0.4, 1.2), self.within(0.4, 1.2)] }
            }
            "torus" => Shape::Torus { major_radius: self.within(0.8, 1.2), minor_radius: self.within(0.05, 0.2) },
            _ => unreachable!("{kind}"),
        }
    }

    /// A pair of these kinds whose separation lies between -0.05 and 0.2.
    pub fn pair(&mut self, kinds: [&str; 2]) -> (Placed, Placed, Separation) {
        let ring = kinds.contains(&"torus");
        loop {
            let a = Placed { shape: self.shape(kinds[0]), position: self.vector(), orientation: self.orientation() };
            let far = if ring { 2.5 } else { 4.0 };
            let position = a.position + self.direction() * self.within(0.0, far);
            let b = Placed { shape: self.shape(kinds[1]), position, orientation: self.orientation() };
            let found = separation(&a, &b, None).unwrap();
            if (-0.05..0.2).contains(&found.separation) {
                return (a, b, found);
            }
        }
    }
}

/// Every pair of kinds that has a separation.
pub const KINDS: [[&str; 2]; 9] = [
    ["sphere", "sphere"],
    ["sphere", "spherocylinder"],
    ["sphere", "ellipsoid"],
    ["sphere", "torus"],
    ["spherocylinder", "spherocylinder"],
    ["spherocylinder", "ellipsoid"],
    ["spherocylinder", "torus"],
    ["ellipsoid", "ellipsoid"],
    ["torus", "torus"],
];

/// A heap of `count` bodies in a small ball, pulled inwards, many of them overlapping at the start.
pub fn heap(seed: u64, kinds: &[&str], count: usize, dt: f64) -> Scene {
    let mut random = Random::new(seed);
    let size = 0.8 * (count as f64).cbrt();
    let bodies: Vec<_> = (0..count)
        .map(|i| {
            let q = random.orientation();
            let shape = random.shape(kinds[i % kinds.len()]);
            let position = size * random.vector();
            json!({"shape": shape, "position": position.to_array(), "orientation": [q.w, q.x, q.y, q.z]})
        })
        .collect();
    parse(&json!({
        "name": "heap", "time": {"dt": dt, "end": 10.0 * dt}, "forces": [{"radial_inward": {}}], "bodies": bodies,
        "solver": {"tolerance": 1e-10}
    }))
}

pub fn parse(value: &serde_json::Value) -> Scene {
    Scene::parse(&value.to_string(), "test").unwrap()
}
