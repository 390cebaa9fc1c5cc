//! Runs of superellipsoids: in every kind of space against those of ellipsoids where the exponents are 2; crowds whose
//! overlaps are audited; one on an incline; runs that crashed.

use glam::{DQuat, DVec3};
use rand::RngExt;
use relcp::bodies::NO_GROUP;
use relcp::record::{Folder, decode, encode};
use relcp::render::{Colour, View, picture};
use relcp::run::Run;
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;
use relcp::step::{State, contacts};
use relcp::{Bodies, Compute, Scene, Simulation};
use serde_json::{Value, json};
use std::time::Duration;

use crate::bodies::random;
use crate::directions::{direction, turn};

fn parse(scene: &Value) -> Scene {
    Scene::parse(&scene.to_string(), "scene").unwrap_or_else(|fault| panic!("{fault}\n{scene:#}"))
}

fn to_end(scene: &Value) -> Bodies {
    let mut simulation = Simulation::new(parse(scene)).unwrap();
    let mut touched = 0;
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        touched += simulation.contacts(1e-5).unwrap().len() + simulation.wall_contacts(1e-5).unwrap().len();
    }
    assert!(touched > 3, "{touched} contacts in all steps");
    simulation.state().unwrap().bodies.clone()
}

/// Draws all bodies to the origin.
fn inward() -> Value {
    json!([{"trap": {"stiffness": 5.0, "center": [0, 0, 0]}}])
}

/// Drives the bodies of the two groups through each other.
fn through() -> Value {
    json!([{"uniform": {"force": [6, 1, 0], "group": "0"}}, {"uniform": {"force": [-6, 1, 0.5], "group": "1"}}])
}

/// A number of bodies on a grid of this pitch, turned at random, in two groups.
fn grid(side: i32, pitch: f64, shapes: &[Value]) -> Vec<Value> {
    let random = &mut random(71);
    (0..side.pow(3))
        .map(|k| {
            let at = [k % side, k / side % side, k / (side * side)];
            let q = turn(random);
            json!({"shape": shapes[k as usize % shapes.len()], "group": (k % 2).to_string(), "orientation": [q.w, q.x, q.y, q.z],
                "position": at.map(|i| pitch * (f64::from(i) - 0.5 * f64::from(side - 1)))})
        })
        .collect()
}

fn with(mut scene: Value, more: Value) -> Value {
    for (key, value) in more.as_object().unwrap() {
        scene[key] = value.clone();
    }
    scene
}

/// A scene for each law and space, of bodies of this shape.
fn everywhere(shape: impl Fn([f64; 3]) -> Value) -> Vec<(&'static str, Value)> {
    let bodies = grid(2, 1.5, &[shape([0.5, 0.6, 0.8]), shape([0.7, 0.7, 0.4]), shape([0.6, 0.6, 0.6])]);
    let scene = json!({"name": "crowd", "time": {"dt": 0.02, "end": 0.4}, "bodies": bodies,
        "solver": {"tolerance": 1e-11}, "forces": inward()});
    let law = |law: Value| with(scene.clone(), json!({"dynamics": law}));
    let heavy = json!([{"gravity": {"acceleration": [1.0, 0.0, -9.81]}}]);
    let poured = |walls: Value| {
        with(
            scene.clone(),
            json!({"dynamics": {"inertial": {"density": 1.0}}, "forces": heavy, "walls": walls,
                "contact": {"friction": 0.4}, "solver": {"tolerance": 1e-10}}),
        )
    };
    let lying = |radii: [f64; 3], x: f64| json!({"shape": shape(radii), "position": [x, 0.1 * x, 0]});
    vec![
        ("drag", law(json!({"overdamped": {"drag": 1.5}}))),
        (
            "drag by axis",
            law(json!({"overdamped": {"drag": {"parallel": 1.0, "perpendicular": 2.0, "rotation": 1.0}}})),
        ),
        (
            "midpoint",
            with(
                law(json!({"overdamped": {"drag": 1.0}})),
                json!({"time": {"dt": 0.02, "end": 0.4, "stepping": "midpoint"}}),
            ),
        ),
        ("on a floor", poured(json!([{"half_space": {"normal": [0, 0, 1], "offset": -1.8}}]))),
        (
            "in a tube",
            poured(json!([{"cylinder": {"center": [0, 0, 0], "axis": [1, 1, 4], "radius": 2.2, "length": 4.4}}])),
        ),
        ("in a ball", poured(json!([{"sphere": {"center": [0, 0, 0], "radius": 2.4}}]))),
        ("in a box", poured(json!([{"box": {"minimum": [-1.7, -1.7, -1.7], "maximum": [1.7, 1.7, 1.7]}}]))),
        (
            "periodic",
            with(
                law(json!({"overdamped": {"drag": 1.0}})),
                json!({"periodic": {"lengths": [3.4, 3.45, 3.5]}, "forces": through()}),
            ),
        ),
        (
            "sheared",
            with(
                law(json!({"inertial": {"density": 1.0}})),
                json!({"periodic": {"lengths": [3.5, 3.4, 3.45], "shear": {"rate": 0.6, "direction": "x", "gradient": "y"}},
                    "forces": through()}),
            ),
        ),
        (
            "planar",
            with(
                scene.clone(),
                json!({"planar": true,
                    "bodies": [lying([0.5, 0.6, 0.8], -1.3), lying([0.5, 0.6, 0.8], 0.1), lying([0.7, 0.3, 0.4], 1.4)]}),
            ),
        ),
    ]
}

