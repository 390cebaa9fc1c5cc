//! Brownian motion against theory: each figure within three standard errors, from one seed.

use crate::device::{device, precisions};
use crate::scenes::{agrees_on_device, parse, refusal, run};
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

const KT: f64 = 0.8;
const DRAG: f64 = 1.5;
/// Bodies of a sample.
const SAMPLE: usize = 700;

fn shapes() -> [Value; 3] {
    [
        json!({"sphere": {"radius": 0.5}}),
        json!({"spherocylinder": {"diameter": 0.25, "length": 1}}),
        json!({"ellipsoid": {"radii": [0.2, 0.3, 0.5]}}),
    ]
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": DRAG}})
}

/// Bodies too far from each other to meet.
fn apart(shape: &Value, law: &Value, (dt, end): (f64, f64), planar: bool) -> Value {
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

/// How many standard errors the mean of a sample is from what it should be.
fn errors(name: &str, sample: &[f64], expected: f64) -> f64 {
    let n = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / n;
    let variance = sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let errors = (mean - expected) / (variance / n).sqrt();
    println!("{name}: {mean:.5}, theory {expected:.5}, {errors:+.2} standard errors of {n} samples");
    errors
}

fn within_three(name: &str, sample: &[f64], expected: f64) {
    assert!(errors(name, sample, expected).abs() < 3.0, "{name}");
}

fn moves(start: &Bodies, end: &Bodies) -> Vec<DVec3> {
    (0..start.len()).map(|i| end.position[i] - start.position[i]).collect()
}

#[test]
fn overdamped_bodies_diffuse_and_turn_as_theory_says() {
    for (shape, planar) in shapes().iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        let scene = parse(&apart(shape, &overdamped(), (0.002, 0.04), planar));
        let start = scene.build().unwrap();
        let end = run(scene, &Compute::Cpu).bodies;
        let (length, axes) = (start.shape[0].major_axis(), if planar { 2 } else { 3 });
        let name = format!("{}, planar {planar}", start.shape[0].name());
        let along: Vec<f64> = moves(&start, &end).iter().flat_map(|way| way.to_array()[..axes].to_vec()).collect();
        let squares: Vec<f64> = along.iter().map(|x| x * x).collect();
        within_three(&format!("{name}: mean square of a move"), &squares, 2.0 * KT / (DRAG * length) * 0.04);
        within_three(&format!("{name}: mean of a move"), &along, 0.0);
        if planar {
            assert!(end.position.iter().all(|x| x.z == 0.0));
        }
        // The cosine of the turn of an axis falls as exp(-2 D t), in the plane as exp(-D t).
        let turning = 12.0 * KT / (DRAG * length.powi(3));
        let cosine = |i: usize| (start.orientation[i] * DVec3::Z).dot(end.orientation[i] * DVec3::Z);
        let cosines: Vec<f64> = (0..start.len()).map(cosine).collect();
        within_three(&format!("{name}: cosine of a turn"), &cosines, (-(axes as f64 - 1.0) * turning * 0.04).exp());
    }
}

