//! Bodies in a shear flow: Jeffery's orbits, what drag does in a flow, and collisions.

use crate::forces::everything;
use crate::scenes::{ALONG_X, agrees_on_device, apart, parse, refusal, run};
use glam::{DMat3, DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::contacts;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const RATE: f64 = 1.5;

fn shear(rate: f64) -> Value {
    json!({"shear": {"rate": rate, "direction": [1, 0, 0], "gradient": [0, 1, 0]}})
}

fn scene(dt: f64, end: f64, stepping: &str, law: &Value, bodies: &[Value]) -> Value {
    json!({"name": "carried", "time": {"dt": dt, "end": end, "stepping": stepping}, "dynamics": law,
        "flow": shear(RATE), "bodies": bodies})
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": 1.5}})
}

fn body(shape: &Value, position: [f64; 3], q: DQuat) -> Value {
    json!({"shape": shape, "position": position, "orientation": [q.w, q.x, q.y, q.z]})
}

/// The time in which a spheroid of this aspect ratio, in the plane of the flow, turns round once.
fn period(aspect: f64, dt: f64, stepping: &str) -> f64 {
    let shape = json!({"ellipsoid": {"radii": [1, 1, aspect]}});
    let long = 1.1 * TAU * (aspect + 1.0 / aspect) / RATE;
    let mut of = scene(
        dt,
        long,
        stepping,
        &overdamped(),
        &[json!({"shape": shape, "position": [0, 0, 0], "orientation": ALONG_X})],
    );
    of["planar"] = json!(true);
    let mut simulation = Simulation::builder(parse(&of)).on(&Compute::Cpu).build().unwrap();
    let angle = |bodies: &Bodies| {
        let axis = bodies.orientation[0] * DVec3::Z;
        axis.y.atan2(axis.x)
    };
    let (mut turned, mut last, mut steps) = (0.0_f64, 0.0, 0.0);
    while !simulation.done() {
        simulation.step().unwrap();
        let now = angle(&simulation.state().unwrap().bodies);
        let mut turn = now - last;
        turn -= TAU * (turn / TAU).round();
        if turned + turn <= -TAU {
            return dt * (steps + (-TAU - turned) / turn);
        }
        (turned, last, steps) = (turned + turn, now, steps + 1.0);
    }
    f64::NAN
}

#[test]
fn a_spheroid_turns_in_jefferys_period() {
    for aspect in [1.0, 3.0, 10.0] {
        let exact = TAU * (aspect + 1.0 / aspect) / RATE;
        for (stepping, dt) in [("euler", 0.05 / RATE), ("midpoint", 0.05 / RATE)] {
            let off = (period(aspect, dt, stepping) / exact - 1.0).abs();
            println!("aspect {aspect}, {stepping}, g dt = {:.3}: period off by {off:.1e}", RATE * dt);
            assert!(off < 1e-3, "aspect {aspect}, {stepping}: {off:e}");
        }
    }
}

/// Jeffery's equation from the velocity gradient as a matrix: in body axes `w_ij = W_ij + (s_j - s_i) / (s_i + s_j)
/// D_ij`, with `W` and `D` the halves of it that change sign and that do not, and `s` the squares of the semi-axes.
fn turning(radii: DVec3, q: DQuat, gradient: DMat3) -> DVec3 {
    let axes = DMat3::from_quat(q);
    let of_body = axes.transpose() * gradient * axes;
    let s = radii * radii;
    let at = |i: usize, j: usize| {
        let (a, b) = (of_body.col(j)[i], of_body.col(i)[j]);
        0.5 * (a - b) + (s[j] - s[i]) / (s[i] + s[j]) * 0.5 * (a + b)
    };
    axes * DVec3::new(at(2, 1), at(0, 2), at(1, 0))
}

/// The orientation after `time` by Runge and Kutta's method of fourth order.
fn turned(radii: DVec3, start: DQuat, gradient: DMat3, time: f64) -> DQuat {
    let steps = 4000;
    let h = time / f64::from(steps);
    let rate = |q: DQuat| {
        let w = turning(radii, q.normalize(), gradient);
        DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * q * 0.5
    };
    (0..steps).fold(start, |q, _| {
        let a = rate(q);
        let b = rate(q + a * (0.5 * h));
        let c = rate(q + b * (0.5 * h));
        let d = rate(q + c * h);
        (q + (a + b * 2.0 + c * 2.0 + d) * (h / 6.0)).normalize()
    })
}

#[test]
fn bodies_of_every_shape_turn_by_jefferys_equation_to_the_order_of_the_scheme() {
    let start = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.9);
    let gradient = DMat3::from_cols(DVec3::ZERO, RATE * DVec3::X, DVec3::ZERO);
    let shapes = [
        (json!({"ellipsoid": {"radii": [0.4, 0.7, 1.3]}}), DVec3::new(0.4, 0.7, 1.3)),
        (json!({"ellipsoid": {"radii": [1, 1, 0.2]}}), DVec3::new(1.0, 1.0, 0.2)),
        // The limits of a rod and of a disc.
        (json!({"spherocylinder": {"diameter": 0.5, "length": 2}}), DVec3::new(1e-9, 1e-9, 1.0)),
        (json!({"torus": {"major_radius": 1, "minor_radius": 0.2}}), DVec3::new(1.0, 1.0, 1e-9)),
        (json!({"sphere": {"radius": 0.7}}), DVec3::ONE),
        (json!({"spherocylinder": {"diameter": 0.5, "length": 0.5}}), DVec3::ONE),
    ];
    for (shape, radii) in shapes {
        let expected = turned(radii, start, gradient, 4.0);
        for (stepping, order) in [("euler", 1), ("midpoint", 2)] {
            let error = |steps: f64| {
                let of = scene(4.0 / steps, 4.0, stepping, &overdamped(), &[body(&shape, [0.0; 3], start)]);
                let q = run(parse(&of), &Compute::Cpu).bodies.orientation[0];
                (q - expected).length().min((q + expected).length())
            };
            let [coarse, fine] = [256.0, 512.0].map(error);
            println!("{shape}, {stepping}: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
            // A ball turns steadily: what is left is the step's map of a turn, of second order.
            let order = if radii == DVec3::ONE { 2 } else { order };
            assert!(
                (coarse / fine / f64::from(1 << order) - 1.0).abs() < 0.1,
                "{shape} {stepping}: {coarse:e} {fine:e}"
            );
        }
    }
}

#[test]
fn a_sphere_goes_with_the_fluid_at_its_centre_and_turns_with_half_of_its_vorticity() {
    // Any unit vectors at right angles.
    let (d, e) = (DVec3::new(2.0, 1.0, 2.0) / 3.0, DVec3::new(-2.0, 2.0, 1.0) / 3.0);
    let at = DVec3::new(0.5, 2.0, -1.0);
    for stepping in ["euler", "midpoint"] {
        let mut of = scene(
            0.1,
            2.0,
            stepping,
            &overdamped(),
            &[body(&json!({"sphere": {"radius": 0.7}}), at.to_array(), DQuat::IDENTITY)],
        );
        of["flow"] = json!({"shear": {"rate": -0.8, "direction": d.to_array(), "gradient": e.to_array()}});
        let bodies = run(parse(&of), &Compute::Cpu).bodies;
        let expected = at - 2.0 * 0.8 * at.dot(e) * d;
        assert!(bodies.position[0].distance(expected) < 1e-13, "{}", bodies.position[0]);
        assert!(bodies.angular_velocity[0].distance(-0.4 * e.cross(d)) < 1e-14, "{}", bodies.angular_velocity[0]);
    }
}

/// With inertia a ball's velocity relaxes to the flow's, and its turning to half of the vorticity, exactly for every
/// step.
#[test]
fn drag_acts_on_what_differs_from_the_flow() {
    let (drag, density, radius, height) = (0.6_f64, 2.0_f64, 0.5_f64, 1.25);
    let law = json!({"inertial": {"density": density, "drag": drag}});
    let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
    let (a, b) = (drag * 2.0 * radius / mass, drag * (2.0 * radius).powi(3) / 12.0 / (0.4 * mass * radius * radius));
    for (stepping, dt) in [("euler", 1.0), ("euler", 0.25), ("midpoint", 1.0), ("midpoint", 0.25)] {
        let ball = body(&json!({"sphere": {"radius": radius}}), [0.0, height, 0.0], DQuat::IDENTITY);
        let bodies = run(parse(&scene(dt, 2.0, stepping, &law, &[ball])), &Compute::Cpu).bodies;
        let speed = RATE * height * (1.0 - (-2.0 * a).exp());
        let spin = -0.5 * RATE * (1.0 - (-2.0 * b).exp());
        assert!(bodies.velocity[0].distance(speed * DVec3::X) < 1e-13, "{stepping} {dt}: {}", bodies.velocity[0]);
        assert!(bodies.angular_velocity[0].distance(spin * DVec3::Z) < 1e-13, "{}", bodies.angular_velocity[0]);
    }
}

/// Two balls that touch turn about each other, `cot(angle) = g t + cot(angle at the start)` from x, until one stands
/// above the other; then the flow parts them, at a height of a diameter.
#[test]
fn balls_that_collide_slide_around_each_other_within_the_tolerance() {
    let (radius, tolerance) = (0.5, 1e-6);
    let start = (2.0 * PI / 3.0_f64).sin_cos();
    for (planar, stepping, order) in
        [(true, "euler", 1), (false, "euler", 1), (true, "midpoint", 2), (false, "midpoint", 2)]
    {
        let error = |steps: f64| {
            // In contact from the start, until the angle is a hundred degrees.
            let touching = (1.0 / (2.0 * PI / 3.0).tan() - 1.0 / (100.0_f64.to_radians()).tan()).abs() / RATE;
            let place = |side: f64| [side * radius * start.1, side * radius * start.0, 0.0];
            let bodies =
                [-1.0, 1.0].map(|side| body(&json!({"sphere": {"radius": radius}}), place(side), DQuat::IDENTITY));
            let dt = touching / steps;
            let mut of = scene(dt, 4.0, stepping, &overdamped(), &bodies);
            (of["planar"], of["contact"]) = (json!(planar), json!({"overlap_tolerance": tolerance}));
            let mut simulation = Simulation::builder(parse(&of)).on(&Compute::Cpu).build().unwrap();
            let (mut step, mut angle) = (0.0, 0.0);
            while !simulation.done() {
                simulation.step().unwrap();
                step += 1.0;
                let bodies = &simulation.state().unwrap().bodies;
                let overlap = contacts(bodies, 0.0).iter().map(|found| -found.separation).fold(0.0, f64::max);
                assert!(overlap <= tolerance, "{overlap:e}");
                if step == steps {
                    let between = bodies.position[1] - bodies.position[0];
                    angle = between.y.atan2(between.x);
                }
            }
            let bodies = &simulation.state().unwrap().bodies;
            let between = bodies.position[1] - bodies.position[0];
            assert!(between.x > 2.0 && (between.y - 2.0 * radius).abs() < 2.0 * dt, "{between}");
            (angle - 100.0_f64.to_radians()).abs()
        };
        let [coarse, fine] = [32.0, 64.0].map(error);
        println!(
            "planar {planar}, {stepping}: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}",
            coarse / fine
        );
        assert!((coarse / fine / f64::from(1 << order) - 1.0).abs() < 0.15, "{coarse:e} {fine:e}");
    }
}

/// A flow that does not change along the periods: a step does not depend on which image a body is.
#[test]
fn a_flow_across_the_periods_carries_every_image_alike() {
    let of = |turns: f64| {
        let ball = |x: f64, y: f64| body(&json!({"sphere": {"radius": 0.5}}), [x, y, 0.0], DQuat::IDENTITY);
        let bodies = [ball(1.0 + 8.0 * turns, 0.75), ball(7.6, -0.1), ball(3.0, -0.05), ball(5.0 - 8.0 * turns, 0.8)];
        let mut of = scene(0.02, 3.0, "euler", &overdamped(), &bodies);
        (of["planar"], of["periodic"]) = (json!(true), json!({"lengths": [8, null, null]}));
        of
    };
    let [here, there] = [0.0, 3.0].map(|turns| run(parse(&of(turns)), &Compute::Cpu).bodies);
    for (i, turns) in [3.0, 0.0, 0.0, -3.0].into_iter().enumerate() {
        let off = here.position[i].distance(there.position[i] - 8.0 * turns * DVec3::X);
        assert!(off < 1e-12, "{i}: {off:e}");
    }
    for (i, (x, y)) in [(1, (7.6, -0.1)), (2, (3.0, -0.05))] {
        let free = DVec3::new(x + y * RATE * 3.0, y, 0.0);
        assert!(here.position[i].distance(free) > 0.05, "{i} met none: {}", here.position[i]);
    }
    agrees_on_device(&parse(&of(0.0)), "periodic", [2e-5, 1e-9]);
}

#[test]
fn a_flow_on_a_device_is_the_cpus() {
    let laws = [overdamped(), json!({"inertial": {"density": 1.5, "drag": 20}})];
    for (planar, law, stepping) in
        [(true, &laws[0], "euler"), (false, &laws[0], "midpoint"), (false, &laws[1], "euler")]
    {
        let mut of = everything(planar, law, stepping, false);
        of["flow"] = shear(RATE);
        if law == &laws[1] {
            of["thermal"] = json!({"temperature": 0.01});
        }
        agrees_on_device(&parse(&of), &format!("planar {planar}, {stepping}, {law}"), [2e-4, 1e-9]);
    }
    let shapes = [
        json!({"ellipsoid": {"radii": [0.4, 0.7, 1.3]}}),
        json!({"spherocylinder": {"diameter": 0.5, "length": 2}}),
        json!({"torus": {"major_radius": 1, "minor_radius": 0.2}}),
        json!({"sphere": {"radius": 0.7}}),
    ];
    let q = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.9);
    let bodies: Vec<Value> =
        (0..).zip(&shapes).map(|(i, shape)| body(shape, [0.0, 0.3, 4.0 * f64::from(i)], q)).collect();
    let of = scene(0.05, 1.0, "midpoint", &laws[1], &bodies);
    agrees_on_device(&parse(&of), "all shapes", [2e-5, 1e-12]);
}

