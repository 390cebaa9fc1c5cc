//! Functions that are no bodies', and what does not take custom shapes.

use crate::bodies::{die, egg, egg_point, needles, placed};
use glam::{DMat3, DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::export::{ExportError, Format, export};
use relcp::internals::constraint::RowSourceError;
use relcp::record::{Folder, RecordError, Snapshot, StateError, States, encode};
use relcp::run::{Run, RunError};
use relcp::scene::{self, Scene};
use relcp::shape::{Convex, ConvexError, ProxyError, Shape, ShapeError};
use relcp::simulation::Simulation;
use relcp::step::{Fault, State};
use std::time::Duration;

fn refused(point: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static) -> ConvexError {
    Convex::new(point).unwrap_err()
}

#[test]
fn functions_of_no_smooth_convex_body_are_refused() {
    assert!(matches!(refused(|n| n / (1.0 - n.z.abs())), ConvexError::NotFinite { .. }));
    assert!(matches!(refused(|n| n * f64::NAN), ConvexError::NotFinite { .. }));
    assert!(matches!(refused(|n| n + 2.0 * DVec3::X), ConvexError::OriginOutside { .. }));
    assert!(matches!(refused(|n| -n), ConvexError::OriginOutside { .. }));
    // Points that have other normals: those in the normal's direction, and an ellipsoid's by stretching a ball.
    assert!(matches!(refused(|n| n * (1.0 + 0.2 * n.z * n.z)), ConvexError::NotConvex { .. }));
    assert!(matches!(refused(|n| DVec3::new(1.0, 1.0, 2.0) * n), ConvexError::NotConvex { .. }));
    // Waves of a thousandth of the size.
    let wavy = |n: DVec3| {
        let (height, slope) = (1e-3 * (40.0 * n.z).sin(), 4e-2 * (40.0 * n.z).cos());
        n * (1.0 + height - slope * n.z) + slope * DVec3::Z
    };
    assert!(matches!(refused(wavy), ConvexError::NotConvex { .. }));
    // A cube, a cube with rounded edges, and the body that two balls' surfaces have in common: flat faces, and a sharp
    // edge.
    assert!(matches!(refused(|n| n.signum()), ConvexError::Flat { .. }));
    assert!(matches!(refused(|n| 0.5 * n + n.signum()), ConvexError::Flat { .. }));
    let lens = |n: DVec3| match n.truncate().length() {
        // On the rim, the circle of radius sqrt(1 - 1/4), meet caps of half angle 60 degrees.
        across if across > 0.75_f64.sqrt() => (n.truncate() / across * 0.75_f64.sqrt()).extend(0.0),
        _ => n - DVec3::Z * 0.5 * n.z.signum(),
    };
    assert!(matches!(refused(lens), ConvexError::Sharp { .. }));
}

#[test]
fn bodies_off_their_centre_or_axes_or_of_no_sane_size_are_refused() {
    let turn = DMat3::from_rotation_z(0.3);
    let radii = DVec3::new(1.0, 2.0, 3.0);
    let tilted = move |n: DVec3| {
        let n = turn.transpose() * n;
        turn * (radii * radii * n / (radii * n).length())
    };
    assert!(matches!(refused(tilted), ConvexError::Tilted { .. }));
    assert!(matches!(refused(|n| egg_point(n) + 0.01 * DVec3::Z), ConvexError::OffCentre { .. }));
    assert!(matches!(refused(|n| 1e-70 * n), ConvexError::Shape(ShapeError::OutOfRange { .. })));
    assert!(matches!(refused(|n| 1e70 * n), ConvexError::Shape(ShapeError::OutOfRange { .. })));
    let needle = DVec3::new(1.0, 1.0, 2000.0);
    let slender = refused(move |n| needle * needle * n / (needle * n).length());
    assert!(matches!(slender, ConvexError::Shape(ShapeError::Aspect { .. })), "{slender}");
    assert!(refused(|n| needles(n, 0.1) + DVec3::X * 0.1).to_string().contains("take that from every point"));
}

fn bodies(shapes: &[Shape]) -> Bodies {
    let mut bodies = Bodies::default();
    for (i, shape) in shapes.iter().enumerate() {
        bodies.push(placed(*shape, DVec3::X * 10.0 * i as f64, DQuat::IDENTITY), NO_GROUP);
    }
    bodies
}

fn eggs() -> State {
    let bodies = bodies(&[Shape::Sphere { radius: 1.0 }, Shape::Convex(egg()), Shape::Convex(die(0.1))]);
    State { bodies, ..State::default() }
}

#[test]
fn no_file_holds_a_custom_shape() {
    let refused = encode(&eggs(), "0123456789abcdef", 0.0, None);
    assert_eq!(refused, Err(StateError::Custom { body: 1 }));
    assert_eq!(eggs().bodies.first_custom(), Some(1));
    let shape = Shape::Convex(egg());
    let (tag, sizes) = shape.code();
    assert_eq!(Shape::from_code(tag, sizes), None);
    assert!(serde_json::to_string(&shape).is_err());
    assert!(serde_json::from_str::<Shape>(r#"{"convex": null}"#).is_err());
    assert!(!scene::schema().to_string().contains("onvex"));

    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("two-ellipsoids").unwrap();
    let last = scene.final_scene(&eggs().bodies, 1.0);
    assert!(last.write_json(Vec::new()).is_err());
    let simulation = Simulation::builder(scene).bodies(eggs().bodies).build().unwrap();
    let run = Run::start(simulation, Folder::create(&folder.path().join("run")).unwrap(), Duration::ZERO);
    let Err(RunError::Record(RecordError::State { fault, .. })) = run else { panic!("the run started") };
    assert_eq!(fault, StateError::Custom { body: 1 });
    assert!(!folder.path().join("run/steps.csv").exists());
}

#[test]
fn no_export_takes_a_custom_shape() {
    let snapshot =
        Snapshot { step: 0, time: 0.0, bodies: eggs().bodies, warm: None, removed: Vec::new(), fields: Vec::new() };
    let states = States::single("eggs", snapshot);
    let folder = tempfile::tempdir().unwrap();
    for format in [Format::Vtk { cutoff: None }, Format::Gsd] {
        let error = export(&states, format, folder.path(), &mut |_, _| true).unwrap_err();
        assert!(error.to_string().contains("body 1 has a custom shape"), "{error}");
        assert!(matches!(error, ExportError::Custom { body: 1, .. }));
    }
}

#[test]
fn a_scene_made_in_code_may_hold_one_and_is_checked_but_not_written() {
    let scene = || {
        let mut scene = Scene::built_in("two-ellipsoids").unwrap();
        scene.bodies[1].shape = Shape::Convex(egg());
        scene
    };
    assert_eq!(scene().build().unwrap().shape[1].name(), "custom shape");
    assert!(scene().write_json(Vec::new()).is_err());
    let mut coarse = scene();
    coarse.contact.overlap_tolerance = 1.99 * egg().thickness();
    assert!(coarse.build().is_err());
    let mut ring = scene();
    ring.bodies[0].shape = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    assert!(ring.build().is_ok());
    let mut planar = scene();
    planar.planar = true;
    assert!(planar.build().is_ok());
    planar.bodies[1].orientation = Some([1.0, 0.0, 0.0, 0.0]);
    assert!(planar.build().is_err());
}

#[test]
fn there_is_no_proxy() {
    let egg = Shape::Convex(egg());
    assert_eq!((egg.proxy(5), egg.check_proxy(5)), (Err(ProxyError::Custom), Err(ProxyError::Custom)));
    let settings = [r#"contact.method={"multisphere":{"count":5}}"#.to_owned()];
    let scene = Scene::load("two-ellipsoids", &settings).unwrap();
    let refused = Simulation::builder(scene).bodies(eggs().bodies).build().err();
    let Some(relcp::Error::Fault(refused)) = refused else { panic!("{refused:?}") };
    assert_eq!(refused, Fault::NoProxy(RowSourceError { body: 1, source: ProxyError::Custom }));
}