/// `<x^2> = 2 D (t - 2 tau (1 - e^(-t / tau)) + tau / 2 (1 - e^(-2 t / tau)))` along each axis from rest, with `tau = m
/// / (xi L)` (G. E. Uhlenbeck, L. S. Ornstein, Phys. Rev. 36, 823 (1930)); likewise the angle about the axis of a
/// plane.
#[test]
fn bodies_with_inertia_diffuse_as_langevins_equation_says() {
    let law = json!({"inertial": {"density": 2.0, "drag": DRAG}});
    for (shape, planar) in shapes().iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        let one = parse(&apart(shape, &law, (1.0, 1.0), planar)).build().unwrap().shape[0];
        let (length, mass) = (one.major_axis(), 2.0 * one.volume());
        let tau = mass / (DRAG * length);
        let start = parse(&apart(shape, &law, (tau / 20.0, 4.0 * tau), planar));
        let (before, end) = (start.build().unwrap(), run(start, &Compute::Cpu).bodies);
        let of =
            |t: f64, tau: f64| t - 2.0 * tau * (1.0 - (-t / tau).exp()) + 0.5 * tau * (1.0 - (-2.0 * t / tau).exp());
        let axes = if planar { 2 } else { 3 };
        let squares: Vec<f64> =
            moves(&before, &end).iter().flat_map(|way| (*way * *way).to_array()[..axes].to_vec()).collect();
        let name = format!("{}, planar {planar}", one.name());
        within_three(
            &format!("{name}: mean square of a move"),
            &squares,
            2.0 * KT / (DRAG * length) * of(4.0 * tau, tau),
        );
        if planar {
            // About the body's x, which is across the plane; the cosine of an angle whose distribution is Gauss'.
            let turning = DRAG * length.powi(3) / 12.0;
            let slowing = 2.0 * one.unit_inertia().x / turning;
            let cosine = |i: usize| (before.orientation[i] * DVec3::Z).dot(end.orientation[i] * DVec3::Z);
            let cosines: Vec<f64> = (0..before.len()).map(cosine).collect();
            let expected = (-KT / turning * of(4.0 * tau, slowing)).exp();
            within_three(&format!("{name}: cosine of a turn"), &cosines, expected);
        }
    }
}

/// In space the cosine of the turn of an axis falls as `exp(-2 D_r t)` where drag stops turning long before a body has
/// turned, with the time less what starting from rest takes off about the two axes across it: `D_r tau` is 0.015 about
/// the slowest axis, and what inertia does beyond that is of its order. A step is half of the time in which the fastest
/// motion, of a rod that about its own axis, is stopped.
#[test]
fn bodies_with_inertia_turn_in_space_as_langevins_equation_says() {
    let (slow, decay) = (0.015, 0.6);
    for shape in &shapes() {
        let unit = json!({"inertial": {"density": 1, "drag": DRAG}});
        let one = parse(&apart(shape, &unit, (1.0, 1.0), false)).build().unwrap().shape[0];
        let resistance = DRAG * one.major_axis().powi(3) / 12.0;
        let turning = KT / resistance;
        let density = slow / turning * resistance / one.unit_inertia().max_element();
        let (law, slowing) =
            (json!({"inertial": {"density": density, "drag": DRAG}}), density * one.unit_inertia() / resistance);
        let end = decay / (2.0 * turning);
        let steps = (2.0 * end / slowing.min_element()).ceil();
        let scene = parse(&apart(shape, &law, (end / steps, end), false));
        let (start, bodies) = (scene.build().unwrap(), run(scene, &Compute::Cpu).bodies);
        let of = |tau: f64| end - 2.0 * tau * (1.0 - (-end / tau).exp()) + 0.5 * tau * (1.0 - (-2.0 * end / tau).exp());
        for (axis, [one, other]) in [(DVec3::X, [1, 2]), (DVec3::Y, [2, 0]), (DVec3::Z, [0, 1])] {
            let cosine = |i: usize| (start.orientation[i] * axis).dot(bodies.orientation[i] * axis);
            let cosines: Vec<f64> = (0..start.len()).map(cosine).collect();
            let expected = (-turning * (of(slowing[one]) + of(slowing[other]))).exp();
            let name = format!("{}: cosine of the turn of {axis} with inertia in space", start.shape[0].name());
            within_three(&name, &cosines, expected);
        }
    }
}

/// Along z alone, so that bodies of one trap do not meet. The scheme's own variance is `kT / k / (1 - a / 2)`, `a = k
/// dt / (xi L)`.
#[test]
fn a_trapped_body_has_the_variance_of_equilibrium() {
    let (stiffness, dt) = (6.0, 0.02);
    let mut of = apart(&shapes()[0], &overdamped(), (dt, 1.6), false);
    of["forces"] = json!([{"trap": {"stiffness": stiffness, "center": [0, 0, 0], "axes": [false, false, true]}}]);
    let end = run(parse(&of), &Compute::Cpu).bodies;
    let squares: Vec<f64> = end.position.iter().map(|x| x.z * x.z).collect();
    let of_scheme = KT / stiffness / (1.0 - 0.5 * stiffness * dt / DRAG);
    within_three("variance in a trap", &squares, of_scheme);
    within_three("the same without what the step adds", &squares, KT / stiffness);
}

