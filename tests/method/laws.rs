//! Laws of motion against their formulas, contact against the conservation laws, and forces that a user plugs in.

use crate::random::{Random, parse};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::scene::Scene;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::{Fault, contacts};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub fn start(scene: Scene) -> Simulation {
    Simulation::new(scene).unwrap()
}

pub fn body(shape: Value, position: [f64; 3], orientation: DQuat) -> Value {
    let q = orientation;
    json!({"shape": shape, "position": position, "orientation": [q.w, q.x, q.y, q.z]})
}

pub fn sphere(radius: f64) -> Value {
    json!({"sphere": {"radius": radius}})
}

pub fn rod(diameter: f64, length: f64) -> Value {
    json!({"spherocylinder": {"diameter": diameter, "length": length}})
}

fn moving(shape: Value, position: [f64; 3], orientation: DQuat, velocity: [f64; 3]) -> Value {
    let mut body = body(shape, position, orientation);
    body["velocity"] = json!(velocity);
    body
}

fn mass(bodies: &Bodies, i: usize, density: f64) -> f64 {
    density * bodies.shape[i].volume()
}

fn spin_of(bodies: &Bodies, i: usize, density: f64) -> DVec3 {
    let q = bodies.orientation[i];
    q * (density * bodies.shape[i].unit_inertia() * (q.inverse() * bodies.angular_velocity[i]))
}

/// Momentum, and angular momentum about the origin.
fn momenta(bodies: &Bodies, density: f64) -> [DVec3; 2] {
    (0..bodies.len()).fold([DVec3::ZERO; 2], |[p, l], i| {
        let own = mass(bodies, i, density) * bodies.velocity[i];
        [p + own, l + bodies.position[i].cross(own) + spin_of(bodies, i, density)]
    })
}

