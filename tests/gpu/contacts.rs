//! Contacts that a device lists against the CPU's.

use crate::device::{device, precisions};
use glam::DVec3;
use relcp::Contact;
use relcp::bodies::Bodies;
use relcp::gpu::{GpuError, Precision};
use relcp::record::read_state;
use relcp::scene::{BuiltIn, Scene};
use relcp::shape::{Convex, Shape};
use relcp::simulation::Compute;
use relcp::walls::Walls;

fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 2e-6,
        Precision::F64 => 1e-11,
    }
}

/// The size that a tolerance is a part of: that of both bodies.
fn size(bodies: &Bodies, [a, b]: [usize; 2]) -> f64 {
    bodies.shape[a].bounding_radius() + bodies.shape[b].bounding_radius()
}

/// Whether the axes of two rods meet, as in the corner of a fence: every direction across both is then a normal.
fn axes_meet(bodies: &Bodies, near: &Contact) -> bool {
    let [a, b] = near.bodies.map(|body| bodies.shape[body].thickness());
    near.separation <= -0.5 * (a + b) * (1.0 - MEETING)
}

/// A separation that is deepest but for this part is that of axes that meet.
const MEETING: f64 = 1e-6;

/// Compares both lists. A pair that one of them has and the other not is nearer to the cutoff than the tolerance.
fn compare(what: &str, (bodies, walls): (&Bodies, &Walls), cutoff: f64, compute: &Compute) -> [usize; 2] {
    let Compute::Gpu { precision, .. } = compute else { panic!("{what}") };
    let tolerance = tolerance(*precision);
    let ours = compute.contacts(bodies, cutoff).unwrap();
    let theirs = Compute::Cpu.contacts(bodies, cutoff).unwrap();
    let mut worst = [0.0f64; 3];
    for near in &theirs {
        let size = size(bodies, near.bodies);
        let Some(own) = ours.iter().find(|own| (own.bodies, own.image) == (near.bodies, near.image)) else {
            assert!((near.separation - cutoff).abs() <= tolerance * size, "{what}: {near:?} is not listed");
            continue;
        };
        let [a, b] = own.points(bodies);
        let along = (b - a).dot(own.normal) - own.separation;
        worst[0] = worst[0].max((own.separation - near.separation).abs() / size);
        if !axes_meet(bodies, near) {
            worst[1] = worst[1].max((own.normal - near.normal).length());
        }
        worst[2] = worst[2].max(along.abs() / size);
    }
    let unknown = ours.iter().filter(|own| theirs.iter().all(|near| near.bodies != own.bodies));
    for own in unknown {
        assert!((own.separation - cutoff).abs() <= tolerance * size(bodies, own.bodies), "{what}: {own:?}");
    }
    let mut past = 0.0f64;
    let (of_walls, expected) = (compute.wall_contacts(bodies, walls, cutoff).unwrap(), walls.contacts(bodies, cutoff));
    assert_eq!(of_walls.len(), expected.len(), "{what}");
    for (own, near) in of_walls.iter().zip(&expected) {
        let size = 2.0 * bodies.shape[near.body].bounding_radius();
        assert_eq!((own.body, own.wall), (near.body, near.wall), "{what}");
        past = past.max((own.separation - near.separation).abs() / size);
        let (turned, apart) = ((own.normal - near.normal).length(), own.point(bodies) - near.point(bodies));
        // On a flat face the point moves by any root of what the normal turns by, and with it the normal of a wall that
        // bends: certain is its depth.
        let flat = matches!(bodies.shape[near.body], Shape::Superellipsoid(_));
        let (turned, apart) =
            if flat { (turned / 1e3, apart.dot(near.normal).abs()) } else { (turned, apart.length()) };
        past = past.max(turned).max(apart / size);
    }
    println!("{what} {}: {} pairs {worst:?}, {} at walls {past:.1e}", precision.name(), ours.len(), of_walls.len());
    assert!(worst[0] <= tolerance && worst[2] <= tolerance && past <= tolerance, "{what}: {worst:?} {past:e}");
    // A normal of bodies that lie along each other has the rounding of the gap over their sizes.
    assert!(worst[1] <= 1e3 * tolerance, "{what}: {worst:?}");
    [ours.len(), of_walls.len()]
}

#[test]
fn contacts_of_built_in_scenes_are_the_cpus() {
    let Some(gpu) = device() else { return };
    let mut pairs = 0;
    for scene in BuiltIn::ALL {
        let scene = Scene::built_in(scene.name).unwrap();
        let bodies = scene.build().unwrap();
        if bodies.len() > 1000 || Compute::check(&scene).is_err() {
            continue;
        }
        let walls = scene.walls();
        let cutoff = 0.25 * bodies.shape.iter().map(|shape| shape.bounding_radius()).fold(0.0, f64::max);
        for precision in precisions(gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision };
            pairs += compare(&scene.name, (&bodies, &walls), cutoff, &compute)[0];
        }
    }
    assert!(pairs > 1000, "{pairs}");
}

