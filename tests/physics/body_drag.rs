//! Drag that depends on the direction: along and across an axis, and of a viscous fluid about real shapes.

use crate::forces::everything;
use crate::scenes::{ALONG_X, agrees_on_device, parse, refusal, run};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Resistance;
use relcp::scene::{Drag, Scene};
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const KT: f64 = 0.8;
const ETA: f64 = 0.4;
/// Bodies of a sample.
const SAMPLE: usize = 700;

fn drags() -> [Value; 2] {
    [json!({"parallel": 1.0, "perpendicular": 3.0, "rotation": 2.0}), json!({"viscosity": ETA})]
}

fn shapes() -> [Value; 4] {
    [
        json!({"sphere": {"radius": 0.5}}),
        json!({"spherocylinder": {"diameter": 0.25, "length": 1}}),
        json!({"ellipsoid": {"radii": [0.2, 0.3, 0.5]}}),
        json!({"torus": {"major_radius": 0.5, "minor_radius": 0.1}}),
    ]
}

fn resistance(scene: &Scene, shape: &Shape) -> Resistance {
    scene.dynamics.any_drag().unwrap().resistance(shape)
}

fn tilted() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.7)
}

fn one(shape: &Value, law: &Value, (dt, end): (f64, f64), stepping: &str, forces: &Value) -> Value {
    let q = tilted();
    json!({"name": "slowed", "time": {"dt": dt, "end": end, "stepping": stepping}, "dynamics": law, "forces": forces,
        "bodies": [{"shape": shape, "position": [0, 0, 0], "orientation": [q.w, q.x, q.y, q.z]}]})
}

/// `F = Z u` and `T = Z_r w` by axis, in a step; and with inertia the velocity after any step from rest, which falls
/// short of that by `e^-a` along each axis.
#[test]
fn a_load_moves_a_body_by_its_resistances_along_its_axes() {
    let (force, torque, density) = (DVec3::new(0.5, 4.0, -1.0), DVec3::new(0.1, -0.2, 0.3), 2.0);
    for (shape, drag) in shapes().iter().flat_map(|shape| drags().map(|drag| (shape, drag))) {
        let back = tilted().conjugate();
        let pushed = json!([{"uniform": {"force": force.to_array()}}]);
        let turned = json!([{"torque": {"torque": torque.to_array()}}]);
        let end = |law: &Value, dt: f64, stepping: &str, forces: &Value| {
            let scene = parse(&one(shape, law, (dt, dt), stepping, forces));
            let of = scene.build().unwrap().shape[0];
            (resistance(&scene, &of), of, run(scene, &Compute::Cpu).bodies)
        };
        for stepping in ["euler", "midpoint"] {
            let law = json!({"overdamped": {"drag": drag}});
            let (of, _, bodies) = end(&law, 0.01, stepping, &pushed);
            let off = tilted() * (back * force / of.linear.axes()) - bodies.velocity[0];
            assert!(off.length() < 1e-13, "{shape} {drag} {stepping}: {off}");
            let (of, _, bodies) = end(&law, 1e-9, stepping, &turned);
            let off = tilted() * (back * torque / of.turning.axes()) - bodies.angular_velocity[0];
            assert!(off.length() < 1e-6, "{shape} {drag} {stepping}: {off}");
            for dt in [2.0, 0.1] {
                let law = json!({"inertial": {"density": density, "drag": drag}});
                let (of, shape, bodies) = end(&law, dt, stepping, &pushed);
                let fallen = of.linear.axes().map(|z| -(-dt * z / (density * shape.volume())).exp_m1());
                let off = tilted() * (fallen * (back * force) / of.linear.axes()) - bodies.velocity[0];
                assert!(off.length() < 1e-12, "{shape:?} {drag} {stepping} {dt}: {off}");
            }
        }
    }
}

