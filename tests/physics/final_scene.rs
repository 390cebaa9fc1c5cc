//! Runs that go on from the final scene of another: statistics as of one run.

use crate::removal::{assert_ancestry, followed, mother_machine};
use crate::scenes::{parse, refusal};
use glam::DVec3;
use relcp::removal::Ended;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::State;
use serde_json::{Value, json};

/// Bodies far from each other, which nothing but chance moves or removes.
fn lattice(side: usize, keys: &Value) -> Value {
    let place = |i: usize| [3.0 * (i % side) as f64, 3.0 * (i / side) as f64, 0.0];
    let bodies: Vec<Value> =
        (0..side * side).map(|i| json!({"shape": {"sphere": {"radius": 0.5}}, "position": place(i)})).collect();
    let mut of = json!({"name": "lattice", "seed": 3, "time": {"dt": 0.05, "end": 1}, "bodies": bodies});
    of.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
    of
}

/// A run of this scene, and one that goes on from its final scene for as long again.
fn in_two_runs(of: &Value) -> [(Scene, State, Vec<Ended>); 2] {
    let first = parse(of);
    let mut simulation = Simulation::new(first.clone()).unwrap();
    let mut ended = Vec::new();
    while !simulation.done() {
        simulation.step().unwrap();
        ended.extend_from_slice(simulation.ended());
    }
    let mut second = simulation.final_scene().unwrap();
    let state = simulation.state().unwrap().clone();
    second.time.end += first.time.end;
    let second = parse(&serde_json::from_str(&second.to_json()).unwrap());
    let (last, later, _) = followed(second.clone(), &Compute::Cpu);
    [(first, state, ended), (second, last, later)]
}

#[test]
fn a_run_from_the_final_scene_of_another_goes_on_with_its_deaths() {
    let [(_, middle, _), (_, last, _)] = in_two_runs(&lattice(20, &json!({"removal": [{"rate": 0.7}]})));
    for (state, time) in [(middle, 1.0), (last, 2.0)] {
        let alive = f64::exp(-0.7 * time);
        let deviation = (400.0 * alive * (1.0 - alive)).sqrt();
        let count = state.bodies.len() as f64;
        assert!((count - 400.0 * alive).abs() < 3.0 * deviation, "{count} at {time}");
    }
}

#[test]
fn a_run_from_the_final_scene_of_another_has_other_random_kicks() {
    let of = lattice(20, &json!({"thermal": {"temperature": 1e-3}}));
    let [(first, middle, _), (_, last, _)] = in_two_runs(&of);
    let start = first.build().unwrap().position;
    let moves = |from: &[DVec3], to: &[DVec3]| -> Vec<f64> {
        from.iter().zip(to).flat_map(|(from, to)| (*to - *from).to_array()).collect()
    };
    let [before, after] =
        [moves(&start, &middle.bodies.position), moves(&middle.bodies.position, &last.bodies.position)];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let correlation = dot(&before, &after) / (dot(&before, &before) * dot(&after, &after)).sqrt();
    assert!(correlation.abs() < 4.0 / (before.len() as f64).sqrt(), "{correlation}");
}

#[test]
fn a_run_from_the_final_scene_of_another_gives_no_id_twice() {
    let [(_, middle, ended), (second, last, later)] = in_two_runs(&mother_machine(9.0));
    assert_ancestry(&middle, &ended, "first");
    assert_eq!(second.build().unwrap().lineage, middle.bodies.lineage);
    let all: Vec<Ended> = ended.into_iter().chain(later).collect();
    assert!(last.next_id > middle.next_id);
    assert_ancestry(&last, &all, "both");
    // Where the last to be born are no more, the scene alone knows their ids.
    let mut gone = second.clone();
    gone.next_id = Some(middle.next_id + 7);
    let simulation = Simulation::new(gone).unwrap();
    assert_eq!(simulation.state().unwrap().next_id, middle.next_id + 7);
    assert_eq!(simulation.final_scene().unwrap().next_id, Some(middle.next_id + 7));
    let mut taken = serde_json::from_str::<Value>(&second.to_json()).unwrap();
    taken["next_id"] = json!(0);
    let (key, message) = refusal(&taken);
    assert!(key == "next_id" && message.contains("is not above"), "{key}: {message}");
}
