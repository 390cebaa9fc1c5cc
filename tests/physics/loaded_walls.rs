//! Walls under a load: a piston on a column against the sum of its weights, its fall against closed forms, pressure
//! against the stress measure, and resumed runs.

use crate::scenes::{ALONG_X, in_two_parts, parse, refusal, run};
use relcp::bodies::WallState;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

fn piston(offset: f64, load: Value) -> Value {
    json!({"half_space": {"normal": [0, 0, -1], "offset": offset, "load": load}})
}

fn floor() -> Value {
    json!({"half_space": {"normal": [0, 0, 1], "offset": 0}})
}

fn scene(more: Value, dt: f64, end: f64) -> Value {
    let mut of = json!({"name": "pressed", "time": {"dt": dt, "end": end}, "dynamics": {"overdamped": {"drag": 1}},
        "contact": {"overlap_tolerance": 1e-8}});
    for (key, value) in more.as_object().unwrap() {
        of[key] = value.clone();
    }
    of
}

fn ball(position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": position})
}

fn wall(of: &Value) -> WallState {
    run(parse(of), &Compute::Cpu).bodies.walls[0]
}

/// `F t / c`, and `v_0 t + F t^2 / 2m` but for the part of the first order that Euler's step has.
#[test]
fn a_wall_that_nothing_stops_moves_by_its_load() {
    let far = json!([ball([0.0, 0.0, 0.5])]);
    let of = |load: Value| scene(json!({"walls": [floor(), piston(-50.0, load)], "bodies": far}), 0.01, 1.0);
    let dragged = wall(&of(json!({"force": 3, "drag": 2})));
    assert!((dragged.shift - 1.5).abs() < 1e-12 && (dragged.velocity - 1.5).abs() < 1e-12, "{dragged:?}");
    let heavy = wall(&of(json!({"force": 3, "mass": 2, "velocity": -1})));
    assert!((heavy.shift - (-1.0 + 0.75 * 1.01)).abs() < 1e-12 && (heavy.velocity - 0.5).abs() < 1e-12, "{heavy:?}");
    let upwards = wall(&of(json!({"force": -3, "drag": 2})));
    assert!((upwards.shift + 1.5).abs() < 1e-12, "{upwards:?}");
}

/// Balls in a column under their weight and a piston: at rest each contact bears the piston's load and all weights
/// above it, the floor all of it, and the piston stands on the column. On its way it pushes a column that does not
/// reach the floor against all of its drags.
#[test]
fn a_piston_on_a_column_bears_on_it_with_its_load() {
    let (load, weight) = (5.0, 2.0);
    let column = |bottom: f64| -> Value { (0..4).map(|i| ball([0.0, 0.0, bottom + 0.5 + f64::from(i)])).collect() };
    let push = json!([{"uniform": {"force": [0, 0, -weight]}}]);
    for resistance in ["drag", "mass"] {
        let mut given = json!({"force": load});
        given[resistance] = json!(1.5);
        let of =
            scene(json!({"walls": [floor(), piston(-4.3, given)], "bodies": column(0.0), "forces": push}), 0.02, 6.0);
        let mut simulation = Simulation::new(parse(&of)).unwrap();
        while !simulation.done() {
            simulation.step().unwrap();
        }
        let state = simulation.state().unwrap();
        let at = state.bodies.walls[0];
        assert!((at.shift - 0.3).abs() < 1e-6 && at.velocity.abs() < 1e-6, "{resistance}: {at:?}");
        let mut forces: Vec<f64> = state.warm.iter().map(|warm| warm.gamma).filter(|gamma| *gamma > 0.0).collect();
        forces.sort_by(f64::total_cmp);
        let expected: Vec<f64> = (0..5).map(|above| load + f64::from(above) * weight).collect();
        let off = forces.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(forces.len() == 5 && off < 1e-6, "{resistance}: {forces:?}");
        println!("{resistance}: forces off by {off:.1e}");
    }
    // Four balls of drag 1 each and the wall's 1.5, pushed by the load alone.
    let given = json!({"force": load, "drag": 1.5});
    let of = scene(json!({"walls": [piston(-4.0, given)], "bodies": column(0.0)}), 0.02, 0.2);
    let at = wall(&of);
    assert!((at.velocity - load / 5.5).abs() < 1e-7, "{at:?}");
}

/// A plane that presses on balls in a periodic plane: what they bear over its length is the pressure, as is the stress
/// in the column.
#[test]
fn a_pressure_is_what_the_packing_bears() {
    let rods: Value = (0..6)
        .map(|i| {
            json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.5}},
                "position": [2.0 * f64::from(i % 2) + 0.3 * f64::from(i / 2), 0.3 + 0.6 * f64::from(i / 2), 0.0], "orientation": ALONG_X})
        })
        .collect();
    let of = scene(
        json!({"planar": true, "periodic": {"lengths": [4, null, null]}, "bodies": rods,
            "walls": [{"half_space": {"normal": [0, 1, 0], "offset": 0}},
                {"half_space": {"normal": [0, -1, 0], "offset": -2.5, "load": {"pressure": 0.7, "drag": 2}}}]}),
        0.02,
        8.0,
    );
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let state = simulation.state().unwrap();
    let walls = simulation.walls();
    let at_walls = |surface: u32| -> f64 {
        let of = |pair: [u32; 2]| pair[1] == relcp::walls::number_of(surface as usize);
        state.warm.iter().filter(|warm| of(warm.pair)).map(|warm| warm.gamma).sum()
    };
    let (low, high) = (at_walls(0), at_walls(1));
    println!("{low} {high}, {:?}", state.bodies.walls);
    assert!((high / 4.0 - 0.7).abs() < 1e-6 && (low / 4.0 - 0.7).abs() < 1e-6, "{low} {high}");
    assert!(walls.max_overlap(&state.bodies) < 1e-7);
}

