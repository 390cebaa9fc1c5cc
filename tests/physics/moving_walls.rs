//! Walls that move: pistons, turning walls and containers that are carried, against their closed forms.

use crate::scenes::{agrees_on_device, parse, run};
use glam::{DVec2, DVec3};
use relcp::contacts;
use relcp::simulation::{Compute, Simulation};
use relcp::step::Fault;
use serde_json::{Value, json};

const TOLERANCE: f64 = 1e-7;

fn ball(radius: f64, position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": radius}}, "position": position})
}

fn scene(dt: f64, end: f64, stepping: &str, planar: bool, walls: &Value, bodies: &[Value]) -> Value {
    json!({"name": "pushed", "time": {"dt": dt, "end": end, "stepping": stepping}, "planar": planar, "walls": walls,
        "dynamics": {"overdamped": {"drag": 1.5}}, "bodies": bodies, "contact": {"overlap_tolerance": TOLERANCE}})
}

fn piston(motion: &Value) -> Value {
    json!({"half_space": {"normal": [1, 0, 0], "offset": 0, "motion": motion}})
}

fn started(of: &Value) -> Simulation {
    Simulation::builder(parse(of)).on(&Compute::Cpu).build().unwrap()
}

/// The largest overlap of bodies with each other and with the walls where they are now.
fn overlap(simulation: &Simulation) -> f64 {
    let pairs = contacts(&simulation.state().unwrap().bodies, 0.0);
    let walls = simulation.wall_contacts(0.0).unwrap();
    pairs.iter().map(|c| -c.separation).chain(walls.iter().map(|c| -c.separation)).fold(0.0, f64::max)
}

#[test]
fn a_pistons_work_on_a_row_of_balls_is_what_drag_takes() {
    let (speed, radius, balls) = (0.7, 0.5, 4);
    let resistance = 1.5 * 2.0 * radius;
    for (planar, stepping) in [(true, "euler"), (false, "euler"), (true, "midpoint"), (false, "midpoint")] {
        let row: Vec<Value> = (0..balls).map(|i| ball(radius, [0.5 + f64::from(i), 0.0, 0.0])).collect();
        let walls = json!([piston(&json!({"velocity": [speed, 0.0, 0.0]}))]);
        let mut simulation = started(&scene(0.03, 1.2, stepping, planar, &walls, &row));
        let (mut work, mut taken) = (0.0, 0.0);
        while !simulation.done() {
            simulation.step().unwrap();
            assert!(overlap(&simulation) <= TOLERANCE, "{:e}", overlap(&simulation));
            let state = simulation.state().unwrap();
            let on_wall: f64 = state.warm.iter().filter(|w| w.pair[1] > 1 << 30).map(|w| w.gamma).sum();
            work += 0.03 * on_wall * speed;
            taken += 0.03 * state.bodies.velocity.iter().map(|u| resistance * u.length_squared()).sum::<f64>();
        }
        let expected = f64::from(balls) * resistance * speed * speed * 1.2;
        println!("planar {planar}, {stepping}: {work} for {expected}, drag takes {taken}");
        assert!((work / expected - 1.0).abs() < 1e-6 && (taken / expected - 1.0).abs() < 1e-6, "{work} {taken}");
        let first = simulation.state().unwrap().bodies.position[0].x;
        assert!((first - radius - 1.2 * speed).abs() < 2.0 * TOLERANCE, "{first}");
    }
}