#[test]
fn with_exponents_of_two_a_run_is_that_of_ellipsoids() {
    let ellipsoids = everywhere(|radii| json!({"ellipsoid": {"radii": radii}}));
    let twins = everywhere(|radii| json!({"superellipsoid": {"radii": radii, "exponents": [2, 2]}}));
    for ((name, own), (_, twin)) in ellipsoids.iter().zip(&twins) {
        let [own, twin] = [own, twin].map(to_end);
        for i in 0..own.len() {
            let off = own.position[i].distance(twin.position[i]);
            let turned = 1.0 - own.orientation[i].dot(twin.orientation[i]).abs();
            assert!(off < 1e-6 && turned < 1e-9, "{name}, body {i}: {off:e} {turned:e}");
        }
    }
}

/// Of every pair of bodies and every one of their images the largest overlap, by an arithmetic of its own.
fn audit(bodies: &Bodies) -> f64 {
    let lengths = bodies.periods.lengths();
    let tilt = bodies.periods.tilt();
    let mut worst = 0.0_f64;
    for (a, b) in (0..bodies.len()).flat_map(|a| (a..bodies.len()).map(move |b| (a, b))) {
        for k in 0..125 {
            let turns = [k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2];
            if (0..3).any(|axis| lengths[axis].is_none() && turns[axis] != 0) || (a == b && turns == [0; 3]) {
                continue;
            }
            let mut delta = bodies.position[b] - bodies.position[a];
            for axis in 0..3 {
                delta[axis] += f64::from(turns[axis]) * lengths[axis].unwrap_or(0.0);
            }
            if let Some(tilt) = tilt {
                delta[tilt.direction as usize] += f64::from(turns[tilt.gradient as usize]) * tilt.offset;
            }
            if delta.length() > bodies.shape[a].bounding_radius() + bodies.shape[b].bounding_radius() {
                continue;
            }
            let one = Placed { position: DVec3::ZERO, ..bodies.placed(a) };
            let other = Placed { position: delta, ..bodies.placed(b) };
            worst = worst.max(-separation(&one, &other, None).unwrap().separation);
        }
    }
    worst
}

fn dice() -> [Value; 5] {
    let of = |radii: [f64; 3], exponents: [f64; 2]| json!({"superellipsoid": {"radii": radii, "exponents": exponents}});
    [
        of([0.5, 0.5, 0.5], [8.0, 8.0]),
        of([0.6, 0.6, 0.3], [2.5, 2.0]),
        json!({"spherocylinder": {"diameter": 0.6, "length": 1.4}}),
        of([0.3, 0.4, 0.8], [10.0, 3.0]),
        json!({"ellipsoid": {"radii": [0.4, 0.5, 0.7]}}),
    ]
}