#[test]
fn bodies_with_inertia_have_the_energy_of_equilibrium_in_every_direction() {
    let law = json!({"inertial": {"density": 2.0, "drag": DRAG}});
    for (shape, planar) in shapes().iter().flat_map(|shape| [(shape, false), (shape, true)]) {
        // A step is a third of the time in which drag stops the slowest motion, the run 10 of them and more.
        let of = |bodies: &Bodies| 2.0 * bodies.shape[0].volume() / (DRAG * bodies.shape[0].major_axis());
        let slow = of(&parse(&apart(shape, &law, (1.0, 1.0), planar)).build().unwrap());
        let end = run(parse(&apart(shape, &law, (slow / 3.0, 4.0 * slow), planar)), &Compute::Cpu).bodies;
        let (mass, moments) = (2.0 * end.shape[0].volume(), 2.0 * end.shape[0].unit_inertia());
        let (name, axes) = (format!("{}, planar {planar}", end.shape[0].name()), if planar { 2 } else { 3 });
        let squares: Vec<f64> = end
            .velocity
            .iter()
            .flat_map(|u| (*u * *u).to_array()[..axes].to_vec())
            .map(|square| square * mass)
            .collect();
        // From rest, of which the run keeps exp(-8).
        within_three(&format!("{name}: m u^2"), &squares, KT * (1.0 - f64::exp(-8.0)));
        let spins: Vec<DVec3> =
            (0..end.len()).map(|i| end.orientation[i].inverse() * end.angular_velocity[i]).collect();
        if planar {
            // The body's x is across the plane.
            let squares: Vec<f64> = spins.iter().map(|w| moments.x * w.length_squared()).collect();
            within_three(&format!("{name}: I w^2"), &squares, KT);
            continue;
        }
        for axis in 0..3 {
            let squares: Vec<f64> = spins.iter().map(|w| moments[axis] * w[axis] * w[axis]).collect();
            within_three(&format!("{name}: I w^2 about axis {axis}"), &squares, KT);
        }
    }
}

/// Hot rods, cells that grow, and a fixed ball, in a box.
fn crowd(planar: bool, law: &Value, growing: bool) -> Value {
    let rod = |i: usize| {
        let z = if planar { 0.0 } else { 0.9 * (i / 6) as f64 - 0.9 };
        let y = if planar { 0.8 * (i / 3) as f64 - 1.6 } else { 0.9 * (i / 3 % 2) as f64 };
        json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [1.5 * (i % 3) as f64 - 1.5, y, z], "axis": [1, 0, 0]})
    };
    let mut bodies: Vec<Value> = (0..15).map(rod).collect();
    bodies.push(json!({"shape": {"sphere": {"radius": 0.3}}, "position": [0, 2.4, 0], "fixed": true}));
    let mut of = json!({"name": "hot crowd", "seed": 9, "planar": planar, "time": {"dt": 0.01, "end": 0.3}, "dynamics": law,
        "thermal": {"temperature": 0.5}, "bodies": bodies, "walls": [{"box": {"minimum": [-3, -3, -3], "maximum": [3, 3, 3]}}],
        "contact": {"overlap_tolerance": 1e-5}, "solver": {"tolerance": 1e-7}});
    if growing {
        of["growth"] = json!({"rate": 2.0, "division_length": 1.5, "reorientation_degrees": 5});
    }
    of
}