#[test]
fn contacts_of_dense_states_are_the_cpus() {
    let Some(gpu) = device() else { return };
    for (file, cutoff) in [("colony-1024", 0.02), ("compaction-1000", 0.1)] {
        let path = format!("{}/assets/states/{file}.npz", env!("CARGO_MANIFEST_DIR"));
        let bodies = read_state(path.as_ref()).unwrap().1.bodies;
        for precision in precisions(gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision };
            let [pairs, _] = compare(file, (&bodies, &Walls::default()), cutoff, &compute);
            assert!(pairs > 1000, "{pairs}");
        }
    }
}

#[test]
fn contacts_with_walls_of_every_kind_are_the_cpus() {
    let Some(gpu) = device() else { return };
    // Each shape alone, so that the numbers of contacts are its own.
    let of = |shape: &str| WALLED.replace("SHAPE", shape);
    let scenes = [
        of(r#"{"ellipsoid": {"radii": [0.6, 0.3, 0.4]}}"#),
        of(r#"{"torus": {"major_radius": 0.8, "minor_radius": 0.2}}"#),
    ];
    for text in scenes {
        let scene = Scene::parse(&text, "walled").unwrap();
        let (bodies, walls) = (scene.build().unwrap(), scene.walls());
        for precision in precisions(gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision };
            for cutoff in [1.5, 3.0] {
                let [_, at_walls] = compare("walled", (&bodies, &walls), cutoff, &compute);
                assert!(at_walls > 3, "{at_walls}");
            }
        }
    }
}

const WALLED: &str = r#"{ "name": "walled", "time": {"dt": 0.01, "end": 0.1},
        "walls": [
            {"box": {"minimum": [-3, -3, -3], "maximum": [3, 3, 3]}},
            {"sphere": {"center": [0, 0, 0], "radius": 4}},
            {"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 3.5, "length": 6}},
            {"half_space": {"normal": [0, 1, 1], "offset": -3}}],
        "bodies": [
            {"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [1.5, 0.2, 0.1]},
            {"shape": SHAPE, "position": [-1.5, -1.1, -1.2]},
            {"shape": SHAPE, "position": [0, 1.7, -1.5]},
            {"shape": {"sphere": {"radius": 0.4}}, "position": [-2, 2, 0.3]}] }"#;

#[test]
fn bodies_near_each_other_through_several_images_are_listed_at_each() {
    let Some(gpu) = device() else { return };
    let text = r#"{ "name": "cell", "time": {"dt": 0.01, "end": 0.1}, "periodic": {"lengths": [3.0, 4.0, null]},
        "walls": [{"half_space": {"normal": [0, 0, 1], "offset": -2}}],
        "bodies": [
            {"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0.1, 0, 0]},
            {"shape": {"ellipsoid": {"radii": [0.6, 0.3, 0.4]}}, "position": [1.5, 1.9, -1.2]},
            {"shape": {"sphere": {"radius": 0.4}}, "position": [100.2, -55.9, 0.3]}] }"#;
    let scene = Scene::parse(text, "cell").unwrap();
    let (bodies, walls) = (scene.build().unwrap(), scene.walls());
    for precision in precisions(gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let [pairs, at_walls] = compare("cell", (&bodies, &walls), 2.5, &compute);
        assert!(pairs > 6 && at_walls > 0, "{pairs} {at_walls}");
    }
}

#[test]
fn what_a_device_has_not_is_refused_with_the_reason() {
    let Some(gpu) = device() else { return };
    let compute = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    let mut bodies = Scene::built_in("three-capsules").unwrap().build().unwrap();
    bodies.shape[1] = Shape::Convex(Convex::new(|n: DVec3| n).unwrap());
    let fault = compute.contacts(&bodies, 0.1).unwrap_err();
    assert!(matches!(fault, GpuError::Unsupported { .. }) && fault.to_string().contains("on the CPU"), "{fault}");
    let mut bodies = Scene::built_in("three-capsules").unwrap().build().unwrap();
    bodies.position[0].x = 1e12;
    let fault = compute.contacts(&bodies, 0.1).unwrap_err();
    assert!(fault.to_string().contains("of the origin"), "{fault}");
    let none = Bodies::default();
    assert_eq!(compute.contacts(&none, 1.0).unwrap(), []);
    assert_eq!(compute.wall_contacts(&none, &Walls::default(), 1.0).unwrap(), []);
}