#[test]
fn fixed_bodies_stay_and_custom_scenes_without_drag_are_refused() {
    let ball = json!({"shape": {"sphere": {"radius": 0.5}}, "position": [0, 2, 0], "fixed": true});
    let bodies = run(parse(&scene(0.1, 1.0, "euler", &overdamped(), &[ball])), &Compute::Cpu).bodies;
    assert_eq!(bodies.position[0], DVec3::new(0.0, 2.0, 0.0));
    let ball = body(&json!({"sphere": {"radius": 0.5}}), [0.0; 3], DQuat::IDENTITY);
    let (key, message) =
        refusal(&scene(0.1, 1.0, "euler", &json!({"inertial": {"density": 1}}), std::slice::from_ref(&ball)));
    assert!(key == "flow" && message.contains("dynamics.inertial.drag"), "{message}");
    // A flow at rest is none, but for the bits of its roundings.
    let mut still = scene(0.1, 1.0, "euler", &overdamped(), &[ball]);
    still["flow"] = shear(0.0);
    let mut plain = still.clone();
    plain.as_object_mut().unwrap().remove("flow");
    assert!(apart(&run(parse(&still), &Compute::Cpu).bodies, &run(parse(&plain), &Compute::Cpu).bodies) == 0.0);
    assert!(!parse(&plain).to_json().contains("flow"));
}