#[test]
fn the_tolerance_holds_in_every_step_of_a_hot_crowd_and_a_device_takes_the_same_steps() {
    let damped = json!({"inertial": {"density": 1.0, "drag": 10.0}});
    for (planar, law, growing) in [
        (false, overdamped(), false),
        (true, overdamped(), true),
        (false, damped.clone(), false),
        (true, damped, false),
    ] {
        let scene = parse(&crowd(planar, &law, growing));
        let mut simulation = Simulation::new(scene.clone()).unwrap();
        while !simulation.done() {
            let report = simulation.step().unwrap();
            assert!(report.max_overlap <= 1e-5, "{report:?}");
        }
        let moved = simulation.state().unwrap().bodies.position[0].distance(scene.build().unwrap().position[0]);
        assert!(moved > 0.01, "{moved}");
        // Contacts amplify small differences.
        agrees_on_device(&scene, &format!("planar {planar}, {law}, growing {growing}"), [1e-3, 1e-5]);
    }
}

/// The same numbers from the same integers: a few steps without contact, with forces of the host's own beside them.
#[test]
fn a_device_draws_the_numbers_of_the_cpu() {
    let Some(gpu) = device() else { return };
    for law in [overdamped(), json!({"inertial": {"density": 2.0, "drag": DRAG}})] {
        let scene = parse(&apart(&shapes()[2], &law, (0.01, 0.05), false));
        let take = |compute: &Compute| {
            let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
            simulation.step().unwrap();
            simulation.add_force(Box::new(|_: &Bodies, i: usize, _: f64| Load {
                force: DVec3::X * i as f64,
                torque: DVec3::Y,
            }));
            while !simulation.done() {
                simulation.step().unwrap();
            }
            simulation.state().unwrap().bodies.clone()
        };
        let reference = take(&Compute::Cpu);
        for precision in precisions(gpu) {
            let ours = take(&Compute::Gpu { gpu: gpu.clone(), precision });
            let off = |i: usize| {
                let place = ours.position[i].distance(reference.position[i]);
                place.max((ours.orientation[i] - reference.orientation[i]).length())
            };
            let off = (0..ours.len()).map(off).fold(0.0, f64::max);
            println!("{law}, {precision:?}: {off:.1e}");
            assert!(
                off < if precision == relcp::gpu::Precision::F32 { 2e-5 } else { 1e-12 },
                "{law}, {precision:?}: {off:e}"
            );
        }
    }
}

/// A body's numbers are its id's, not its place's in the list.
#[test]
fn the_order_of_bodies_and_the_number_of_threads_change_no_bit() {
    let scene = parse(&apart(&shapes()[1], &overdamped(), (0.01, 0.1), false));
    let last = scene.final_scene(&scene.build().unwrap(), 0.0);
    let mut turned = last.clone();
    turned.bodies.reverse();
    let [a, b] = [last.clone(), turned].map(|scene| run(scene, &Compute::Cpu).bodies);
    for i in 0..a.len() {
        let j = a.len() - 1 - i;
        assert_eq!(
            (a.lineage[i].id, a.position[i], a.orientation[i]),
            (b.lineage[j].id, b.position[j], b.orientation[j])
        );
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| run(last, &Compute::Cpu).bodies) == a);
    let mut other = scene;
    other.seed += 1;
    assert!(run(other, &Compute::Cpu).bodies.position[0] != a.position[0]);
}

#[test]
fn heat_without_a_resistance_or_in_midpoint_steps_is_refused() {
    let of = |keys: &Value| {
        let mut of = apart(&shapes()[0], &overdamped(), (0.01, 0.1), false);
        of.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
        refusal(&of)
    };
    let (key, message) = of(&json!({"dynamics": {"inertial": {"density": 1}}}));
    assert!(key == "thermal" && message.contains("dynamics.inertial.drag"), "{message}");
    let (key, message) = of(&json!({"time": {"dt": 0.1, "end": 1, "stepping": "midpoint"}}));
    assert!(key == "time.stepping" && message.contains("euler"), "{message}");
    let (key, message) = of(&json!({"thermal": {"temperature": -1}}));
    assert!(key == "thermal.temperature" && message.contains("positive"), "{message}");
}
