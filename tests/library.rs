//! What a program that uses the library meets first: scenes in code, the builder, contacts, errors.
#![allow(clippy::unwrap_used)]

use relcp::gpu::GpuError;
use relcp::scene::{Body, Dump, DumpWhen, FaultKind, Growth, NO_OVERRIDES, Periodic, Time, Wall};
use relcp::{Bodies, Compute, Error, Fault, Scene, Shape, Simulation, State};
use std::error::Error as _;

const BALL: Shape = Shape::Sphere { radius: 0.5 };

fn capsules() -> Scene {
    Scene::built_in("three-capsules").unwrap()
}

fn to_end(mut simulation: Simulation) -> State {
    while !simulation.done() {
        simulation.step().unwrap();
    }
    simulation.state().unwrap().clone()
}

#[test]
fn a_builder_starts_from_a_scene_from_bodies_and_from_a_state_to_the_same_bits() {
    let whole = to_end(Simulation::new(capsules()).unwrap());
    let bodies = capsules().build().unwrap();
    assert_eq!(to_end(Simulation::builder(capsules()).bodies(bodies.clone()).build().unwrap()), whole);
    assert_eq!(to_end(Simulation::builder(capsules()).on(&Compute::Cpu).build().unwrap()), whole);
    let mut half = Simulation::new(capsules()).unwrap();
    (0..4).for_each(|_| assert!(half.step().is_ok()));
    let state = half.state().unwrap().clone();
    let resumed = Simulation::builder(capsules()).bodies(bodies.clone()).resume(state).build().unwrap();
    assert_eq!(resumed.steps(), 4, "the start that was given last counts");
    assert_eq!(to_end(resumed), whole);
    assert_eq!(State::new(bodies), *Simulation::new(capsules()).unwrap().state().unwrap());
}

#[test]
fn a_builder_refuses_what_its_scene_and_its_bodies_cannot_do() {
    let mut bad = capsules();
    bad.time.dt = -1.0;
    assert!(matches!(Simulation::new(bad), Err(Error::Scene(error)) if error.key() == "time.dt"));
    let mut bodies = capsules().build().unwrap();
    let settings = ["contact.method={\"multisphere\":{\"count\":5}}".to_owned()];
    let scene = Scene::load("three-capsules", &settings).unwrap();
    bodies.shape[0] = Shape::Ellipsoid { radii: [1.0, 1.0, 0.5] };
    let refused = Simulation::builder(scene).bodies(bodies).build();
    assert!(matches!(refused, Err(Error::Fault(Fault::NoProxy(_)))), "{:?}", refused.err());
}

#[test]
fn scenes_made_in_code_have_the_defaults_of_a_file() {
    let text = r#"{ "name": "x", "time": { "dt": 0.1, "end": 1 }, "solver": { "dump": { "when": "slow" } },
        "periodic": { "lengths": [9, null, null] }, "growth": { "rate": 1, "division_length": 4 },
        "bodies": [ { "shape": { "spherocylinder": { "diameter": 0.5, "length": 2 } }, "position": [1, 0, 0] } ] }"#;
    let mut scene = Scene::new("x", Time::new(0.1, 1.0));
    scene.solver.dump = Some(Dump::new(DumpWhen::Slow));
    scene.periodic = Some(Periodic::new([Some(9.0), None, None]));
    scene.growth = vec![Growth::new(1.0, 4.0)];
    scene.bodies.push(Body::new(Shape::Spherocylinder { diameter: 0.5, length: 2.0 }, [1.0, 0.0, 0.0]));
    assert_eq!(scene, Scene::parse(text, "x").unwrap());
}

#[test]
fn overrides_are_anything_that_yields_text() {
    let dt = |scene: Scene| scene.time.dt;
    assert_eq!(dt(Scene::load("colony", ["time.dt=0.5"]).unwrap()), 0.5);
    assert_eq!(dt(Scene::load("colony", vec![String::from("time.dt=0.5")]).unwrap()), 0.5);
    assert_eq!(dt(Scene::load("colony", (1..3).map(|n| format!("time.dt={}", 0.25 * f64::from(n)))).unwrap()), 0.5);
    assert_eq!(Scene::load("colony", NO_OVERRIDES).unwrap(), Scene::built_in("colony").unwrap());
}

