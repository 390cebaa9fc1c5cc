//! What a scene is warned of.

use relcp::dynamics::{Dynamics, Flow, Force, Thermal};
use relcp::scene::{Body, Generate, Time};
use relcp::{Scene, Shape};

fn balls(count: usize) -> Scene {
    let mut scene = Scene::new("balls", Time::new(0.01, 1.0));
    let ball = |i: usize| Body::new(Shape::Sphere { radius: 0.5 }, [2.0 * i as f64, 0.0, 0.0]);
    scene.bodies = (0..count).map(ball).collect();
    scene
}

#[test]
fn a_time_step_in_which_a_force_moves_a_body_by_its_thickness_is_remarked_on() {
    let mut scene = balls(1);
    scene.forces.push(Force::Uniform { force: [0.0, 99.0, 0.0], group: None, window: None });
    // Drag 1 a length, of 1.
    assert_eq!(scene.warnings(), [""; 0]);
    scene.time.dt = 0.1;
    let warnings = scene.warnings();
    assert!(warnings[0].contains("forces.0 moves a body by 9.9 of its thicknesses"), "{warnings:?}");
    assert!(warnings[0].ends_with("with 0.001 it is a tenth"), "{warnings:?}");
}

#[test]
fn a_time_step_in_which_a_body_flies_by_its_thickness_is_remarked_on() {
    let mut scene = balls(2);
    scene.bodies[1].velocity = Some([0.0, 300.0, 0.0]);
    assert_eq!(scene.warnings(), [""; 0], "velocities mean nothing without inertia");
    scene.dynamics = Dynamics::Inertial { density: 1.0, drag: None };
    let warnings = scene.warnings();
    assert!(warnings[0].contains("bodies.1.velocity carries a body by 3 of its thicknesses"), "{warnings:?}");
}

#[test]
fn a_time_step_in_which_cells_grow_or_a_flow_shears_by_a_large_part_is_remarked_on() {
    let mut scene = balls(2);
    scene.flow = Some(Flow::Shear { rate: -50.0, direction: [1.0, 0.0, 0.0], gradient: [0.0, 1.0, 0.0] });
    let warnings = scene.warnings();
    assert!(
        warnings[0].contains("the flow or the cell strains by 50 % in a step; with 2e-4 it is 1 %"),
        "{warnings:?}"
    );
    scene.time.dt = 0.0005;
    assert_eq!(scene.warnings(), [""; 0]);
    let moving = r#"{"half_space": {"normal": [1, 0, 0], "offset": -9, "motion": {"velocity": [4000, 0, 0]}}}"#;
    scene.walls.push(serde_json::from_str(moving).unwrap());
    assert!(scene.warnings()[0].contains("walls.0.motion moves a body by 2 of its thicknesses"));
}

#[test]
fn a_crowd_with_inertia_and_heat_is_said_to_be_colder() {
    let mut scene = balls(2);
    scene.thermal = Some(Thermal::new(1e-6));
    assert_eq!(scene.warnings(), [""; 0]);
    scene.dynamics = Dynamics::Inertial { density: 1.0, drag: Some(1.0.into()) };
    assert!(scene.warnings()[0].contains("colder than thermal.temperature"));
    scene.bodies.pop();
    assert_eq!(scene.warnings(), [""; 0]);
}

#[test]
fn rules_whose_bodies_are_not_mixed_are_remarked_on() {
    let rule = |count, radius| Generate::isotropic(count, Shape::Sphere { radius }, Some(0.1));
    let mut scene = balls(0);
    scene.generate = vec![rule(80, 0.5), rule(10, 1.0)];
    assert_eq!(scene.warnings(), [""; 0], "both in the same box");
    scene.generate[1] = rule(80, 1.0);
    assert!(scene.warnings()[0].starts_with("generate.0 and generate.1 place bodies about the origin in boxes 7.48"));
}
