//! Fields, walls under a load, drag of real bodies, regions, fences and removal for drawn scenes, from a stream of
//! their own, so that the scenes stay what they are.

use super::Drawn;
use crate::hard::start::Random;
use glam::DVec3;
use relcp::scene::{Scene, Wall};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// What this stream's seed differs by from that of the scenes.
const OWN_SEED: u64 = 0x6b65_7973_0000;
/// The part of the scenes that each key is tried in.
const TRIED: f64 = 0.5;
/// Rounds of draws until a key is taken.
const ROUNDS: usize = 10;
/// Numbers that span what users choose: viscosities, drags, forces and diffusion coefficients.
const WIDE: [f64; 2] = [0.05, 20.0];

/// What the draws of keys know of a scene.
struct About<'a> {
    scene: &'a Scene,
    /// The corners of a box about all bodies.
    reach: [DVec3; 2],
    longest: f64,
}

/// A key: its name, and the change of the scene's JSON; none where the scene cannot have it.
type Key = (&'static str, fn(&mut Random, &About<'_>, &mut Value) -> Option<()>);

const KEYS: [Key; 6] =
    [("drag", drag), ("field", field), ("load", load), ("removal", removal), ("region", region), ("fence", fence)];

/// Gives a scene at least one of the keys, where validation takes one.
pub(super) fn furnish(seed: u64, number: u64, drawn: &mut Drawn) {
    let mut random = Random::of_stream(seed ^ OWN_SEED, number);
    let mut taken = Vec::new();
    for _ in 0..ROUNDS {
        for (name, change) in KEYS {
            if !taken.contains(&name) && random.chance(TRIED) && try_one(&mut random, change, &mut drawn.scene) {
                taken.push(name);
            }
        }
        if !taken.is_empty() {
            break;
        }
    }
    let _ = write!(drawn.what, ", with {}", taken.join(", "));
}