#[test]
fn a_built_in_scene_that_is_not_there_is_refused_with_the_nearest() {
    let refused = Scene::built_in("colny").unwrap_err();
    assert_eq!(refused.kind(), FaultKind::UnknownScene);
    assert!(refused.to_string().contains("`colny`") && refused.help_text().unwrap().contains("`colony`"));
    assert!(Scene::built_in("Cargo.toml").is_err());
}

#[test]
fn the_points_of_a_contact_are_its_separation_apart_also_at_an_image() {
    let mut scene = Scene::new("pair", Time::new(0.1, 1.0));
    scene.periodic = Some(Periodic::new([Some(6.0), None, None]));
    scene.bodies = vec![Body::new(BALL, [-2.4, 0.0, 0.0]), Body::new(BALL, [2.4, 0.0, 0.0])];
    let bodies = scene.build().unwrap();
    let near = relcp::contacts(&bodies, 0.3);
    assert_eq!((near.len(), near[0].bodies, near[0].image.to_array()), (1, [0, 1], [-1, 0, 0]));
    let [a, b] = near[0].points(&bodies);
    assert!((a.x + 2.9).abs() < 1e-12 && (b.x + 3.1).abs() < 1e-12, "{a} {b}");
    assert!(((b - a).dot(near[0].normal) - near[0].separation).abs() < 1e-12);
}

#[test]
fn the_point_of_a_wall_contact_lies_on_the_body() {
    let mut scene = Scene::new("ball", Time::new(0.1, 1.0));
    scene.walls =
        vec![Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: 0.0, motion: None, friction: None, load: None }];
    scene.bodies = vec![Body::new(BALL, [1.0, 2.0, 0.75])];
    let simulation = Simulation::new(scene).unwrap();
    let bodies: &Bodies = &simulation.state().unwrap().bodies;
    let near = simulation.wall_contacts(0.3).unwrap();
    assert_eq!((near.len(), near[0].body, near[0].wall, near[0].separation), (1, 0, 0, 0.25));
    assert_eq!(near[0].point(bodies).to_array(), [1.0, 2.0, 0.25]);
}

#[test]
fn one_error_takes_all_and_keeps_message_and_source() {
    fn any() -> Result<(), Error> {
        Shape::Sphere { radius: 1.0 }.validate()?;
        Shape::Sphere { radius: 1.0 }.check_proxy(1)?;
        let folder = tempfile::tempdir()?;
        let simulation = Simulation::new(Scene::load("three-capsules", ["time.end=0.02"])?)?;
        let run = relcp::record::Folder::create(&folder.path().join("run"))?;
        relcp::run::Run::start(simulation, run, std::time::Duration::ZERO)?.advance()?;
        let states = relcp::record::States::open("three-capsules")?;
        relcp::export::gsd(&states, &folder.path().join("x.gsd"), &mut |_, _| true)?;
        relcp::record::read_lcp(&folder.path().join("none.npz"))?;
        Ok(())
    }
    let error = any().unwrap_err();
    assert!(matches!(error, Error::Record(_)) && error.to_string().contains("none.npz"), "{error}");
    assert!(error.source().is_some_and(|system| system.is::<std::io::Error>()));
    let device = Error::from(GpuError::OutOfMemory { what: "rows".into() });
    assert!(device.to_string().contains("rows") && device.source().is_none());
}

#[test]
fn errors_of_the_library_name_no_options_of_the_program() {
    for error in [
        GpuError::NotBuilt.to_string(),
        GpuError::NoF64 { adapter: "x".into() }.to_string(),
        GpuError::Lost { reason: "x".into() }.to_string(),
        GpuError::Hang { seconds: 1 }.to_string(),
        Scene::load("colony", ["time.dtt=1"]).unwrap_err().to_string(),
    ] {
        assert!(!error.contains("--"), "{error}");
    }
}