#[test]
fn drag_moves_and_turns_each_shape_by_its_length() {
    let drag = 1.7;
    let shapes = [
        (sphere(0.6), 1.2),
        (rod(0.5, 3.0), 3.0),
        (json!({"ellipsoid": {"radii": [0.5, 2.0, 1.0]}}), 4.0),
        (json!({"torus": {"major_radius": 1.5, "minor_radius": 0.25}}), 3.5),
    ];
    for (shape, length) in shapes {
        let orientation = DQuat::from_axis_angle(DVec3::new(2.0, -1.0, 3.0).normalize(), 0.8);
        let (dt, steps) = (0.01, 20);
        let scene = parse(&json!({
            "name": "drag", "time": {"dt": dt, "end": 1.0}, "dynamics": {"overdamped": {"drag": drag}},
            "forces": [{"uniform": {"force": [1.0, -2.0, 0.5]}}], "bodies": [body(shape, [0.1, 0.2, 0.3], orientation)]
        }));
        let mut simulation = start(scene);
        let torque = DVec3::new(0.3, 0.4, -1.2);
        simulation.add_force(Box::new(move |_: &Bodies, _: usize, _: f64| Load { force: DVec3::ZERO, torque }));
        for _ in 0..steps {
            simulation.step().unwrap();
        }
        let bodies = &simulation.state().unwrap().bodies;
        let moved = bodies.position[0] - DVec3::new(0.1, 0.2, 0.3);
        let expected = DVec3::new(1.0, -2.0, 0.5) / (drag * length) * (dt * f64::from(steps));
        assert!((moved - expected).length() < 1e-14, "{moved} {expected}");
        let speed = 12.0 * torque.length() / (drag * length.powi(3));
        assert!((bodies.angular_velocity[0] - speed * torque.normalize()).length() < 1e-14 * speed);
        // One update turns by 2 atan(|dt w| / 2) about w.
        let angle = f64::from(steps) * 2.0 * (0.5 * dt * speed).atan();
        let expected = DQuat::from_axis_angle(torque.normalize(), angle) * orientation;
        let apart = bodies.orientation[0].angle_between(expected);
        println!("length {length}: turned {angle:.3}, off by {apart:.1e}");
        assert!(apart < 1e-7 && (bodies.orientation[0].dot(expected).abs() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn a_body_falls_as_the_first_order_step_says() {
    let (dt, steps, g) = (0.01, 100, [0.0, 0.0, -9.81]);
    let shape = json!({"ellipsoid": {"radii": [0.5, 2.0, 1.0]}});
    let scene = parse(&json!({
        "name": "fall", "time": {"dt": dt, "end": 1.0}, "dynamics": {"inertial": {"density": 3.0}},
        "forces": [{"gravity": {"acceleration": g}}],
        "bodies": [moving(shape, [0.0; 3], DQuat::IDENTITY, [1.0, 0.0, 2.0])]
    }));
    let mut simulation = start(scene);
    for _ in 0..steps {
        simulation.step().unwrap();
    }
    let bodies = &simulation.state().unwrap().bodies;
    let (t, n) = (1.0, f64::from(steps));
    // v_k = v_0 + k dt g, x_n = x_0 + dt (v_1 + ... + v_n).
    let expected = DVec3::new(t, 0.0, 2.0 * t) + DVec3::from(g) * (dt * dt * n * (n + 1.0) / 2.0);
    assert!((bodies.velocity[0] - DVec3::new(1.0, 0.0, 2.0 - 9.81 * t)).length() < 1e-13);
    assert!((bodies.position[0] - expected).length() < 1e-13, "{}", bodies.position[0]);
    assert_eq!((bodies.orientation[0], bodies.angular_velocity[0]), (DQuat::IDENTITY, DVec3::ZERO));
}

fn collision(bodies: Vec<Value>, dt: f64) -> Scene {
    parse(&json!({
        "name": "collision", "time": {"dt": dt, "end": 1.0}, "dynamics": {"inertial": {"density": 2.0}}, "bodies": bodies,
        "solver": {"tolerance": 1e-13}
    }))
}

#[test]
fn a_head_on_collision_ends_with_the_common_velocity() {
    let up = DQuat::IDENTITY;
    let scene = collision(
        vec![
            moving(sphere(0.5), [-1.0, 0.0, 0.0], up, [3.0, 0.0, 0.0]),
            moving(sphere(0.5), [1.0, 0.0, 0.0], up, [-1.0, 0.0, 0.0]),
        ],
        0.01,
    );
    let mut simulation = start(scene);
    let [p, l] = momenta(&simulation.state().unwrap().bodies, 2.0);
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= 1e-12 && report.unconverged == 0);
        let [p1, l1] = momenta(&simulation.state().unwrap().bodies, 2.0);
        assert!((p1 - p).length() < 1e-14 && (l1 - l).length() < 1e-14, "{p1} {l1}");
    }
    let bodies = &simulation.state().unwrap().bodies;
    for i in 0..2 {
        assert!((bodies.velocity[i] - DVec3::X).length() < 1e-11, "{}", bodies.velocity[i]);
    }
    let gap = bodies.position[1].x - bodies.position[0].x - 1.0;
    println!("gap after {gap:e}");
    assert!(gap.abs() < 1e-11, "{gap:e}");
}

#[test]
fn a_light_body_between_two_heavy_ones() {
    let up = DQuat::IDENTITY;
    let scene = collision(
        vec![
            moving(sphere(1.0), [-2.0, 0.0, 0.0], up, [5.0, 0.0, 0.0]),
            moving(sphere(0.1), [0.0, 0.0, 0.0], up, [0.0; 3]),
            moving(sphere(1.0), [2.0, 0.0, 0.0], up, [-2.0, 0.0, 0.0]),
        ],
        0.01,
    );
    let mut simulation = start(scene);
    let before = momenta(&simulation.state().unwrap().bodies, 2.0)[0];
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= 1e-5 && report.unconverged == 0, "{report:?}");
    }
    let bodies = &simulation.state().unwrap().bodies;
    let after = momenta(bodies, 2.0)[0];
    let common = before.x / (0..3).map(|i| mass(bodies, i, 2.0)).sum::<f64>();
    println!("common {common}, velocities {:?}, momentum off by {:.1e}", bodies.velocity, (after - before).length());
    assert!((after - before).length() < 1e-13 * before.length());
    for velocity in &bodies.velocity {
        assert!((*velocity - DVec3::X * common).length() < 1e-10, "{velocity}");
    }
}

