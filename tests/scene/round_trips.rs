//! What is written comes back to the same bits, and no text makes the reader panic.

use super::{good, set};
use proptest::prelude::*;
use relcp::scene::{self, Generate, Scene};
use relcp::shape::Shape;

#[test]
fn an_orientation_is_normalized_once() {
    let text = good().to_json().replacen("\"orientation\": [0.6532814824381883", "\"orientation\": [6.5", 1);
    let scene = Scene::parse(&text, "long").unwrap();
    let norm: f64 = scene.bodies[0].orientation.unwrap().iter().map(|x| x * x).sum();
    assert!((norm - 1.0).abs() < 1e-15);
    assert_eq!(Scene::parse(&scene.to_json(), "again").unwrap(), scene);
}

#[test]
fn a_final_scene_runs_on_from_the_same_bits() {
    let mut scene = set("two-ellipsoids", &["dynamics.inertial.density=0.7"]).unwrap();
    let mut dust = Generate::isotropic(20, Shape::Sphere { radius: 0.3 }, Some(0.1));
    if let Generate::Isotropic { group, .. } = &mut dust {
        *group = Some("dust".into());
    }
    scene.generate = vec![dust];
    let mut bodies = scene.build().unwrap();
    bodies.velocity[0] = glam::DVec3::new(0.1 + 0.2, 1.0 / 3.0, -1e-17);
    bodies.lineage[3].parent = Some(1000);
    let last = scene.final_scene(&bodies, 40.0 / 3.0);
    let again = Scene::parse(&last.to_json(), "final.json").unwrap();
    assert_eq!(again, last);
    assert_eq!(again.time.start, 40.0 / 3.0);
    let rebuilt = again.build().unwrap();
    assert_eq!(rebuilt, bodies);
    assert_eq!(again.final_scene(&rebuilt, again.time.start), again);
    // Past the end, and without inertia.
    let late = good().final_scene(&good().build().unwrap(), 50.0);
    assert_eq!((late.time.end, late.bodies[0].velocity), (50.0, None));
    late.validate().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn numbers_come_back_to_the_same_bits(x in -1e14..1e14_f64, y in 1e-50..1.0_f64, q in prop::array::uniform4(-1.0..1.0_f64)) {
        let mut scene = good();
        scene.bodies[0].position = [x, y, -y];
        scene.contact.overlap_tolerance = 0.5;
        scene.time.dt = 1.0 + y;
        prop_assume!(q.iter().any(|v| v.abs() > 1e-3));
        scene.bodies[1].orientation = Some(q);
        let once = Scene::parse(&scene.to_json(), "once").unwrap();
        prop_assert_eq!(once.bodies[0].position, scene.bodies[0].position);
        prop_assert_eq!(once.time.dt.to_bits(), scene.time.dt.to_bits());
        prop_assert_eq!(Scene::parse(&once.to_json(), "twice").unwrap(), once);
    }

    #[test]
    fn damaged_text_never_panics(which in 0..9_usize, edits in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u8, any::<u8>()), 1..6)) {
        let mut bytes = scene::BuiltIn::ALL[which].text.as_bytes().to_vec();
        for (place, how, byte) in edits {
            if bytes.is_empty() { break }
            let at = place.index(bytes.len());
            match how {
                0 => { bytes.remove(at); }
                1 => bytes.insert(at, byte),
                2 => bytes.truncate(at),
                3 => bytes[at] = b"{}[]\",:"[usize::from(byte) % 7],
                4 => bytes[at] = b'0' + byte % 10,
                5 => { let part = bytes[at..(at + usize::from(byte)).min(bytes.len())].to_vec(); bytes.splice(at..at, part); }
                _ => bytes[at] = byte,
            }
        }
        for sets in [&[][..], &["time.dt=0.5".to_owned(), "bodies.0.position.1=2".to_owned()][..]] {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("s.json");
            std::fs::write(&file, &bytes).unwrap();
            match Scene::load(&file, sets) {
                Ok(scene) => prop_assert!(scene.validate().is_ok()),
                Err(error) => prop_assert!(error.line().is_some_and(|l| l > 0) || error.origin().is_some_and(|o| o.starts_with("override ")), "{}", error),
            }
        }
    }

    #[test]
    fn overrides_never_panic(key in "[a-z.0-9_]{0,24}", value in ".{0,12}") {
        let _ = set("two-ellipsoids", &[&format!("{key}={value}")]);
        let _ = set("two-ellipsoids", &[&format!("bodies.{key}={value}")]);
    }
}