/// Two thirds up, stopped, read from its own state, and to the end: the same bits, walls too.
#[test]
fn a_run_goes_on_to_the_same_bits() {
    for (resistance, law) in
        [("drag", json!({"overdamped": {"drag": 1}})), ("mass", json!({"inertial": {"density": 1}}))]
    {
        let mut load = json!({"force": 4});
        load[resistance] = json!(2);
        let balls: Value = (0..5).map(|i| ball([0.3 * f64::from(i % 2), 0.0, 0.6 + 1.1 * f64::from(i)])).collect();
        let of = scene(
            json!({"dynamics": law, "bodies": balls, "contact": {"overlap_tolerance": 1e-5},
                "walls": [{"box": {"minimum": [-1, -1, 0], "maximum": [1, 1, 9]}}, piston(-6.2, load)]}),
            0.01,
            0.6,
        );
        let scene: Scene = parse(&of);
        let whole = run(scene.clone(), &Compute::Cpu);
        assert!(whole.bodies.walls[0].shift > 0.1, "{:?}", whole.bodies.walls);
        assert!(in_two_parts(&scene, &Compute::Cpu) == whole, "{resistance}");
        // What it leaves stands where it stands.
        let mut simulation = Simulation::new(scene.clone()).unwrap();
        while !simulation.done() {
            simulation.step().unwrap();
        }
        let left = Scene::parse(&simulation.final_scene().unwrap().to_json(), "left").unwrap();
        assert!(left.walls().surfaces() == simulation.walls().surfaces(), "{resistance}");
    }
}

#[test]
fn what_is_no_load_is_refused() {
    let of = |load: Value| {
        scene(json!({"walls": [floor(), piston(-5.0, load)], "bodies": [ball([0.0, 0.0, 1.0])]}), 0.1, 1.0)
    };
    for (load, key, words) in [
        (json!({"drag": 1}), "load", "needs `force` or `pressure`"),
        (json!({"force": 1}), "load", "needs `drag` or `mass`"),
        (json!({"force": 1, "pressure": 1, "drag": 1}), "load.pressure", "omit one"),
        (json!({"force": 1, "mass": 1, "drag": 1}), "load.mass", "omit one"),
        (json!({"force": 1, "mass": 0}), "load.mass", "must be positive"),
        (json!({"force": 1, "drag": 1, "velocity": 1}), "load.velocity", "needs `mass`"),
        (json!({"pressure": 1, "drag": 1}), "load.pressure", "constant area"),
    ] {
        let (at, message) = refusal(&of(load.clone()));
        assert!(at == format!("walls.1.half_space.{key}") && message.contains(words), "{load}: {at}: {message}");
    }
    let mut moved = of(json!({"force": 1, "drag": 1}));
    moved["walls"][1]["half_space"]["motion"] = json!({"velocity": [0, 0, 1]});
    let (at, message) = refusal(&moved);
    assert!(at == "walls.1.half_space.motion.velocity" && message.contains("along the wall"), "{at}: {message}");
    let mut midpoint = of(json!({"force": 1, "drag": 1}));
    midpoint["time"]["stepping"] = json!("midpoint");
    assert!(refusal(&midpoint).1.contains("needs Euler steps"));
}

/// A scene without loads has no state of walls, and its text none of the key.
#[test]
fn other_scenes_are_as_they_were() {
    let of = scene(json!({"walls": [floor()], "bodies": [ball([0.0, 0.0, 1.0])]}), 0.1, 1.0);
    let written = parse(&of).to_json();
    assert!(!written.contains("load"), "{written}");
    assert!(run(parse(&of), &Compute::Cpu).bodies.walls.is_empty());
}

/// A wall over a moving crowd: in each step its momentum, or its drag, is what the load and all contacts together make.
#[test]
fn the_momentum_of_a_loaded_wall_is_balanced_in_each_step() {
    let (dt, force, own) = (0.01, 6.0, 4.0);
    for (resistance, law) in
        [("drag", json!({"overdamped": {"drag": 1}})), ("mass", json!({"inertial": {"density": 1, "drag": 0.5}}))]
    {
        let mut load = json!({"force": force});
        load[resistance] = json!(own);
        let of = scene(
            json!({"dynamics": law, "contact": {"overlap_tolerance": 1e-6}, "solver": {"tolerance": 1e-11},
                "walls": [{"box": {"minimum": [-2.5, -2.5, 0], "maximum": [2.5, 2.5, 9]}}, piston(-7.0, load)],
                "generate": [{"isotropic": {"count": 20, "shape": {"ellipsoid": {"radii": [0.5, 0.5, 0.8]}}}}]}),
            dt,
            3.0,
        );
        let mut simulation = Simulation::new(parse(&of)).unwrap();
        let (mut before, mut worst, mut borne) = (0.0, 0.0_f64, 0.0_f64);
        while !simulation.done() {
            let report = simulation.step().unwrap();
            let state = simulation.state().unwrap();
            let velocity = state.bodies.walls[0].velocity;
            let number = relcp::walls::number_of(6);
            let contact: f64 = state.warm.iter().filter(|warm| warm.pair[1] == number).map(|warm| warm.gamma).sum();
            let left = if resistance == "mass" { own * (velocity - before) / dt } else { own * velocity };
            assert_eq!(report.pieces, 1, "step {}", report.step);
            worst = worst.max((left - (force - contact)).abs() / force);
            (before, borne) = (velocity, borne.max(contact));
        }
        println!("{resistance}: within {worst:.1e}, contacts bore up to {borne:.2}");
        assert!(worst < 1e-8 && borne > 0.5 * force, "{resistance}: {worst:e} {borne}");
    }
}