/// A ball hits a long body off its centre, in a plane or askew; the largest relative changes of the momenta and its
/// last spin.
fn off_centre(dt: f64, long: &Value, planar: bool) -> ([f64; 2], DVec3) {
    let askew = if planar { 0.0 } else { 0.3 };
    let rod_pose = DQuat::from_rotation_x(askew) * DQuat::from_rotation_y(FRAC_PI_2);
    let mut scene = collision(
        vec![
            moving(long.clone(), [0.0; 3], rod_pose, [0.0; 3]),
            moving(sphere(0.4), [1.2, -1.0, 0.0], DQuat::IDENTITY, [0.3, 4.0, askew]),
        ],
        dt,
    );
    scene.planar = planar;
    let mut simulation = start(scene);
    let begin = momenta(&simulation.state().unwrap().bodies, 2.0);
    let mut worst = [0.0f64; 2];
    while !simulation.done() {
        simulation.step().unwrap();
        let now = momenta(&simulation.state().unwrap().bodies, 2.0);
        for k in 0..2 {
            worst[k] = worst[k].max((now[k] - begin[k]).length() / begin[k].length());
        }
    }
    (worst, simulation.state().unwrap().bodies.angular_velocity[0])
}

#[test]
fn a_body_hit_off_its_centre_keeps_the_momenta() {
    let (rod, triaxial) = (rod(0.5, 4.0), json!({"ellipsoid": {"radii": [0.25, 0.5, 2.0]}}));
    for (long, planar) in [(&rod, true), (&rod, false), (&triaxial, true), (&triaxial, false)] {
        let runs = [0.004, 0.002, 0.001].map(|dt| off_centre(dt, long, planar));
        for (worst, spin) in &runs {
            println!("{long} planar {planar}: momenta off by {worst:?}, spin {spin:.4}");
            assert!(worst[0] < 1e-13, "{worst:?}");
            assert!(spin.z > 0.5, "the hit does not turn it: {spin}");
        }
        assert!(runs.iter().all(|(worst, _)| worst[1] < 1e-12), "{runs:?}");
    }
}

/// Kinetic energy.
pub fn energy(bodies: &Bodies, density: f64) -> f64 {
    let of_body = |i: usize| {
        let (u, w) = (bodies.velocity[i], bodies.angular_velocity[i]);
        let in_body = bodies.orientation[i].inverse() * w;
        0.5 * density
            * (bodies.shape[i].volume() * u.length_squared() + (bodies.shape[i].unit_inertia() * in_body).dot(in_body))
    };
    (0..bodies.len()).map(of_body).sum()
}

struct Fall {
    /// Largest rise of kinetic energy by one step's contact beyond the work that parts what overlapped at its start.
    unexplained: f64,
    /// The same over steps that recurred.
    recurred: f64,
    /// Largest rise, and largest loss, of kinetic energy by one step's contact, against the same step without it.
    rise: f64,
    loss: f64,
    /// Largest changes of momentum by one step, of angular momentum by one that did not recur and by one that did.
    momenta: [f64; 3],
}

/// A cloud that falls together with spins of this size; energies in parts of that at the start.
fn fall_together(seed: u64, shape: &Value, method: &str, dt: f64, spin: f64) -> Fall {
    let mut random = Random::new(seed);
    let scene = parse(&json!({
        "name": "cloud", "seed": seed, "time": {"dt": dt, "end": 1.0}, "dynamics": {"inertial": {"density": 1.0}},
        "contact": {"method": method}, "solver": {"tolerance": 1e-11},
        "generate": [{"isotropic": {"count": 40, "shape": shape, "volume_fraction": 0.1}}]
    }));
    let mut bodies = scene.build().unwrap();
    for i in 0..bodies.len() {
        bodies.velocity[i] = -2.0 * bodies.position[i] + 0.5 * random.vector();
        bodies.angular_velocity[i] = spin * random.vector();
    }
    let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
    let begin = energy(&simulation.state().unwrap().bodies, 1.0);
    let mut fall = Fall { unexplained: 0.0, recurred: 0.0, rise: 0.0, loss: 0.0, momenta: [0.0; 3] };
    let sizes = {
        let bodies = &simulation.state().unwrap().bodies;
        let own = |i: usize| [mass(bodies, i, 1.0) * bodies.velocity[i], spin_of(bodies, i, 1.0)];
        (0..bodies.len())
            .map(own)
            .fold([0.0; 2], |[p, l], [own, spin]| [p + own.length(), l + spin.length() + own.length()])
    };
    while !simulation.done() {
        let before = simulation.state().unwrap().bodies.clone();
        let report = simulation.step().unwrap();
        assert_eq!(report.unconverged, 0, "{report:?}");
        // Without contact it would be kept.
        let gain = (energy(&simulation.state().unwrap().bodies, 1.0) - energy(&before, 1.0)) / begin;
        let force = |pair: [usize; 2]| -> f64 {
            let of_pair = simulation.state().unwrap().warm.iter().filter(|w| w.pair.map(|i| i as usize) == pair);
            of_pair.map(|w| w.gamma).sum()
        };
        let parting: f64 = contacts(&before, 0.0).iter().map(|near| -near.separation * force(near.bodies)).sum();
        let unexplained = gain - parting / begin;
        let most = if report.recursions > 0 { &mut fall.recurred } else { &mut fall.unexplained };
        *most = most.max(unexplained);
        let [[p, l], [p1, l1]] = [&before, &simulation.state().unwrap().bodies].map(|bodies| momenta(bodies, 1.0));
        fall.momenta[0] = fall.momenta[0].max((p1 - p).length() / sizes[0]);
        let turned = &mut fall.momenta[if report.recursions > 0 { 2 } else { 1 }];
        *turned = turned.max((l1 - l).length() / sizes[1]);
        fall.rise = fall.rise.max(gain);
        fall.loss = fall.loss.max(-gain);
    }
    fall
}

