//! Pairs computed in extended precision, `tests/data/pairs.json`.

use glam::DQuat;
use relcp::separation::Placed;
use relcp::shape::Shape;
use serde::Deserialize;

/// A reference pair.
#[derive(Deserialize)]
pub struct Pair {
    pub kind: String,
    pub a: Body,
    pub b: Body,
    pub normal: [f64; 3],
    pub separation: f64,
    pub point_a: Option<[f64; 3]>,
    pub point_b: Option<[f64; 3]>,
}

/// A body of it.
#[derive(Deserialize)]
pub struct Body {
    shape: Shape,
    position: [f64; 3],
    orientation: [f64; 4],
}

impl Body {
    pub fn placed(&self) -> Placed {
        let [w, x, y, z] = self.orientation;
        let orientation = DQuat::from_xyzw(x, y, z, w).normalize();
        Placed { shape: self.shape, position: self.position.into(), orientation }
    }
}

/// All of them.
pub fn reference_pairs() -> Vec<Pair> {
    let pairs: Vec<Pair> = serde_json::from_str(include_str!("../data/pairs.json")).unwrap();
    assert_eq!(pairs.len(), 868);
    pairs
}
