//! Steps of custom shapes, audited by contacts that are computed afresh, and a picture.

use crate::bodies::{die, egg, ellipsoid, placed, random};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::dynamics::Load;
use relcp::render::{Colour, View, picture};
use relcp::scene::Scene;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::contacts;

/// A scene of one ball, whose bodies are replaced.
fn scene(rest: &str) -> Scene {
    let ball = r#""bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ]"#;
    Scene::parse(&format!(r#"{{ "name": "custom", "seed": 1, {ball}, {rest} }}"#), "custom").unwrap()
}

/// Bodies of several kinds on a grid, turned at random.
fn crowd(side: i32, pitch: f64) -> Bodies {
    let shapes = [
        Shape::Convex(egg()),
        Shape::Convex(die(0.1)),
        Shape::Ellipsoid { radii: [0.6, 0.8, 1.1] },
        Shape::Sphere { radius: 0.7 },
        Shape::Spherocylinder { diameter: 0.6, length: 2.4 },
    ];
    let mut bodies = Bodies::default();
    let random = &mut random(31);
    for k in 0..side.pow(3) {
        let place =
            [k % side, k / side % side, k / (side * side)].map(|i| pitch * (f64::from(i) - 0.5 * f64::from(side - 1)));
        bodies.push(placed(shapes[k as usize % 5], DVec3::from_array(place), turn(random)), NO_GROUP);
    }
    bodies
}

fn worst(bodies: &Bodies) -> f64 {
    contacts(bodies, 0.0).iter().fold(0.0, |worst, contact| worst.max(-contact.separation))
}

#[test]
fn a_crowd_drawn_together_overlaps_by_no_more_than_the_tolerance() {
    let scene = scene(r#""time": { "dt": 0.05, "end": 3.0 }"#);
    assert_eq!(scene.contact.overlap_tolerance, 1e-5);
    let mut simulation = Simulation::builder(scene).bodies(crowd(2, 4.0)).build().unwrap();
    simulation.add_force(Box::new(|bodies: &Bodies, i: usize, _: f64| Load {
        force: -4.0 * bodies.position[i],
        torque: DVec3::ZERO,
    }));
    while !simulation.done() {
        let report = simulation.step().unwrap();
        let audited = worst(&simulation.state().unwrap().bodies);
        assert!(report.max_overlap <= 1e-5 && audited <= 1e-5, "step {}: {audited:e}", report.step);
    }
    let touching = simulation.contacts(1e-3).unwrap().len();
    assert!(touching >= 12, "{touching}");
}

#[test]
fn dice_and_eggs_that_fall_come_to_rest_on_a_floor() {
    let scene = scene(
        r#""time": { "dt": 0.02, "end": 1.0 },
             "dynamics": { "inertial": { "density": 1.0 } },
             "forces": [ { "gravity": { "acceleration": [0, 0, -10] } } ],
             "walls": [ { "half_space": { "normal": [0, 0, 1], "offset": -4 } } ]"#,
    );
    let mut bodies = Bodies::default();
    for (k, shape) in [Shape::Convex(die(0.1)), Shape::Convex(egg()), Shape::Convex(die(0.1))].into_iter().enumerate() {
        let leaning = DQuat::from_rotation_x(0.2 + 0.3 * k as f64);
        bodies.push(placed(shape, DVec3::new(0.3 * k as f64, 0.0, 4.2 * k as f64 - 1.5), leaning), NO_GROUP);
    }
    let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        let walls = simulation.wall_contacts(0.0).unwrap();
        assert!(walls.iter().all(|contact| contact.separation >= -1e-5), "{walls:?}");
    }
    assert!(!simulation.wall_contacts(1e-3).unwrap().is_empty());
}

/// The same run with ellipsoids of the library and with the same given by their support functions.
#[test]
fn custom_ellipsoids_go_the_way_of_ellipsoids() {
    let run = |custom: bool| {
        let scene = Scene::load("two-ellipsoids", ["time.end=0.2"]).unwrap();
        let mut bodies = scene.build().unwrap();
        for shape in bodies.shape.iter_mut().filter(|_| custom) {
            if let Shape::Ellipsoid { radii } = *shape {
                *shape = Shape::Convex(ellipsoid(radii));
            }
        }
        let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
        while !simulation.done() {
            simulation.step().unwrap();
        }
        simulation.state().unwrap().bodies.position.clone()
    };
    for (own, custom) in run(false).iter().zip(run(true)) {
        assert!(own.abs_diff_eq(custom, 1e-9), "{own} {custom}");
    }
}

#[test]
fn a_run_is_the_same_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let scene = scene(r#""time": { "dt": 0.05, "end": 0.5 }"#);
            let mut simulation = Simulation::builder(scene).bodies(BODIES.clone()).build().unwrap();
            simulation.add_force(Box::new(|bodies: &Bodies, i: usize, _: f64| Load {
                force: -10.0 * bodies.position[i],
                torque: DVec3::ZERO,
            }));
            while !simulation.done() {
                simulation.step().unwrap();
            }
            simulation.state().unwrap().bodies.clone()
        })
    };
    assert_eq!(run(1), run(3));
}

/// The same shapes for both runs: two that are made alike are not equal.
static BODIES: std::sync::LazyLock<Bodies> = std::sync::LazyLock::new(|| crowd(2, 3.5));

#[test]
fn the_picture_of_custom_ellipsoids_is_that_of_ellipsoids() {
    let radii = [0.5, 0.8, 1.2];
    let random = &mut random(33);
    let poses: Vec<_> = (0..20).map(|_| (2.0 * direction(random), turn(random))).collect();
    let drawn = |shape: Shape| {
        let mut bodies = Bodies::default();
        for (position, orientation) in &poses {
            bodies.push(placed(shape, *position, *orientation), NO_GROUP);
        }
        picture(&bodies, &View { width: 120, height: 90, colour: Colour::Plain, ..View::default() })
    };
    let (own, custom) = (drawn(Shape::Ellipsoid { radii }), drawn(Shape::Convex(ellipsoid(radii))));
    let pixels = || (0..own.height()).flat_map(|y| (0..own.width()).map(move |x| (x, y)));
    let differ = |(x, y): (u32, u32)| {
        let [a, b] = [&own, &custom].map(|image| image.pixel(x, y).unwrap());
        a.into_iter().zip(b).any(|(a, b)| a.abs_diff(b) > 1)
    };
    assert!(pixels().filter(|(x, y)| own.pixel(*x, *y) != Some([255; 3])).count() > 2000);
    assert_eq!(pixels().filter(|at| differ(*at)).count(), 0);
}