#[test]
fn contact_adds_no_kinetic_energy_but_to_part_what_overlaps() {
    let shapes = [sphere(0.5), rod(0.4, 1.6), json!({"ellipsoid": {"radii": [0.3, 0.5, 0.8]}})];
    for (seed, shape) in shapes.iter().enumerate() {
        for method in ["snsd", "relcp"] {
            for dt in [0.02, 0.01, 0.005] {
                for spin in [1.0, 8.0] {
                    let Fall { unexplained, recurred, rise, loss, momenta } =
                        fall_together(seed as u64, shape, method, dt, spin);
                    println!(
                        "{shape} {method} dt {dt} spin {spin}: unexplained {unexplained:.1e}, recurred {recurred:.1e}, rise {rise:.1e}, loss {loss:.1e}, momenta {momenta:?}"
                    );
                    assert!(loss > 1e-3, "hardly any contact: {loss:e}");
                    assert!(
                        unexplained < if spin > 1.0 { 1e-6 } else { 1e-9 },
                        "contact adds {unexplained:e} of the energy"
                    );
                    assert!(recurred < 1e-3, "contact adds {recurred:e} of the energy");
                    assert!(momenta[0] < 1e-13 && momenta[1] < 1e-12, "{momenta:?}");
                    assert!(method == "snsd" || rise < 1e-3, "{rise:e}");
                }
            }
        }
    }
}

#[test]
fn groups_select_the_bodies_of_a_force() {
    let mut bodies: Vec<Value> =
        (0..4).map(|i| body(sphere(0.5), [3.0 * f64::from(i), 0.0, 0.0], DQuat::IDENTITY)).collect();
    bodies[1]["group"] = json!("left");
    bodies[2]["group"] = json!("right");
    let scene = parse(&json!({
        "name": "groups", "time": {"dt": 0.1, "end": 1.0}, "bodies": bodies,
        "forces": [
            {"uniform": {"force": [0.0, 1.0, 0.0], "group": "right"}},
            {"uniform": {"force": [0.0, 0.0, 2.0], "group": "left"}},
            {"uniform": {"force": [0.0, 0.5, 0.0]}}
        ]
    }));
    let mut simulation = start(scene);
    simulation.step().unwrap();
    let found = &simulation.state().unwrap().bodies.velocity;
    assert_eq!(found, &[[0.0, 0.5, 0.0], [0.0, 0.5, 2.0], [0.0, 1.5, 0.0], [0.0, 0.5, 0.0]].map(DVec3::from));
}

