//! Bodies that lock: a rod between two walls, whose contact points are on a line at less than the angle of friction
//! from the walls' normals, cannot slip. If it grows, the law has no solution with bounded forces.

use crate::scenes::{parse, start};
use relcp::Simulation;
use serde_json::{Value, json};

/// A rod of length 4 and diameter 1 that grows in a channel, its axis this many degrees from the walls' normals.
fn growing(degrees: f64, mu: f64, growth: Value) -> Value {
    let mut growth = growth;
    (growth["rate"], growth["division_length"]) = (json!(0.2), json!(20.0));
    let width = 1.0 + 3.0 * degrees.to_radians().cos();
    json!({"name": "locked", "planar": true, "time": {"dt": 0.01, "end": 0.5}, "dynamics": {"overdamped": {"drag": 1.0}},
        "contact": {"friction": mu}, "growth": growth,
        "walls": [{"channel": {"center": [0, 0, 0], "normal": [0, 1, 0], "width": width}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 1.0, "length": 4.0}}, "position": [0, 0, 0],
            "angle": 90.0 - degrees}]})
}

/// The tangent of the angle between the line of the contact points and the walls' normals.
fn tangent(degrees: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    3.0 * sin / (3.0 * cos + 1.0)
}

/// Steps until the end or a fault; returns the simulation, its largest force, and the fault.
fn to_end(scene: &Value) -> (Simulation, f64, Option<String>) {
    let (mut simulation, mut most) = (start(scene), 0.0_f64);
    while !simulation.done() {
        if let Err(fault) = simulation.step() {
            return (simulation, most, Some(fault.to_string()));
        }
        most = simulation.state().unwrap().warm.iter().fold(most, |most, warm| most.max(warm.gamma));
    }
    (simulation, most, None)
}

fn length(simulation: &Simulation) -> f64 {
    simulation.state().unwrap().bodies.shape[0].growing_length().unwrap()
}

#[test]
fn a_rod_that_locks_as_it_grows_stops_the_run_in_place_of_forces_without_bound() {
    for degrees in [20.0, 35.0, 50.0] {
        let scene = growing(degrees, 0.8, json!({}));
        assert!(tangent(degrees) < 0.8);
        let (simulation, most, fault) = to_end(&scene);
        let fault = fault.expect("it cannot grow");
        assert!(fault.contains("no room") && fault.contains("lock: no friction forces"), "{fault}");
        assert!(fault.contains("growth.stress_sensitivity"), "{fault}");
        assert!(most < 1e6 && length(&simulation) < 4.01, "{degrees}: {most:e}");
    }
}

#[test]
fn a_rod_that_can_slip_grows_on_under_bounded_forces() {
    for (degrees, mu) in [(55.0, 0.8), (20.0, 0.2), (45.0, 0.6)] {
        assert!(tangent(degrees) > mu);
        let (simulation, most, fault) = to_end(&growing(degrees, mu, json!({})));
        assert_eq!(fault, None);
        assert!(length(&simulation) > 4.05);
        assert!(most < 1e4, "{degrees}: {most:e}");
    }
}

#[test]
fn a_rod_that_locks_waits_where_growth_may_wait_or_feels_pressure() {
    for growth in [json!({"on_no_room": "stall"}), json!({"stress_sensitivity": 0.05})] {
        for degrees in [20.0, 50.0] {
            let (simulation, most, fault) = to_end(&growing(degrees, 0.8, growth.clone()));
            assert_eq!(fault, None);
            assert!(most < 1e6 && length(&simulation) < 4.01, "{growth} {degrees}: {most:e}");
        }
        let (simulation, _, fault) = to_end(&growing(55.0, 0.8, growth.clone()));
        assert_eq!(fault, None);
        assert!(length(&simulation) > 4.05, "{growth}");
    }
}

#[test]
fn a_rod_that_walls_close_on_within_the_angle_of_friction_stops_the_run() {
    let mut scene = growing(35.0, 0.8, json!({}));
    scene.as_object_mut().unwrap().remove("growth");
    let down = json!({"velocity": [0, -0.2, 0]});
    let half = 0.5 * scene["walls"][0]["channel"]["width"].as_f64().unwrap();
    scene["walls"] = json!([{"half_space": {"normal": [0, 1, 0], "offset": -half}},
        {"half_space": {"normal": [0, -1, 0], "offset": -half, "motion": down}}]);
    parse(&scene);
    let (_, most, fault) = to_end(&scene);
    let fault = fault.expect("it has no room");
    assert!(fault.contains("lock: no friction forces") && fault.contains("a smaller contact.friction"), "{fault}");
    assert!(most < 1e6, "{most:e}");
}

/// Twelve planar rings about the middle of a circle that has no room for them apart. With friction each solve was cut
/// off before it showed that, and step 1 appended thousands of rows in hours.
#[test]
fn bodies_without_room_at_the_start_stop_the_run_as_soon_as_without_friction() {
    let ring = |i: u32| {
        let (angle, from) = (2.4 * f64::from(i), 0.12 * f64::from(i).sqrt());
        json!({"shape": {"torus": {"major_radius": 0.6, "minor_radius": 0.15}},
            "position": [from * angle.cos(), from * angle.sin(), 0]})
    };
    let bodies: Vec<Value> = (0..12).map(ring).collect();
    let scene = json!({"name": "rings", "planar": true, "time": {"dt": 0.01, "end": 0.05},
        "dynamics": {"inertial": {"density": 1.0}}, "contact": {"friction": 0.5}, "bodies": bodies,
        "walls": [{"sphere": {"center": [0, 0, 0], "radius": 1.5}}]});
    let (_, _, fault) = to_end(&scene);
    assert!(fault.as_deref().is_some_and(|fault| fault.contains("bodies 0 and 1 still overlap by 0.3")), "{fault:?}");
}