/// Two rods that touch move as one: their resistances along the push add up, and so the force between them.
#[test]
fn rods_that_touch_share_a_push_by_their_resistances() {
    for (drag, inertial) in drags().into_iter().flat_map(|drag| [(drag.clone(), false), (drag, true)]) {
        let law = match inertial {
            false => json!({"overdamped": {"drag": drag}}),
            true => json!({"inertial": {"density": 1e-6, "drag": drag}}),
        };
        let of = |apart: [f64; 3], push: [f64; 3]| {
            let body = |place: [f64; 3], length: f64, group: &str| {
                json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": length}}, "position": place,
                    "orientation": ALONG_X, "group": group})
            };
            let scene = parse(&json!({"name": "pushed", "time": {"dt": 0.01, "end": 0.05}, "dynamics": law,
                "bodies": [body([0.0; 3], 2.0, "first"), body(apart, 3.0, "second")],
                "contact": {"overlap_tolerance": 1e-9}, "solver": {"tolerance": 1e-13},
                "groups": {"first": {}, "second": {}},
                "forces": [{"uniform": {"force": push, "group": "first"}}]}));
            let shapes = scene.build().unwrap().shape;
            let both: DVec3 = shapes.iter().map(|shape| resistance(&scene, shape).linear.axes()).sum();
            (both, run(scene, &Compute::Cpu).bodies)
        };
        let (both, ends) = of([2.5, 0.0, 0.0], [2.0, 0.0, 0.0]);
        for i in 0..2 {
            let off = ends.velocity[i].x * both.z / 2.0 - 1.0;
            assert!(off.abs() < 1e-6, "{drag} end to end: {off:e}");
        }
        let (both, sides) = of([0.0, 0.5, 0.0], [0.0, 2.0, 0.0]);
        for i in 0..2 {
            let off = sides.velocity[i].y * both.x / 2.0 - 1.0;
            assert!(off.abs() < 1e-6, "{drag} side by side: {off:e}");
        }
    }
}

/// How many standard errors the mean of a sample is from what it should be.
fn within_three(name: &str, sample: &[f64], expected: f64) {
    let n = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / n;
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let errors = (mean - expected) / (variance / n).sqrt();
    println!("{name}: {mean:.5}, theory {expected:.5}, {errors:+.2} standard errors of {n} samples");
    assert!(errors.abs() < 3.0, "{name}");
}

fn sample(shape: &Value, law: &Value, (dt, end): (f64, f64), planar: bool) -> Value {
    let place = |i: usize| [40.0 * (i % 30) as f64, 40.0 * (i / 30) as f64, 0.0];
    let body = |i: usize| {
        let mut body = json!({"shape": shape, "position": place(i)});
        if planar {
            body["angle"] = json!(3 * i);
        }
        body
    };
    json!({"name": "hot", "seed": shape.to_string().len(), "planar": planar, "time": {"dt": dt, "end": end}, "dynamics": law,
        "thermal": {"temperature": KT}, "bodies": (0..SAMPLE).map(body).collect::<Vec<_>>()})
}

/// Displacements along the axis that a rod starts with, and across it: `2 D t` with `D` by direction at first, and
/// later less apart as it turns (Y. Han and others, Science 314, 626 (2006)); `<(u . u_0)^2> = 1/3 + 2/3 e^(-6 D_r t)`,
/// in the plane `1/2 + 1/2 e^(-4 D_r t)`.
#[test]
fn brownian_rods_diffuse_along_and_across_their_axis_as_theory_says() {
    let shape = &shapes()[1];
    for (drag, planar) in drags().into_iter().flat_map(|drag| [(drag.clone(), false), (drag, true)]) {
        let law = json!({"overdamped": {"drag": drag}});
        let one = parse(&sample(shape, &law, (1.0, 1.0), planar));
        let of = resistance(&one, &one.build().unwrap().shape[0]);
        let turning = KT / of.turning.axes().x;
        for turns in [0.01, 1.0] {
            let end = turns / turning;
            let dt = if turns < 0.1 { end } else { end / 400.0 };
            let scene = parse(&sample(shape, &law, (dt, end), planar));
            let (start, bodies) = (scene.build().unwrap(), run(scene, &Compute::Cpu).bodies);
            let [across, along] = [of.linear.axes().x, of.linear.axes().z].map(|z| KT / z);
            let (share, rate) = if planar { (0.5, 4.0) } else { (1.0 / 3.0, 6.0) };
            let kept = if turns < 0.1 { end } else { (1.0 - (-rate * turning * end).exp()) / (rate * turning) };
            let first = share * end + (1.0 - share) * kept;
            let second = if planar { 0.5 * (end - kept) } else { (end - kept) / 3.0 };
            let squares = |axis: DVec3| -> Vec<f64> {
                let way = |i: usize| (bodies.position[i] - start.position[i]).dot(start.orientation[i] * axis);
                (0..start.len()).map(|i| way(i).powi(2)).collect()
            };
            let name = format!("{drag}, planar {planar}, after D_r t = {turns}");
            let of_axis = |part: f64| 2.0 * (across * end + (along - across) * part);
            within_three(&format!("{name}, along"), &squares(DVec3::Z), of_axis(first));
            // In the plane y of the body is across it.
            let aside = if planar && (start.orientation[0] * DVec3::Y).z.abs() > 0.5 { DVec3::X } else { DVec3::Y };
            within_three(&format!("{name}, across"), &squares(aside), of_axis(second));
            if !planar {
                within_three(&format!("{name}, across, too"), &squares(DVec3::X), of_axis(second));
            }
        }
    }
}