/// Superellipsoids of several exponents with a rod and an ellipsoid, pressed together in an open, a periodic and a
/// sheared space.
#[test]
fn crowds_overlap_by_no_more_than_the_tolerance_through_every_image() {
    let cells = [
        json!({}),
        json!({"periodic": {"lengths": [3.6, 3.6, 3.7]}, "forces": through()}),
        json!({"periodic": {"lengths": [3.7, 3.7, 3.6], "shear": {"rate": 0.8, "direction": "x", "gradient": "z"}},
            "dynamics": {"inertial": {"density": 1.0}}, "forces": through()}),
    ];
    for cell in cells {
        let scene = with(
            json!({"name": "crowd", "time": {"dt": 0.02, "end": 0.6}, "bodies": grid(2, 1.7, &dice()),
                "forces": inward()}),
            cell,
        );
        let mut simulation = Simulation::new(parse(&scene)).unwrap();
        let mut touching = 0;
        while !simulation.done() {
            let report = simulation.step().unwrap();
            let audited = audit(&simulation.state().unwrap().bodies);
            assert!(audited <= 1e-5, "step {}: {audited:e} {report:?}", report.step);
            touching = touching.max(simulation.contacts(1e-5).unwrap().len());
        }
        assert!(touching >= 3, "{touching} {scene}");
    }
}

/// A die that lies on an incline stays or slides by Coulomb's law, by a coefficient to both sides of the slope.
#[test]
fn a_die_on_an_incline_slides_where_it_is_steep() {
    let angle = 0.4_f64;
    for friction in [0.3, 0.38, 0.46] {
        let die = json!({"superellipsoid": {"radii": [0.5, 0.5, 0.25], "exponents": [8, 8]}});
        let scene = json!({"name": "incline", "time": {"dt": 0.002, "end": 1.0}, "contact": {"friction": friction},
            "dynamics": {"inertial": {"density": 1.0}}, "walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}}],
            "forces": [{"gravity": {"acceleration": [10.0 * angle.sin(), 0, -10.0 * angle.cos()]}}],
            "bodies": [{"shape": die, "position": [0, 0, 0.25]}]});
        let bodies = to_end(&scene);
        let fall = 10.0 * (angle.sin() - friction * angle.cos()).max(0.0);
        // It rocks a little while it slides, as its contact moves until it is under the weight.
        assert!((bodies.velocity[0].x - fall).abs() < 0.02, "{friction}: {} {fall}", bodies.velocity[0]);
        assert!((bodies.position[0].x - 0.5 * fall).abs() < 0.01, "{friction}: {} {fall}", bodies.position[0]);
        assert!((bodies.position[0].z - 0.25).abs() < 1e-3, "{friction}: {}", bodies.position[0]);
    }
}

/// A body that turns freely keeps its angular momentum and its energy.
#[test]
fn a_brick_that_turns_freely_keeps_spin_and_energy() {
    let brick = json!({"superellipsoid": {"radii": [0.3, 0.5, 0.9], "exponents": [6, 3]}});
    let scene = json!({"name": "top", "time": {"dt": 0.001, "end": 1.0}, "dynamics": {"inertial": {"density": 2.0}},
        "bodies": [{"shape": brick, "position": [0, 0, 0], "angular_velocity": [1.0, 5.0, 0.5]}]});
    let of = |bodies: &Bodies| {
        let (q, w) = (bodies.orientation[0], bodies.angular_velocity[0]);
        let own = q.inverse() * w;
        let spin = 2.0 * bodies.shape[0].unit_inertia() * own;
        (q * spin, 0.5 * spin.dot(own))
    };
    let start = of(&parse(&scene).build().unwrap());
    let mut simulation = Simulation::new(parse(&scene)).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let end = of(&simulation.state().unwrap().bodies);
    assert!((end.0 - start.0).length() < 1e-9 * start.0.length(), "{start:?} {end:?}");
    assert!((end.1 / start.1 - 1.0).abs() < 2e-3, "{start:?} {end:?}");
    let turned = simulation.state().unwrap().bodies.orientation[0].angle_between(DQuat::IDENTITY);
    assert!(turned > 0.5, "{turned}");
}

