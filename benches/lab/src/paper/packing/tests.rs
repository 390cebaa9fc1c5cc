use super::*;
use relcp::internals::simulation;
use relcp::scene::{Drag, Dynamics};
use relcp::simulation::Compute;
use relcp::step::State;

#[test]
fn rods_of_the_lattice_are_clear_of_each_other_and_move_as_fast_as_the_field() {
    let scene = scene(3, 0.1).unwrap();
    assert_eq!((scene.bodies.len(), &*scene.name), (27, "packing-27"));
    assert!(
        matches!(scene.dynamics, Dynamics::Overdamped { drag: Drag::Even(drag) } if (drag * 1.5 - 1.0).abs() < 1e-15)
    );
    let bodies = scene.build().unwrap();
    assert!(relcp::step::contacts(&bodies, 0.0).is_empty());
    assert!((bodies.position.iter().sum::<glam::DVec3>()).length() < 1e-12);
    // Orientations have no common direction: the mean of the dyads of 1,000 axes is a third of the identity but for 1 /
    // sqrt(1000).
    let many = super::scene(10, 0.1).unwrap().build().unwrap();
    let square = many.orientation.iter().map(|q| (*q * glam::DVec3::Z).powf(2.0)).sum::<glam::DVec3>() / 1000.0;
    assert!((square - 1.0 / 3.0).abs().max_element() < 0.05, "{square}");
    let far = simulation::start(&Compute::Cpu, scene.clone(), State::new(bodies)).and_then(|mut simulation| {
        simulation.step()?;
        Ok(simulation.state()?.bodies.velocity[0])
    });
    // A corner at r has the speed 1 - sin r / r.
    let r = 1.6 * 3f64.sqrt();
    assert!((far.unwrap().length() - (1.0 - r.sin() / r)).abs() < 1e-9);
}

#[test]
fn a_tiny_packing_is_measured() {
    let mut study = Study::begin(Size { sides: &[2], steps: &[0.2, 0.1] }).unwrap();
    let said: Vec<String> = std::iter::from_fn(|| study.next_run().unwrap()).collect();
    assert!(said.len() == 2 && said[0].starts_with("8 rods, dt 0.2: "), "{said:?}");
    let [coarse, fine] = study.runs() else { panic!("{said:?}") };
    assert_eq!((coarse.summary.steps, fine.summary.steps, fine.summary.windows.len()), (75, 150, 150));
    assert!(coarse.summary.max_overlap > 0.0 && coarse.summary.last_overlap <= 1e-5 && !study.missed());
    let (a, b) = (coarse.gyration.unwrap(), fine.gyration.unwrap());
    assert!((a / b - 1.0).abs() < 0.1 && a < 1.2, "{a} {b}");
    // Without 1,000 rods nothing is said of the engines' radius and overlap.
    let met: Vec<Option<bool>> = study.targets().iter().map(|target| target.met).collect();
    assert_eq!(met, [Some(true), None, None]);
    assert!(study.page().contains("| 8 | 0.2 | 75 |"), "{}", study.page());
    let files = study.files().unwrap();
    let text = |name: &str| String::from_utf8(files.iter().find(|file| file.0 == name).unwrap().1.clone()).unwrap();
    assert_eq!((text("packing.csv").lines().count(), text("packing-steps.csv").lines().count()), (3, 226));
    let read = relcp::scene::Scene::parse(&text("packing-8-scene.json"), "").unwrap();
    assert_eq!((read.bodies.len(), read.time.dt), (8, 0.1));
    assert!(study.plots().unwrap()[0].1.svg().starts_with("<svg"));
    assert_eq!(study.numbers().unwrap()["runs"][0]["course"]["steps"], 75);
}

/// A measured line.
fn line(engine: &str, dt: f64, overlap: f64, gyration: f64) -> Engine {
    let line = serde_json::json!({
        "scene": "rods-1000", "engine": engine, "version": "1", "settings_name": "default", "dt": dt, "steps": 100,
        "cpu_s": 2.0, "max_overlap": overlap, "gyration": gyration, "date": "2026-11-24", "machine": "one",
    });
    serde_json::from_value(line).unwrap()
}

#[test]
fn the_measured_engines_are_read() {
    let engines = engines().unwrap();
    // This program at three steps, and others at the same.
    for dt in [0.1, 0.02, 0.005] {
        let ours = engines.iter().find(|run| run.is_ours() && run.dt == dt && run.settings_name == "1e-5").unwrap();
        assert!(ours.cost().unwrap().1 <= 1.001e-5, "{ours:?}");
        assert!(engines.iter().any(|run| !run.is_ours() && run.dt == dt && run.cost().is_some()));
    }
    assert!(engines.iter().all(|run| run.cost().is_some() || run.ended.is_some() || run.max_overlap.is_none()));
    // Every line is on the page.
    let page = Study::begin(Size::QUICK).unwrap().page();
    for run in &engines {
        assert!(page.contains(&format!("| {} | {} |", run.name(), run.dt)), "{run:?}");
    }
}

#[test]
fn what_misses_is_said_to() {
    let mut study = Study::begin(Size { sides: &[2], steps: &[0.5] }).unwrap();
    study.engines = vec![
        line("relcp", 0.1, 1e-5, 3.5),
        line("near", 0.1, 1e-3, 3.49),
        // Ends elsewhere: no measure.
        line("far", 0.1, 1e-7, 4.5),
    ];
    study.next_run().unwrap();
    study.runs[0].summary.bodies = 1000;
    study.runs[0].gyration = Some(3.5);
    study.runs[0].summary.max_overlap = 2e-5;
    let met = |study: &Study| study.targets().iter().map(|target| target.met).collect::<Vec<_>>();
    assert_eq!(met(&study), [Some(false), Some(true), Some(true)]);
    assert!(study.missed() && study.page().contains("| near 1, default | 0.1 | 20.0 | 2.0 | 1.0e-3 | 3.490 |"));
    study.runs[0].gyration = Some(3.4);
    study.runs[0].summary.max_overlap = 1e-3;
    assert_eq!(met(&study), [Some(false), Some(false), Some(false)]);
    study.engines[1].ended = Some("stopped after 5 s".into());
    assert!(study.page().contains("| near 1, default | 0.1 | | | | stopped after 5 s |"));
}