/// Perrin's tensor: `2 kT dt / zeta` along each axis of an ellipsoid of three radii, and of its turns about each.
#[test]
fn a_brownian_ellipsoid_has_perrins_tensor() {
    let law = json!({"overdamped": {"drag": {"viscosity": ETA}}});
    let scene = parse(&sample(&shapes()[2], &law, (1e-4, 1e-4), false));
    let (start, of) = (scene.build().unwrap(), resistance(&scene, &scene.build().unwrap().shape[0]));
    let bodies = run(scene, &Compute::Cpu).bodies;
    for (axis, at) in [(DVec3::X, 0), (DVec3::Y, 1), (DVec3::Z, 2)] {
        let ways: Vec<f64> = (0..SAMPLE).map(|i| (bodies.position[i] - start.position[i]).dot(axis).powi(2)).collect();
        within_three(&format!("along {axis}"), &ways, 2.0 * KT * 1e-4 / of.linear.axes()[at]);
        let turns: Vec<f64> = (0..SAMPLE).map(|i| (bodies.angular_velocity[i].dot(axis) * 1e-4).powi(2)).collect();
        within_three(&format!("about {axis}"), &turns, 2.0 * KT * 1e-4 / of.turning.axes()[at]);
    }
}

/// A rod is held by a spring at one end, so that its place and its turn are bound to each other: the end is spread as
/// `kT / k` in all directions, along the rod as across it, whatever the mobility. A drift that is missing or too much
/// would show along the rod.
#[test]
fn a_rod_that_is_held_at_its_end_has_the_spread_of_equilibrium() {
    let stiffness = 40.0;
    for (drag, planar) in drags().into_iter().flat_map(|drag| [(drag.clone(), false), (drag, true)]) {
        let law = json!({"overdamped": {"drag": drag}});
        let count = 300;
        let mut of = sample(&shapes()[1], &law, (4e-4, 0.4), planar);
        let rods: Vec<Value> = of["bodies"].as_array().unwrap()[..count].to_vec();
        let anchor =
            |rod: &Value| json!({"shape": {"sphere": {"radius": 0.01}}, "position": rod["position"], "fixed": true});
        let anchors: Vec<Value> = rods.iter().map(anchor).collect();
        let bond = |i: usize| {
            json!({"bodies": [i, count + i], "at": [[0, 0, 0.5], [0, 0, 0]], "stiffness": stiffness,
                "contact": false, "implicit": false})
        };
        of["bodies"] = json!(rods.into_iter().chain(anchors).collect::<Vec<_>>());
        of["bonds"] = json!((0..count).map(bond).collect::<Vec<_>>());
        let mut simulation = Simulation::new(parse(&of)).unwrap();
        let (mut along, mut across) = (Vec::new(), Vec::new());
        let mut taken = 0;
        while !simulation.done() {
            simulation.step().unwrap();
            taken += 1;
            if taken > 400 && taken % 300 == 0 {
                let bodies: &Bodies = &simulation.state().unwrap().bodies;
                for i in 0..count {
                    let axis = bodies.orientation[i] * DVec3::Z;
                    let end = bodies.position[i] + 0.5 * axis - bodies.position[count + i];
                    along.push(end.dot(axis).powi(2));
                    let aside = end - axis * end.dot(axis);
                    across.push(aside.length_squared() / if planar { 1.0 } else { 2.0 });
                }
            }
        }
        within_three(&format!("{drag}, planar {planar}: along"), &along, KT / stiffness);
        within_three(&format!("{drag}, planar {planar}: across"), &across, KT / stiffness);
    }
}

/// The time of one turn in the plane of a shear flow, `2 pi (r + 1/r) / g`.
fn period(shape: &Value, aspect: f64, rate: f64) -> f64 {
    let dt = 0.01 / rate;
    let of = json!({"name": "tumbling", "planar": true, "time": {"dt": dt, "end": 1.2 * TAU * (aspect + 1.0 / aspect) / rate, "stepping": "midpoint"},
        "dynamics": {"overdamped": {"drag": {"viscosity": ETA}}},
        "flow": {"shear": {"rate": rate, "direction": [1, 0, 0], "gradient": [0, 1, 0]}},
        "bodies": [{"shape": shape, "position": [0, 0, 0], "orientation": ALONG_X}]});
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    let (mut turned, mut last, mut steps) = (0.0_f64, 0.0, 0.0);
    while !simulation.done() {
        simulation.step().unwrap();
        let axis = simulation.state().unwrap().bodies.orientation[0] * DVec3::Z;
        let now = axis.y.atan2(axis.x);
        let turn = now - last - TAU * ((now - last) / TAU).round();
        if turned + turn <= -TAU {
            return dt * (steps + (-TAU - turned) / turn);
        }
        (turned, last, steps) = (turned + turn, now, steps + 1.0);
    }
    f64::NAN
}