/// The error of a ball's place at the end falls at the order of the scheme.
fn comes_at_the_order(what: &str, of: &dyn Fn(f64, &str) -> Value, expected: DVec3) {
    for (stepping, order) in [("euler", 1), ("midpoint", 2)] {
        let error = |dt: f64| {
            let mut simulation = started(&of(dt, stepping));
            while !simulation.done() {
                simulation.step().unwrap();
                assert!(overlap(&simulation) <= TOLERANCE, "{:e}", overlap(&simulation));
            }
            simulation.state().unwrap().bodies.position[0].distance(expected)
        };
        let [coarse, fine] = [1.0 / 16.0, 1.0 / 32.0].map(error);
        println!("{what}, {stepping}: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
        assert!((coarse / fine / f64::from(1 << order) - 1.0).abs() < 0.15, "{what}, {stepping}: {coarse:e} {fine:e}");
    }
}

/// A face that turns pushes a ball along its normal alone: along the face, seen from the axis, the ball slides by the
/// turn times its height over the axis.
#[test]
fn a_turning_box_pushes_along_its_normals() {
    let (half, radius, start, turning) = (4.0, 0.5, 2.0, 0.4);
    for planar in [true, false] {
        let of = |dt: f64, stepping: &str| {
            let motion = json!({"velocity": [0.3, 0.1, 0.0], "angular_velocity": [0.0, 0.0, turning]});
            let (minimum, maximum) = ([-half; 3], [half; 3]);
            let wall = json!([{"box": {"minimum": minimum, "maximum": maximum, "motion": motion}}]);
            scene(dt, 1.0, stepping, planar, &wall, &[ball(radius, [start, radius - half, 0.0])])
        };
        // In the frame that goes with the box its normals' velocity counts too: v.n pushes, v.t slides.
        let steps = 20_000;
        let h = 1.0 / f64::from(steps);
        let place = (0..steps).fold(DVec2::new(start, radius - half), |x, k| {
            let slope = |time: f64, x: DVec2| {
                let (axis, normal) = (DVec2::new(0.3, 0.1) * time, DVec2::from_angle(turning * time).perp());
                let from = x - axis;
                let wall = DVec2::new(0.3, 0.1) + turning * from.perp();
                normal * normal.dot(wall)
            };
            let time = f64::from(k) * h;
            x + h * slope(time + 0.5 * h, x + 0.5 * h * slope(time, x))
        });
        comes_at_the_order(&format!("a box, planar {planar}"), &of, DVec3::new(place.x, place.y, 0.0));
    }
}

/// A ball in the wake of a round container: with its angle from the direction of the motion, `tan(angle / 2)` grows as
/// `exp(V t / (R - r))`.
#[test]
fn a_container_that_is_carried_takes_a_ball_along() {
    let (large, radius, speed, start) = (2.0, 0.5, 0.8_f64, 1.9_f64);
    let rho = large - radius;
    let angle = 2.0 * ((0.5 * start).tan() * (speed / rho).exp()).atan();
    let expected = DVec3::new(speed + rho * angle.cos(), rho * angle.sin(), 0.0);
    let motion = json!({"velocity": [speed, 0, 0]});
    for (planar, wall) in [
        (true, json!([{"sphere": {"center": [0, 0, 0], "radius": large, "motion": motion}}])),
        (false, json!([{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": large, "motion": motion}}])),
    ] {
        let place = [rho * start.cos(), rho * start.sin(), 0.0];
        let of = |dt: f64, stepping: &str| scene(dt, 1.0, stepping, planar, &wall, &[ball(radius, place)]);
        comes_at_the_order(&format!("a round container, planar {planar}"), &of, expected);
    }
}

#[test]
fn a_window_stops_a_wall_and_its_way_is_exact_for_every_step() {
    for dt in [0.4, 0.07] {
        let motion = json!({"velocity": [1, 0, 0], "window": {"from": 0.33, "to": 0.91}});
        let of = scene(dt, 1.4, "euler", true, &json!([piston(&motion)]), &[ball(0.5, [0.5, 0.0, 0.0])]);
        let mut simulation = started(&of);
        while !simulation.done() {
            simulation.step().unwrap();
            assert!(overlap(&simulation) <= TOLERANCE);
        }
        let at = simulation.state().unwrap().bodies.position[0].x;
        assert!((at - 0.5 - 0.58).abs() < 2.0 * TOLERANCE, "{at}");
        // The scene that it ends with has the walls where they are then, and goes on from there.
        let last = simulation.scene().final_scene(&simulation.state().unwrap().bodies, simulation.time());
        assert_eq!(last.walls(), simulation.walls());
        assert!(last.walls() != simulation.scene().walls());
    }
}

#[test]
fn with_inertia_a_wall_gives_its_velocity_to_what_it_meets() {
    for stepping in ["euler", "midpoint"] {
        let mut of = scene(
            0.05,
            1.0,
            stepping,
            false,
            &json!([piston(&json!({"velocity": [2, 0, 0]}))]),
            &[ball(0.5, [1.0, 0.0, 0.0])],
        );
        of["dynamics"] = json!({"inertial": {"density": 1}});
        let bodies = run(parse(&of), &Compute::Cpu).bodies;
        let off = (bodies.velocity[0].x - 2.0).abs().max((bodies.position[0].x - 2.5).abs());
        assert!(off < 1e-5, "{stepping}: {} {}", bodies.velocity[0], bodies.position[0]);
    }
}

/// A row whose contacts come to light one by one, with one recursion a step: steps fail and are taken in pieces, each
/// with the wall where it is by then.
#[test]
fn pieces_of_a_step_see_the_wall_at_their_own_time() {
    let bodies: Vec<Value> = (0..5).map(|i| ball(0.5, [0.6 + 1.3 * f64::from(i), 0.0, 0.0])).collect();
    for (stepping, planar) in [("euler", true), ("midpoint", true), ("euler", false), ("midpoint", false)] {
        // The last step is a half one.
        let walls = json!([piston(&json!({"velocity": [3, 0, 0]}))]);
        let mut of = scene(1.0, 2.5, stepping, planar, &walls, &bodies);
        of["contact"]["max_recursions"] = json!(1);
        let mut simulation = started(&of);
        let mut pieces = 0;
        while !simulation.done() {
            pieces += simulation.step().unwrap().pieces;
            assert!(overlap(&simulation) <= TOLERANCE, "{:e}", overlap(&simulation));
        }
        let places: Vec<f64> = simulation.state().unwrap().bodies.position.iter().map(|x| x.x).collect();
        println!("{stepping}, planar {planar}: {pieces} pieces of 3 steps; {places:?}");
        assert!(pieces > 3, "{pieces}");
        for (i, x) in (0..).zip(places) {
            assert!((x - 8.0 - f64::from(i)).abs() < 20.0 * TOLERANCE, "{x}");
        }
    }
}

#[test]
fn a_squeeze_without_room_ends_the_run_with_the_state_before_it() {
    let stop = json!({"half_space": {"normal": [-1, 0, 0], "offset": -1.6}});
    for stepping in ["euler", "midpoint"] {
        let walls = json!([piston(&json!({"velocity": [1, 0, 0]})), stop]);
        let mut simulation = started(&scene(0.05, 2.0, stepping, true, &walls, &[ball(0.5, [1.0, 0.0, 0.0])]));
        let fault = loop {
            assert!(!simulation.done(), "there was room");
            match simulation.step() {
                Ok(_) => assert!(overlap(&simulation) <= TOLERANCE),
                Err(fault) => break fault,
            }
        };
        assert!(matches!(fault, Fault::Unresolved(_)) && fault.to_string().contains("wall"), "{fault}");
        // There is room until the piston is at 0.6.
        assert!((simulation.time() - 0.6).abs() < 0.051, "{}", simulation.time());
        let mut of = scene(0.05, 1.0, stepping, true, &walls, &[ball(0.5, [1.0, 0.0, 0.0])]);
        of["contact"]["on_failure"] = json!("continue");
        let mut simulation = started(&of);
        while !simulation.done() {
            simulation.step().unwrap();
        }
        // The ball of 1 stands in 0.6: half of what is missing is on either side.
        let at = simulation.state().unwrap().bodies.position[0].x;
        assert!((overlap(&simulation) - 0.2).abs() < 0.01 && (at - 1.3).abs() < 0.01, "{at} {}", overlap(&simulation));
    }
}

fn rods(planar: bool) -> Vec<Value> {
    let turned = |i: u32| {
        let half = 0.5 * (0.5 + 0.4 * f64::from(i));
        // About y to x, and then in the plane.
        let lying =
            glam::DQuat::from_rotation_z(2.0 * half) * glam::DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let q = if planar { lying } else { glam::DQuat::from_rotation_x(0.3 * f64::from(i)) * lying };
        json!([q.w, q.x, q.y, q.z])
    };
    let rod = |i: u32| {
        let place = [1.1 * f64::from(i % 3) - 1.1, 1.2 * f64::from(i / 3) - 0.6, 0.0];
        let shape = json!({"spherocylinder": {"diameter": 0.4, "length": 1}});
        json!({"shape": shape, "position": place, "orientation": turned(i)})
    };
    (0..6).map(rod).collect()
}

#[test]
fn moving_walls_on_a_device_are_the_cpus() {
    let turning = json!({"velocity": [0.5, 0.2, 0], "angular_velocity": [0, 0, 0.8], "window": {"from": 0.05}});
    let planar = json!([{"box": {"minimum": [-1.9, -1.5, -3], "maximum": [1.9, 1.5, 3], "motion": turning}},
        piston(&json!({"velocity": [1.5, 0, 0]}))]);
    let mut of = scene(0.02, 0.4, "euler", true, &planar, &rods(true));
    of["walls"][1]["half_space"]["offset"] = json!(-2.4);
    of["solver"] = json!({"tolerance": 1e-9});
    agrees_on_device(&parse(&of), "a box and a piston in the plane", [2e-4, 1e-7]);
    of["growth"] = json!({"rate": 0.5, "division_length": 1.1});
    agrees_on_device(&parse(&of), "the same with cells that grow and divide", [2e-4, 1e-6]);
    let turning = json!({"velocity": [2, 0, 1.5], "angular_velocity": [0.3, 0.8, 0.5]});
    let mut walls = json!([{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 2.1, "length": 2.2}}]);
    walls[0]["cylinder"]["motion"] = turning;
    let mut bodies = rods(false);
    bodies.push(json!({"shape": {"torus": {"major_radius": 0.4, "minor_radius": 0.1}}, "position": [0, 0, 0.9]}));
    let mut of = scene(0.02, 0.3, "midpoint", false, &walls, &bodies);
    of["solver"] = json!({"tolerance": 1e-9});
    agrees_on_device(&parse(&of), "a tumbling can of rods and a ring", [2e-4, 1e-7]);
    // A ball that swallows two ellipsoids, with rows as the paper makes them, and inertia.
    let motion = json!({"velocity": [2, 0, 0], "angular_velocity": [1, 2, 3], "window": {"period": 0.1, "duty": 0.7}});
    let ball = json!([{"sphere": {"center": [0, 0, 0], "radius": 1.2, "motion": motion}}]);
    let radii = json!({"ellipsoid": {"radii": [0.2, 0.3, 0.5]}});
    let egg = |z: f64| json!({"shape": radii, "position": [-0.6, 0, z], "orientation": [1, 0, 1, 0]});
    let mut of = scene(0.02, 0.3, "midpoint", false, &ball, &[egg(-0.3), egg(0.3)]);
    of["contact"]["rows"] = json!("paper");
    of["dynamics"] = json!({"inertial": {"density": 1, "drag": 2}});
    of["solver"] = json!({"tolerance": 1e-9});
    agrees_on_device(&parse(&of), "ellipsoids in a ball", [2e-4, 1e-7]);
}