/// The largest extent is that of the corners, which the local drag law's length is.
#[test]
fn a_die_is_dragged_by_the_length_between_its_corners() {
    let (a, n) = (0.5, 8.0_f64);
    let die = json!({"superellipsoid": {"radii": [a, a, a], "exponents": [n, n]}});
    let scene = json!({"name": "pulled", "time": {"dt": 0.1, "end": 1.0}, "dynamics": {"overdamped": {"drag": 1.5}},
        "forces": [{"uniform": {"force": [2.0, 0, 0]}}], "bodies": [{"shape": die, "position": [0, 0, 0]}]});
    let mut simulation = Simulation::new(parse(&scene)).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    // A corner is where x = y = z: 3 (x / a)^n = 1.
    let corner = a * 3f64.sqrt() * 3f64.powf(-1.0 / n);
    let expected = 2.0 / (1.5 * 2.0 * corner);
    let moved = simulation.state().unwrap().bodies.position[0].x;
    assert!((moved - expected).abs() < 1e-12, "{moved} {expected}");
}

/// A state file keeps exponents to the bit, and only where there are any.
#[test]
fn state_files_keep_exponents() {
    let scene = json!({"name": "kept", "time": {"dt": 0.1, "end": 1.0}, "bodies": grid(2, 2.0, &dice())});
    let state = State { bodies: parse(&scene).build().unwrap(), ..State::default() };
    let bytes = encode(&state, "0123456789abcdef", 0.0, None).unwrap();
    let read = decode(&bytes).unwrap().1;
    assert_eq!(read, state);
    let exponents = |bodies: &Bodies| bodies.shape.iter().map(Shape::exponents).collect::<Vec<_>>();
    assert_eq!(exponents(&read.bodies)[..4], [Some([8.0, 8.0]), Some([2.5, 2.0]), None, Some([10.0, 3.0])]);
    let has = |bytes: &[u8]| bytes.windows(13).any(|part| part == b"exponents.npy");
    assert!(has(&bytes));
    let balls = json!({"name": "kept", "time": {"dt": 0.1, "end": 1.0}, "bodies": grid(2, 2.0, &dice()[2..3])});
    let state = State { bodies: parse(&balls).build().unwrap(), ..State::default() };
    assert!(!has(&encode(&state, "0123456789abcdef", 0.0, None).unwrap()));
}

/// A run that stops without a word after a checkpoint goes on to the bits of one that does not.
#[test]
fn a_run_that_crashed_goes_on_to_the_same_bits() {
    let inertial = json!({"dynamics": {"inertial": {"density": 1.0}}, "contact": {"friction": 0.4},
        "walls": [{"half_space": {"normal": [0, 0, 1], "offset": -2.5}}],
        "forces": [{"gravity": {"acceleration": [0, 0, -9.81]}}, {"trap": {"stiffness": 5.0, "center": [0, 0, 0]}}]});
    let midpoint = json!({"time": {"dt": 0.02, "end": 0.6, "stepping": "midpoint"}});
    for more in [json!({}), midpoint, inertial] {
        let scene = with(
            json!({"name": "crowd", "time": {"dt": 0.02, "end": 0.6}, "bodies": grid(2, 1.8, &dice()),
                "forces": inward()}),
            more,
        );
        let place = tempfile::tempdir().unwrap();
        let start = |name: &str| {
            let folder = Folder::create(&place.path().join(name)).unwrap();
            Run::start(Simulation::new(parse(&scene)).unwrap(), folder, Duration::ZERO).unwrap()
        };
        let finish = |mut run: Run| {
            while !run.done() {
                run.advance().unwrap();
            }
            let contacts = contacts(&run.simulation().state().unwrap().bodies, 1e-5).len();
            (run.finish().unwrap(), contacts)
        };
        let (whole, touching) = finish(start("whole"));
        assert!(touching >= 3, "{touching} {scene}");
        let mut run = start("broken");
        for step in 1..=21 {
            run.advance().unwrap();
            if step == 17 {
                run.checkpoint().unwrap();
            }
        }
        drop(run);
        let folder = Folder::open(&place.path().join("broken")).unwrap();
        let resumed = Run::resume(parse(&scene), folder, &Compute::Cpu).unwrap();
        assert_eq!(resumed.totals().steps, 17);
        let (resumed, _) = finish(resumed);
        assert_eq!((resumed.state_hash, resumed.recursions), (whole.state_hash, whole.recursions), "{scene}");
        let last = |name: &str| std::fs::read(place.path().join(name).join("final.json")).unwrap();
        assert_eq!(last("broken"), last("whole"));
    }
}