#[test]
fn bodies_tumble_at_their_finite_aspect() {
    let rate = 1.5;
    for aspect in [1.0, 2.0, 5.0, 20.0] {
        let ellipsoid = json!({"ellipsoid": {"radii": [1, 1, aspect]}});
        let off = period(&ellipsoid, aspect, rate) * rate / (TAU * (aspect + 1.0 / aspect)) - 1.0;
        assert!(off.abs() < 1e-3, "spheroid of {aspect}: {off:e}");
        let rod = Shape::Spherocylinder { diameter: 1.0, length: aspect };
        let constant = Drag::Viscosity(ETA).bretherton(&rod).unwrap().y;
        let real = ((1.0 + constant) / (1.0 - constant)).sqrt();
        let shape = json!({"spherocylinder": {"diameter": 1, "length": aspect}});
        let off = period(&shape, aspect, rate) * rate / (TAU * (real + 1.0 / real)) - 1.0;
        println!("a rod of aspect {aspect} turns as a spheroid of {real:.3}");
        assert!(off.abs() < 1e-3, "rod of {aspect}: {off:e}");
        assert!((0.7 * aspect..=aspect).contains(&real), "rod of {aspect}: {real}");
    }
}

/// Cells grow while drag holds them: one of the final length has its final resistance.
#[test]
fn a_cell_that_grows_has_the_drag_of_its_length() {
    for (drag, inertial) in drags().into_iter().flat_map(|drag| [(drag.clone(), false), (drag, true)]) {
        let law = match inertial {
            false => json!({"overdamped": {"drag": drag}}),
            true => json!({"inertial": {"density": 1e-6, "drag": drag}}),
        };
        let of = json!({"name": "growing", "time": {"dt": 0.01, "end": 1}, "dynamics": law,
            "growth": {"rate": 0.5, "division_length": 4},
            "forces": [{"propulsion": {"force": 1.0}}],
            "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 1}}, "position": [0, 0, 0]}]});
        let scene = parse(&of);
        let bodies = run(scene.clone(), &Compute::Cpu).bodies;
        assert!(bodies.shape[0].major_axis() > 1.2, "{:?}", bodies.shape[0]);
        let along = resistance(&scene, &bodies.shape[0]).linear.axes().z;
        let off = bodies.velocity[0].z * along - 1.0;
        assert!(off.abs() < if inertial { 1e-5 } else { 1e-12 }, "{drag}, inertial {inertial}: {off:e}");
    }
}

#[test]
fn drag_by_axes_on_a_device_is_the_cpus() {
    let [axes, fluid] = drags();
    for (drag, planar, stepping) in [(&axes, false, "euler"), (&axes, true, "midpoint"), (&fluid, false, "midpoint")] {
        for law in [json!({"overdamped": {"drag": drag}}), json!({"inertial": {"density": 1.5, "drag": drag}})] {
            let scene = parse(&everything(planar, &law, stepping, false));
            agrees_on_device(&scene, &format!("{law}, planar {planar}, {stepping}"), [5e-4, 1e-9]);
        }
    }
}

/// Every shape on a device: heat and a flow, the poses and velocities of bodies apart and touching.
#[test]
fn every_shape_has_its_drag_on_a_device() {
    for (drag, inertial) in drags().into_iter().flat_map(|drag| [(drag.clone(), false), (drag, true)]) {
        let law = match inertial {
            false => json!({"overdamped": {"drag": drag}}),
            true => json!({"inertial": {"density": 1.5, "drag": drag}}),
        };
        let [first, second] = [tilted(), tilted() * tilted()].map(|q| json!([q.w, q.x, q.y, q.z]));
        let more = [
            json!({"ellipsoid": {"radii": [0.3, 0.3, 0.01]}}),
            json!({"ellipsoid": {"radii": [0.02, 0.02, 2.0]}}),
            json!({"spherocylinder": {"diameter": 0.04, "length": 4}}),
            json!({"spherocylinder": {"diameter": 0.5, "length": 0.5}}),
            json!({"torus": {"major_radius": 0.5, "minor_radius": 0.45}}),
            json!({"torus": {"major_radius": 2, "minor_radius": 0.004}}),
        ];
        let body = |(i, shape): (usize, &Value)| json!({"shape": shape, "position": [8.0 * i as f64, 0.4, 0.1], "orientation": if i % 2 == 0 { &first } else { &second }});
        let all = shapes();
        let bodies: Vec<Value> = all.iter().chain(&more).enumerate().map(body).collect();
        let of = json!({"name": "all", "time": {"dt": 0.002, "end": 0.02}, "dynamics": law, "bodies": bodies,
            "thermal": {"temperature": 0.01},
            "flow": {"shear": {"rate": 0.5, "direction": [0, 1, 0], "gradient": [0, 0, 1]}}});
        agrees_on_device(&parse(&of), &format!("all shapes, {law}"), [2e-4, 1e-10]);
    }
}

/// A cell whose lengths change carries bodies by their resistances, and growing cells on a device have them.
#[test]
fn cells_and_strain_on_a_device_have_the_drag_of_the_cpu() {
    for drag in drags() {
        let law = json!({"overdamped": {"drag": drag}});
        let rod = |place: [f64; 3]| json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": place, "orientation": ALONG_X});
        let rods: Vec<Value> = (0..4).map(|i| rod([0.2 * f64::from(i), 0.55 * f64::from(i) - 1.0, 0.0])).collect();
        let growing = json!({"name": "growing", "planar": true, "time": {"dt": 0.02, "end": 0.6}, "dynamics": law,
            "bodies": rods, "growth": {"rate": 0.8, "division_length": 2}});
        agrees_on_device(&parse(&growing), &format!("growing, {drag}"), [2e-3, 1e-6]);
        let strained = json!({"name": "strained", "time": {"dt": 0.01, "end": 0.1}, "dynamics": law, "bodies": rods,
            "periodic": {"lengths": [8, 8, 8], "strain_rate": [0.5, -0.3, 0.0]}});
        agrees_on_device(&parse(&strained), &format!("strained, {drag}"), [5e-4, 1e-9]);
    }
}

#[test]
fn a_sphere_in_a_fluid_has_stokes_drag() {
    let ball = Drag::Viscosity(ETA).resistance(&Shape::Sphere { radius: 0.5 });
    for (name, shape) in [
        ("rod", Shape::Spherocylinder { diameter: 1.0, length: 1.0 }),
        ("ellipsoid", Shape::Ellipsoid { radii: [0.5; 3] }),
    ] {
        let of = Drag::Viscosity(ETA).resistance(&shape);
        assert!((of.linear.axes() - 6.0 * PI * ETA * 0.5).length() < 1e-14, "{name}");
        assert!((of.turning.axes() - 8.0 * PI * ETA * 0.125).length() < 1e-14, "{name}");
        assert!((of.linear.axes() - ball.linear.axes()).length() < 1e-14, "{name}");
    }
    // A rod that is hardly longer is hardly another body.
    let of = Drag::Viscosity(ETA).resistance(&Shape::Spherocylinder { diameter: 1.0, length: 1.0 + 1e-9 });
    assert!((of.linear.axes() - ball.linear.axes()).length() < 1e-7 && of.turning.axes().is_finite());
}

#[test]
fn what_is_no_drag_is_refused() {
    let of = |drag: Value| {
        json!({"name": "slowed", "time": {"dt": 0.05, "end": 1}, "dynamics": {"overdamped": {"drag": drag}},
            "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}]})
    };
    for (drag, key, words) in [
        (json!({"viscosity": 0}), "dynamics.overdamped.drag.viscosity", "must be positive"),
        (json!({"parallel": -1, "perpendicular": 1}), "dynamics.overdamped.drag.parallel", "must be positive"),
        (
            json!({"parallel": 1, "perpendicular": 1, "rotation": 0}),
            "dynamics.overdamped.drag.rotation",
            "must be positive",
        ),
        (json!({"parallel": 1}), "dynamics.overdamped.drag", "`perpendicular`"),
        (json!({"viscosity": 1, "parallel": 1}), "dynamics.overdamped.drag", "omit the other keys"),
        (json!({"viscous": 1}), "dynamics.overdamped.drag.viscous", "viscosity"),
        (json!("thick"), "dynamics.overdamped.drag", "a number, or an object"),
    ] {
        let (at, message) = refusal(&of(drag.clone()));
        assert!(at == key && message.contains(words), "{drag}: {at}: {message}");
    }
    let written = parse(&of(json!({"parallel": 1, "perpendicular": 2}))).to_json();
    assert!(written.contains("\"rotation\": 2.0"), "{written}");
}