#[test]
fn a_plugged_in_force_sees_the_state_and_the_time() {
    let scene = parse(&json!({
        "name": "spring", "time": {"dt": 0.1, "end": 2.0, "start": 1.0},
        "bodies": [body(sphere(0.5), [2.0, 0.0, 0.0], DQuat::IDENTITY), body(sphere(0.5), [-2.0, 1.0, 0.0], DQuat::IDENTITY)]
    }));
    let mut simulation = start(scene);
    simulation.add_force(Box::new(|bodies: &Bodies, i: usize, time: f64| Load {
        force: -time * bodies.position[i],
        torque: DVec3::ZERO,
    }));
    let mut expected = [DVec3::new(2.0, 0.0, 0.0), DVec3::new(-2.0, 1.0, 0.0)];
    for k in 0..4 {
        simulation.step().unwrap();
        expected = expected.map(|x| x * (1.0 - 0.1 * (1.0 + 0.1 * f64::from(k))));
        for (found, expected) in simulation.state().unwrap().bodies.position.iter().zip(expected) {
            assert!((*found - expected).length() < 1e-14);
        }
    }
}

#[test]
fn after_a_force_that_is_not_finite_stepping_goes_on_as_if_it_had_not_been() {
    for (bad, torque) in
        [(f64::NAN, 0.0), (f64::INFINITY, 0.0), (0.0, f64::NEG_INFINITY), (0.0, f64::NAN), (1e300, 0.0), (0.0, 1e300)]
    {
        let scene = crate::random::heap(7, &["sphere", "spherocylinder", "ellipsoid"], 20, 0.02);
        let mut untouched = start(scene.clone());
        let mut simulation = start(scene);
        let on = Arc::new(AtomicBool::new(false));
        let switch = on.clone();
        simulation.add_force(Box::new(move |_: &Bodies, i: usize, _: f64| {
            let on = switch.load(Ordering::SeqCst) && i == 5;
            if !on {
                return Load::default();
            }
            Load { force: DVec3::new(0.0, bad, 0.0), torque: DVec3::new(0.0, 0.0, torque) }
        }));
        for _ in 0..3 {
            simulation.step().unwrap();
            untouched.step().unwrap();
        }
        let before = simulation.state().unwrap().clone();
        on.store(true, Ordering::SeqCst);
        let fault = simulation.step();
        println!("{bad:e} {torque:e}: {}", fault.is_ok());
        if bad.abs() < 1e301 && torque.abs() < 1e301 {
            // Huge but finite: either outcome is honest, as long as a state that is accepted is finite.
            if fault.is_ok() {
                assert!(simulation.state().unwrap().bodies.position.iter().all(|x| x.is_finite()));
                assert!(
                    simulation.state().unwrap().bodies.orientation.iter().all(|q| q.is_finite() && q.is_normalized())
                );
                continue;
            }
        } else {
            let Err(Fault::NotFinite { step, body, .. }) = fault else { panic!("{fault:?}") };
            assert_eq!((step, body), (4, 5));
        }
        assert_eq!(simulation.state().unwrap(), &before, "the fault changed the state");
        on.store(false, Ordering::SeqCst);
        for _ in 0..3 {
            simulation.step().unwrap();
            untouched.step().unwrap();
        }
        assert_eq!(simulation.state().unwrap(), untouched.state().unwrap(), "the fault left something behind");
    }
}

#[test]
fn a_torque_too_large_to_turn_by_leaves_no_body_without_an_orientation() {
    // Its angular velocity is finite, but the length of the quaternion that it turns by is not.
    let scene = parse(&json!({
        "name": "torque", "time": {"dt": 0.1, "end": 1.0}, "bodies": [body(rod(0.5, 2.0), [0.0; 3], DQuat::IDENTITY)]
    }));
    let mut simulation = start(scene);
    let before = simulation.state().unwrap().clone();
    simulation
        .add_force(Box::new(|_: &Bodies, _: usize, _: f64| Load { force: DVec3::ZERO, torque: DVec3::X * 1e300 }));
    assert_eq!(simulation.step(), Err(Fault::NotFinite { step: 1, what: "pose", body: 0 }));
    assert_eq!(simulation.state().unwrap(), &before);
}

#[test]
fn the_drag_length_is_the_largest_extent() {
    let shapes = [
        (Shape::Sphere { radius: 0.7 }, 1.4),
        (Shape::Spherocylinder { diameter: 0.5, length: 2.5 }, 2.5),
        (Shape::Ellipsoid { radii: [3.0, 1.0, 2.0] }, 6.0),
        (Shape::Torus { major_radius: 1.0, minor_radius: 0.1 }, 2.2),
    ];
    for (shape, length) in shapes {
        assert_eq!(shape.major_axis(), length, "{shape:?}");
    }
}
