//! The built-in scenes: they are read, built and written, and have the paper's numbers.

use super::set;
use relcp::bodies::Bodies;
use relcp::internals::dynamics::grow;
use relcp::scene::{self, Scene};
use relcp::simulation::Simulation;

#[test]
fn built_in_scenes_are_read_built_and_come_back() {
    for entry in scene::BuiltIn::ALL {
        let read = Scene::parse(entry.text, entry.name).unwrap();
        assert_eq!(read.name, entry.name);
        let written = read.to_json();
        assert_eq!(Scene::parse(&written, "written").unwrap(), read, "{}", entry.name);
        assert_eq!(Scene::parse(&written, "written").unwrap().to_json(), written);
        let resolved = read.with_defaults();
        assert_eq!(Scene::parse(&resolved.to_json(), "resolved").unwrap(), resolved);
        let bodies = read.build().unwrap();
        assert_eq!(bodies.len() as u64, read.body_count());
        let states = (read.time.end - read.time.start) / read.output_every().unwrap();
        assert!(states <= 100.5, "{}: {states} states", entry.name);
    }
}

#[test]
fn the_paper_s_numbers_stand_in_the_scenes() {
    let colony = Scene::built_in("colony-full").unwrap();
    assert_eq!(colony.growth[0].division_length, Some(4.0));
    // 17 generations end at 17 ln 2.
    assert!(colony.time.end > 17.0 * std::f64::consts::LN_2 && colony.time.end < 18.0 * std::f64::consts::LN_2);
    let colony = Scene::built_in("colony").unwrap();
    assert!(colony.time.end > 9.0 * std::f64::consts::LN_2 && colony.time.end < 10.0 * std::f64::consts::LN_2);
    assert_eq!(Scene::built_in("three-capsules").unwrap().time.steps(), 8);
    assert_eq!(Scene::built_in("compaction-full").unwrap().body_count(), 10_000);
}

/// Bodies at the end of a scene's run, from its growth alone.
fn grown_to_the_end(scene: &Scene) -> Bodies {
    let (mut bodies, growth, time) = (scene.build().unwrap(), scene.growth[0].clone(), scene.time);
    let mut next_id = bodies.len() as u64;
    for step in 0..time.steps() {
        grow(&mut bodies, &growth, scene.planar, scene.seed, time.after(step), time.dt, &mut next_id);
    }
    bodies
}

#[test]
fn the_colony_ends_with_512_cells_under_either_law() {
    let colony = Scene::built_in("colony").unwrap();
    let bodies = grown_to_the_end(&colony);
    assert_eq!(bodies.len(), 512);
    assert!(bodies.lineage.iter().all(|l| l.generation == 9));
    // Nine doublings take 9 ln 2 = 6.2383; a cell divides at the start of the step after it has reached its length.
    let early = set("colony", &["time.end=6.239"]).unwrap();
    assert_eq!(grown_to_the_end(&early).len(), 256);
    let inertial = set("colony", &["dynamics.inertial.density=1"]).unwrap();
    assert_eq!(grown_to_the_end(&inertial).len(), 512);
}

#[test]
fn ids_of_parents_are_not_given_again() {
    let scene = Scene::built_in("three-capsules").unwrap();
    let mut bodies = scene.build().unwrap();
    bodies.lineage[1].parent = Some(41);
    assert_eq!(Simulation::builder(scene).bodies(bodies).build().unwrap().state().unwrap().next_id, 42);
}