/// The order of a pair of equal sizes is one of its numbers, so that swapping the bodies flips the normal and changes
/// no bit.
#[test]
fn swapped_bodies_have_the_same_bits() {
    let random = &mut random(72);
    let of = |radii, exponents| Shape::Superellipsoid(relcp::shape::Superellipsoid::new(radii, exponents));
    for k in 0..200 {
        // Of the same reach and thickness.
        let shapes = [of([0.5, 0.6, 2.0], [2.0, 4.0]), of([0.5, 0.6, 2.0], [2.0, 8.0])];
        assert_eq!(shapes[0].bounding_radius(), shapes[1].bounding_radius());
        let turned = turn(random);
        let other = if k % 2 == 0 { turned } else { turn(random) };
        let away = if k % 4 < 2 { DVec3::ZERO } else { direction(random) * random.random_range(0.0..2.0) };
        let a = Placed { shape: shapes[0], position: DVec3::ONE, orientation: turned };
        let b = Placed { shape: shapes[1], position: DVec3::ONE + away, orientation: other };
        let (found, swapped) = (separation(&a, &b, None).unwrap(), separation(&b, &a, None).unwrap());
        assert_eq!(found.separation, swapped.separation, "{a:?} {b:?}");
        assert_eq!(found.normal, -swapped.normal, "{a:?} {b:?}");
        assert_eq!((found.lever_a, found.lever_b), (swapped.lever_b, swapped.lever_a), "{a:?} {b:?}");
    }
}

/// Pictures meet a superellipsoid by its gauge, and the same body by its support function by a search: the same pixels.
#[test]
fn a_picture_by_the_gauge_is_the_picture_by_the_search() {
    let random = &mut random(73);
    for (radii, exponents) in [([0.5, 0.8, 1.2], [2.5, 2.5]), ([1.0, 0.6, 0.4], [4.0, 3.0]), ([0.7; 3], [4.0; 2])] {
        let own = relcp::shape::Superellipsoid::new(radii, exponents);
        let [m1, m2] = exponents.map(|n: f64| n / (n - 1.0));
        let point = move |n: DVec3| {
            let v = DVec3::from_array(radii) * n.abs();
            let across = (v.x.powf(m2) + v.y.powf(m2)).powf(1.0 / m2);
            let whole = (across.powf(m1) + v.z.powf(m1)).powf(1.0 / m1);
            let part = |x: f64| if across > 0.0 { (x / across).powf(m2 - 1.0) } else { 0.0 };
            let out = (across / whole).powf(m1 - 1.0);
            let outward = DVec3::new(out * part(v.x), out * part(v.y), (v.z / whole).powf(m1 - 1.0));
            DVec3::from_array(radii) * outward * n.signum()
        };
        let searched = Shape::Convex(relcp::shape::Convex::new(point).unwrap());
        let poses: Vec<_> = (0..12).map(|_| (2.0 * direction(random), turn(random))).collect();
        let drawn = |shape: Shape| {
            let mut bodies = Bodies::default();
            for (position, orientation) in &poses {
                bodies.push(Placed { shape, position: *position, orientation: *orientation }, NO_GROUP);
            }
            picture(&bodies, &View { width: 120, height: 90, colour: Colour::Plain, ..View::default() })
        };
        let (gauged, searched) = (drawn(Shape::Superellipsoid(own)), drawn(searched));
        let pixels = || (0..gauged.height()).flat_map(|y| (0..gauged.width()).map(move |x| (x, y)));
        assert!(pixels().filter(|(x, y)| gauged.pixel(*x, *y) != Some([255; 3])).count() > 2000);
        let differ = |(x, y): (u32, u32)| {
            let [a, b] = [&gauged, &searched].map(|image| image.pixel(x, y).unwrap());
            a.into_iter().zip(b).any(|(a, b)| a.abs_diff(b) > 2)
        };
        // A ray that grazes a body may be a hit of one alone.
        assert!(pixels().filter(|at| differ(*at)).count() <= 2, "{radii:?} {exponents:?}");
    }
}
