//! The built-in `pressed-ring` against the elastica: a ring that lies flat between two plates pushes on each with
//! `B (I / H)^2`, whatever its length, where `H` is the height of its middle line and `I` the integral of `sin^(1/2)`
//! over half a turn.
//!
//! The free arcs bend by `B t'' = F cos(t)`, with no moment where they leave the flat parts and so `B t'^2 / 2 = F
//! sin(t)`; their height is the integral of `sin(t) / t'`, and each plate bears both arcs, `2 F` (R. Frisch-Fay,
//! *Flexible Bars*, 1962, has elasticas of this kind).

use relcp::scene::BuiltIn;
use relcp::{Scene, Simulation};
use serde_json::Value;

/// `sqrt(pi) gamma(3/4) / gamma(5/4)`, the integral of `sqrt(sin t)` from 0 to `pi`.
const INTEGRAL: f64 = 2.396_280_469_471_184;

/// The bending modulus of the ring, and the height of its middle line at the end, by the keys of its scene.
fn modulus_and_height(scene: &Value) -> (f64, f64) {
    let number = |pointer: &str| scene.pointer(pointer).and_then(Value::as_f64).unwrap();
    let chain = "/generate/0/chain";
    let of_rod = |key: &str| number(&format!("{chain}/shape/spherocylinder/{key}"));
    let link = of_rod("length") + number(&format!("{chain}/gap"));
    let motion = "/walls/1/half_space/motion";
    let time = number(&format!("{motion}/window/to")) - number(&format!("{motion}/window/from"));
    let gap = -number("/walls/0/half_space/offset") - number("/walls/1/half_space/offset");
    let height = gap + time * number(&format!("{motion}/velocity/1")) - of_rod("diameter");
    (number(&format!("{chain}/bending")) * link, height)
}

#[test]
fn a_ring_that_lies_flat_pushes_with_the_force_of_an_elastica() {
    let text: Value = serde_json::from_str(BuiltIn::named("pressed-ring").unwrap().text).unwrap();
    let (modulus, height) = modulus_and_height(&text);
    let mut simulation = Simulation::new(Scene::built_in("pressed-ring").unwrap()).unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
    }
    // All contacts are with the two plates, which bear the same.
    let force = 0.5 * simulation.state().unwrap().warm.iter().map(|warm| warm.gamma).sum::<f64>();
    let expected = modulus * (INTEGRAL / height).powi(2);
    println!("force {force}, of an elastica {expected}");
    // Of its links 32 are in a full turn: the rest is of second order in their angle.
    assert!((force / expected - 1.0).abs() < 0.015, "{force} {expected}");
}