/// Whether a key was taken.
fn try_one(
    random: &mut Random,
    change: fn(&mut Random, &About<'_>, &mut Value) -> Option<()>,
    scene: &mut Scene,
) -> bool {
    let ends = || scene.bodies.iter().map(|body| (DVec3::from(body.position), body.shape.bounding_radius()));
    let low = ends().fold(DVec3::INFINITY, |low, (x, r)| low.min(x - r));
    let high = ends().fold(DVec3::NEG_INFINITY, |high, (x, r)| high.max(x + r));
    let longest = scene.bodies.iter().map(|body| body.shape.major_axis()).fold(0.0, f64::max);
    let Ok(mut value) = serde_json::from_str(&scene.to_json()) else { return false };
    if change(random, &About { scene, reach: [low, high], longest }, &mut value).is_none() {
        return false;
    }
    let changed = Scene::parse(&value.to_string(), &scene.name).ok().filter(|scene| scene.build().is_ok());
    changed.map(|changed| *scene = changed).is_some()
}

fn drag(random: &mut Random, _: &About<'_>, of: &mut Value) -> Option<()> {
    let mut number = || random.log_within(WIDE[0], WIDE[1]);
    let (viscous, along, across, turning) = (number(), number(), number(), number());
    let by_axis = random.either(
        0.5,
        json!({"parallel": along, "perpendicular": across}),
        json!({"parallel": along, "perpendicular": across, "rotation": turning}),
    );
    let drag = random.either(0.5, json!({"viscosity": viscous}), by_axis);
    let law = of["dynamics"].as_object_mut()?.values_mut().next()?;
    law["drag"] = drag;
    Some(())
}

/// A grid about all bodies; with a period, one that fits it.
fn field(random: &mut Random, about: &About<'_>, of: &mut Value) -> Option<()> {
    let [low, high] = about.reach;
    let (center, sides) = (0.5 * (low + high), high - low);
    let count = 2.0 + random.below(12) as f64;
    let lengths = about.scene.periodic.map_or([None; 3], |cell| cell.lengths);
    let spacing = lengths.iter().flatten().next().copied().unwrap_or_else(|| sides.max_element()) / count;
    let cells = |axis: usize| match lengths[axis] {
        Some(length) => (length / spacing).round().max(1.0),
        None if axis == 2 && about.scene.planar => 1.0,
        None => (sides[axis] / spacing).ceil().clamp(1.0, 40.0),
    };
    let border = |random: &mut Random, open: bool| {
        let value = json!({"value": random.within(0.0, 2.0)});
        if open && random.chance(0.4) { value } else { json!("closed") }
    };
    let is_open = |axis: usize| lengths[axis].is_none() && !(axis == 2 && about.scene.planar);
    let borders = [0, 1, 2].map(|axis| [(); 2].map(|()| border(random, is_open(axis))));
    let mut exchange =
        vec![json!({"uptake": random.log_within(WIDE[0], WIDE[1]), "half": random.log_within(0.01, 1.0)})];
    if random.chance(0.3) {
        exchange.push(json!({"secretion": random.log_within(0.01, 1.0)}));
    }
    let counts = [0, 1, 2].map(|axis| cells(axis) as u32);
    let middle = [0, 1, 2].map(|axis| if lengths[axis].is_some() { 0.0 } else { center[axis] });
    let [x, y, z] = borders;
    let mut food = json!({"cells": counts, "spacing": spacing, "center": middle, "exchange": exchange,
        "diffusion": random.log_within(WIDE[0], WIDE[1]), "initial": random.within(0.0, 2.0),
        "boundary": {"x": x, "y": y, "z": z}});
    if random.chance(0.3) {
        food["decay"] = json!(random.within(0.0, 2.0));
    }
    if random.chance(0.4) {
        let radius = random.within(0.1, 0.6) * sides.max_element();
        food["held"] = json!([{"inside": ball(about.scene, center, radius), "value": random.within(0.0, 2.0)}]);
    }
    of["fields"] = json!({"food": food});
    for species in of["growth"].as_array_mut().into_iter().flatten() {
        species["nutrient"] = json!({"field": "food", "half": random.log_within(0.01, 1.0)});
    }
    if of["growth"].is_object() {
        of["growth"]["nutrient"] = json!({"field": "food", "half": random.log_within(0.01, 1.0)});
    }
    Some(())
}

/// A wall at the side of all bodies along an open axis, under a load; settings that do not support it give way.
fn load(random: &mut Random, about: &About<'_>, of: &mut Value) -> Option<()> {
    let periods = about.scene.periodic.map_or([None; 3], |cell| cell.lengths);
    let axes: Vec<usize> =
        (0..if about.scene.planar { 2 } else { 3 }).filter(|axis| periods[*axis].is_none()).collect();
    let axis = *axes.get(random.below(axes.len().max(1)))?;
    let sign = random.either(0.5, 1.0, -1.0);
    let normal = sign * DVec3::AXES[axis];
    let [low, high] = about.reach;
    let side = if sign > 0.0 { low[axis] } else { -high[axis] };
    let strength = random.either(0.8, 1.0, -1.0) * random.log_within(WIDE[0], WIDE[1]);
    let resistance = random.log_within(WIDE[0], WIDE[1]);
    let name = random.either(0.3, "pressure", "force");
    let mut load = json!({(name): strength});
    load[random.either(0.5, "drag", "mass")] = json!(resistance);
    let away = random.within(0.0, 1.0) * about.longest;
    let mut wall = json!({"normal": normal.to_array(), "offset": side - away, "load": load});
    if random.chance(0.3) {
        let along = axes.iter().find(|other| **other != axis).map_or(DVec3::ZERO, |other| DVec3::AXES[*other]);
        wall["motion"] = json!({"velocity": (random.within(-1.0, 1.0) * along).to_array()});
    }
    of["time"]["stepping"] = json!("euler");
    of["contact"].as_object_mut()?.remove("restitution");
    of["walls"].as_array_mut()?.push(json!({"half_space": wall}));
    Some(())
}

fn removal(random: &mut Random, about: &About<'_>, of: &mut Value) -> Option<()> {
    let [low, high] = about.reach;
    let radius = random.within(0.2, 1.0) * (high - low).max_element();
    let shape = ball(about.scene, 0.5 * (low + high), radius);
    let rate = random.within(0.0, 0.5) / (about.scene.time.end - about.scene.time.start);
    let inside = random.either(0.5, "inside", "outside");
    of["removal"] = random.either(0.3, json!([{"rate": rate}]), json!([{(inside): shape}]));
    Some(())
}

/// Further bodies, of two kinds, in a region.
fn region(random: &mut Random, about: &About<'_>, of: &mut Value) -> Option<()> {
    let [low, high] = about.reach;
    let size = about.longest * random.within(0.1, 0.4);
    let center = 0.5 * (low + high) + 0.5 * random.vector() * (high - low);
    let center = if about.scene.planar { center.with_z(0.0) } else { center };
    let radius = random.within(4.0, 10.0) * size;
    let count = 1 + random.below(6);
    of["generate"] = json!([{"isotropic": {"count": count, "shape": {"sphere": {"radius": 0.5 * size}}, "group": "placed",
        "region": ball(about.scene, center, radius),
        "mixture": [{"count": 2, "shape": {"ellipsoid": {"radii": [0.4 * size, 0.4 * size, 0.9 * size]}}, "group": "placed"}]}}]);
    Some(())
}

/// Two fences beside all bodies.
fn fence(random: &mut Random, about: &About<'_>, of: &mut Value) -> Option<()> {
    let [low, high] = about.reach;
    let diameter = about.longest * random.within(0.2, 0.5);
    let away = diameter * random.within(0.6, 3.0);
    let at = |x: f64, y: f64| json!([x, y, if about.scene.planar { 0.0 } else { 0.5 * (low.z + high.z) }]);
    let points = [at(low.x - away, low.y - away), at(low.x - away, high.y + away), at(high.x + away, high.y + away)];
    let offset = [high.x - low.x + 2.0 * away, low.y - high.y - 2.0 * away, 0.0];
    of["generate"] = json!([{"fence": {"points": points, "diameter": diameter, "repeat": [{"count": 2, "offset": offset}], "group": "fence"}}]);
    Some(())
}

/// The inside of a ball, in the plane of a disc about its centre there.
fn ball(scene: &Scene, center: DVec3, radius: f64) -> Value {
    let center = if scene.planar { center.with_z(0.0) } else { center };
    let shape = Wall::Sphere { center: center.to_array(), radius, motion: None, friction: None };
    serde_json::to_value(shape).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard::random::random;

    #[test]
    fn most_drawn_scenes_get_a_key_and_each_key_is_drawn() {
        let (mut told, mut without) = (String::new(), 0);
        for number in 0..80 {
            let mut drawn = random(7, number).unwrap();
            let own = drawn.scene.bodies.clone();
            furnish(7, number, &mut drawn);
            drawn.scene.validate().unwrap();
            assert_eq!(drawn.scene.bodies.len(), own.len());
            without += usize::from(drawn.what.ends_with("with "));
            told.push_str(&drawn.what);
        }
        for (name, _) in KEYS {
            assert!(told.matches(&format!(" {name}")).count() > 5, "{name}");
        }
        assert!(without < 3, "{without}");
    }
}
