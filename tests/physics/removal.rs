//! Bodies that leave: through the borders of a region, and by death at a rate.

use crate::device::{device, precisions};
use crate::scenes::{ALONG_X, agrees_on_device, apart, laws, parse, refusal, run};
use relcp::measure::{Settings, measure, select};
use relcp::record::{Folder, LifeRow, States};
use relcp::removal::{Cause, Ended};
use relcp::run::{Run, RunStatus};
use relcp::scene::{Scene, StopReason};
use relcp::simulation::{Compute, Simulation};
use relcp::step::State;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

fn with(mut body: Value, keys: &Value) -> Value {
    body.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
    body
}

fn sphere(radius: f64, position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": radius}}, "position": position})
}

/// What computes: the CPU, and the device in each of its precisions.
fn computes() -> Vec<(String, Compute)> {
    let mut all = vec![("cpu".to_owned(), Compute::Cpu)];
    if let Some(gpu) = device() {
        let of = |precision| (format!("{precision:?}"), Compute::Gpu { gpu: gpu.clone(), precision });
        all.extend(precisions(gpu).into_iter().map(of));
    }
    all
}

/// A run to its end: its state, the lives that ended, and how many bodies there were after each step.
pub fn followed(scene: Scene, compute: &Compute) -> (State, Vec<Ended>, Vec<usize>) {
    let tolerance = scene.contact.overlap_tolerance;
    let mut simulation = Simulation::builder(scene).on(compute).build().unwrap();
    let (mut ended, mut counts) = (Vec::new(), Vec::new());
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= tolerance, "{report:?}");
        let removed = simulation.ended().iter().filter(|life| life.cause != Cause::Division).count();
        assert_eq!((report.removed, report.bodies), (removed, simulation.bodies()));
        ended.extend_from_slice(simulation.ended());
        counts.push(report.bodies);
    }
    let state = simulation.state().unwrap().clone();
    assert_eq!(state.removed.iter().sum::<u64>(), simulation.removed());
    (state, ended, counts)
}

/// Every id that was ever given lived once, and either is alive or ended once; every parent divided into two.
pub fn assert_ancestry(state: &State, ended: &[Ended], name: &str) {
    let mut parents = BTreeMap::new();
    let lines = ended.iter().map(|life| life.line).chain(state.bodies.lineage.iter().copied());
    for line in lines {
        assert!(parents.insert(line.id, line.parent).is_none(), "{name}: {} lived twice", line.id);
    }
    assert_eq!(parents.keys().copied().collect::<Vec<_>>(), (0..state.next_id).collect::<Vec<_>>(), "{name}");
    let divided: BTreeSet<u64> = ended.iter().filter(|life| life.cause == Cause::Division).map(|l| l.line.id).collect();
    let mut children = BTreeMap::<u64, usize>::new();
    parents.values().flatten().for_each(|parent| *children.entry(*parent).or_default() += 1);
    assert!(children.values().all(|count| *count == 2), "{name}");
    assert_eq!(children.keys().copied().collect::<BTreeSet<_>>(), divided, "{name}");
    for life in ended {
        assert!(life.line.birth <= life.time, "{name}: {life:?}");
    }
}

/// Of bodies that die at a rate `exp(-rate t)` are left; who that is depends on seed, id and step alone.
#[test]
fn bodies_die_at_a_rate() {
    let (side, rate, dt) = (28_u32, 0.6_f64, 0.05);
    let spot = |k: u32| {
        let group = if k.is_multiple_of(2) { "slow" } else { "fast" };
        with(sphere(0.3, [f64::from(k % side), f64::from(k / side), 0.0]), &json!({"group": group}))
    };
    let bodies: Vec<Value> = (0..side * side).map(spot).collect();
    let of = json!({"name": "mortal", "seed": 1, "time": {"dt": dt, "end": 2.0}, "bodies": bodies,
        "removal": [{"rate": rate}, {"rate": rate, "group": "fast"}]});
    let scene = parse(&of);
    let reference = followed(scene.clone(), &Compute::Cpu);
    let (state, ended, counts) = &reference;
    for (group, rate) in [(0_u32, rate), (1, 2.0 * rate)] {
        for time in [0.5, 1.0, 2.0] {
            let gone = ended.iter().filter(|life| life.group == group && life.time <= time + 1e-9).count();
            let (all, part) = (f64::from(side * side / 2), (-rate * time).exp());
            let alive = all - gone as f64;
            let off = (alive - all * part) / (all * part * (1.0 - part)).sqrt();
            println!("rate {rate}, time {time}: {alive} alive of {:.1}, {off:.2} standard errors", all * part);
            assert!(off.abs() < 3.0, "{off}");
        }
    }
    // Half as long steps: the same law.
    let mut fine = of.clone();
    fine["time"]["dt"] = json!(0.5 * dt);
    let (finer, ..) = followed(parse(&fine), &Compute::Cpu);
    let part = (0.5 * ((-rate * 2.0).exp() + (-2.0 * rate * 2.0).exp())) * f64::from(side * side);
    assert!((finer.bodies.len() as f64 - part).abs() < 3.5 * part.sqrt(), "{} of {part}", finer.bodies.len());
    assert_eq!(counts.last().copied(), Some(state.bodies.len()));
    assert_ancestry(state, ended, "mortal");
    for (name, compute) in computes().into_iter().skip(1) {
        let (ours, lives, numbers) = followed(scene.clone(), &compute);
        assert!(
            (ours.bodies.lineage, lives, numbers) == (state.bodies.lineage.clone(), ended.clone(), counts.clone()),
            "{name}"
        );
    }
}

/// A mother machine: a channel with a closed end, in which a row of cells grows out of the open one.
pub fn mother_machine(end: f64) -> Value {
    let cell =
        json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0.7, 0, 0], "angle": 0});
    json!({"name": "mother", "seed": 3, "planar": true, "time": {"dt": 0.02, "end": end}, "bodies": [cell],
        "dynamics": {"overdamped": {"drag": 20.0}},
        "growth": {"rate": 1.0, "rule": "adder", "added_length": 1.0, "added_length_noise": 0.2, "reorientation_degrees": 1},
        "walls": [{"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 0.6}},
                  {"half_space": {"normal": [1, 0, 0], "offset": 0}}],
        "removal": [{"outside": {"half_space": {"normal": [-1, 0, 0], "offset": -6}}}]})
}

#[test]
fn a_mother_machine_holds_its_number_and_its_ancestry() {
    let scene = parse(&mother_machine(9.0));
    let (state, ended, counts) = followed(scene.clone(), &Compute::Cpu);
    // Cells of a length from 1 to 2 on average stand in a row 6 long, and the last one may stick out.
    let steady = &counts[counts.len() / 2..];
    let [least, most] = [*steady.iter().min().unwrap(), *steady.iter().max().unwrap()];
    let removed = ended.iter().filter(|life| life.cause == Cause::Outside).count();
    println!("{least} to {most} cells, {removed} removed, {} lived", state.next_id);
    assert!(least >= 3 && most <= 7 && removed >= 15, "{least} {most} {removed}");
    assert!(state.bodies.position.iter().all(|x| x.x <= 6.0 && x.x > 0.0));
    assert_ancestry(&state, &ended, "cpu");
    // In a steady row as many leave as are born, and each division adds one.
    let divisions = ended.iter().filter(|life| life.cause == Cause::Division).count();
    assert_eq!(state.bodies.len(), 1 + divisions - removed);
    for (name, compute) in computes().into_iter().skip(1) {
        let (ours, lives, numbers) = followed(parse(&mother_machine(4.0)), &compute);
        let (cpu, of_cpu, of_steps) = followed(parse(&mother_machine(4.0)), &Compute::Cpu);
        assert!((&ours.bodies.lineage, &lives, &numbers) == (&cpu.bodies.lineage, &of_cpu, &of_steps), "{name}");
        assert!(
            lives.iter().any(|life| life.cause == Cause::Outside) && apart(&ours.bodies, &cpu.bodies) < 2e-3,
            "{name}"
        );
    }
}

/// Rods, growing cells and balls among fixed bodies, pushed out of a box, through a hole, and dying.
fn crowd(planar: bool, law: &Value, stepping: &str) -> Value {
    let mut bodies = Vec::new();
    for i in 0..6_u32 {
        let (x, z) = (f64::from(i) * 1.3, if planar { 0.0 } else { 0.1 * f64::from(i) });
        let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [x, 0.0, z], "orientation": ALONG_X});
        bodies.push(with(sphere(0.35, [x, 0.8, z]), &json!({"group": "balls"})));
        bodies.push(with(sphere(0.3, [x + 0.65, -0.9, z]), &json!({"fixed": true})));
        bodies.push(with(rod, &json!({"group": "cells"})));
    }
    json!({"name": "crowd", "seed": 4, "planar": planar, "time": {"dt": 0.02, "end": 0.8, "stepping": stepping},
        "dynamics": law, "bodies": bodies,
        "growth": [{"group": "cells", "rate": 1.0, "division_length": 1.6, "division_length_noise": 0.2, "reorientation_degrees": 5}],
        "forces": [{"uniform": {"force": [2.0, -1.0, 0.0], "group": "balls"}}, {"uniform": {"force": [1.5, 0, 0], "group": "cells"}}],
        "walls": [{"half_space": {"normal": [0, 1, 0], "offset": -1.3}}],
        "removal": [{"outside": {"box": {"minimum": [-9, -9, -9], "maximum": [6.8, 9, 9]}}},
                    {"inside": {"sphere": {"center": [2.5, 0.3, 0.0], "radius": 0.4}}, "group": "balls"},
                    {"rate": 0.3, "group": "cells"}]})
}

#[test]
fn a_crowd_that_leaves_is_the_cpus_on_a_device_and_resumes_to_the_same_bits() {
    for (planar, law, stepping) in
        [(true, 0, "euler"), (false, 0, "midpoint"), (true, 1, "midpoint"), (false, 1, "euler")]
    {
        let scene = parse(&crowd(planar, &laws()[law], stepping));
        let name = format!("planar {planar}, {}, {stepping}", laws()[law]);
        let (state, ended, _) = followed(scene.clone(), &Compute::Cpu);
        let causes: Vec<Cause> = ended.iter().map(|life| life.cause).collect();
        println!("{name}: {} left, {causes:?}", state.bodies.len());
        assert!(causes.contains(&Cause::Outside) && causes.contains(&Cause::Rate), "{name}: {causes:?}");
        assert_ancestry(&state, &ended, &name);
        let fixed = scene.fixed();
        let held = |i: &usize| fixed.holds(state.bodies.lineage[*i].id, state.bodies.group[*i]);
        let start = scene.build().unwrap();
        let there: Vec<usize> = (0..state.bodies.len()).filter(held).collect();
        assert_eq!(there.len(), 6, "{name}: fixed bodies stay");
        for i in there {
            let id = state.bodies.lineage[i].id as usize;
            assert_eq!(state.bodies.position[i], start.position[id], "{name}");
        }
        // Solves end at 1e-6, a length, so that velocities agree to that over the step, 5e-5.
        agrees_on_device(&scene, &name, [2e-3, 1e-4]);
        for (on, compute) in computes().into_iter().skip(1) {
            let (ours, lives, _) = followed(scene.clone(), &compute);
            assert!((ours.bodies.lineage, lives) == (state.bodies.lineage.clone(), ended.clone()), "{name} on {on}");
        }
    }
}

/// Bodies that touch nobody and leave change nothing of the others, to the last bit.
#[test]
fn who_leaves_from_afar_changes_nothing_of_the_others() {
    for planar in [true, false] {
        let pile: Vec<Value> =
            (0..6_u32).map(|i| sphere(0.5, [0.9 * f64::from(i % 3), 1.0 * f64::from(i / 3), 0.0])).collect();
        let far = |i: u32| with(sphere(0.4, [50.0 + 2.0 * f64::from(i), 0.0, 0.0]), &json!({"group": "far"}));
        let of = |bodies: Vec<Value>, removal: Value| {
            parse(
                &json!({"name": "pile", "planar": planar, "time": {"dt": 0.02, "end": 0.6}, "bodies": bodies, "removal": removal,
                "forces": [{"radial_inward": {}}], "contact": {"cutoff": 0.1}, "walls": [{"half_space": {"normal": [0, 1, 0], "offset": -0.7}}]}),
            )
        };
        let alone = run(of(pile.clone(), json!([])), &Compute::Cpu);
        let mixed = pile.iter().cloned().enumerate().flat_map(|(i, body)| [far(i as u32), body]).collect();
        let (state, ended, _) = followed(of(mixed, json!([{"rate": 6.0, "group": "far"}])), &Compute::Cpu);
        assert!(ended.len() >= 5, "{}", ended.len());
        let place = |id: u64| state.bodies.lineage.iter().position(|line| line.id == id).unwrap();
        for i in 0..pile.len() {
            let j = place(2 * i as u64 + 1);
            assert_eq!(
                (state.bodies.position[j], state.bodies.velocity[j]),
                (alone.bodies.position[i], alone.bodies.velocity[i])
            );
        }
        let renumbered = |w: u32| if (w as usize) < pile.len() { place(2 * u64::from(w) + 1) as u32 } else { w };
        let expected: Vec<_> = alone.warm.iter().map(|w| (w.pair.map(renumbered), w.gamma)).collect();
        assert_eq!(state.warm.iter().map(|w| (w.pair, w.gamma)).collect::<Vec<_>>(), expected);
    }
}

/// In a periodic scene the image in the cell counts, however far a body went.
#[test]
fn a_periodic_scene_looks_at_the_image_in_the_cell() {
    let of = json!({"name": "round", "planar": true, "time": {"dt": 0.1, "end": 1.0}, "periodic": {"lengths": [10, 10, null]},
        "bodies": [sphere(0.4, [3.0, 0.0, 0.0]), sphere(0.4, [23.0, 2.0, 0.0]), sphere(0.4, [-3.0, 0.0, 0.0])],
        "removal": [{"inside": {"half_space": {"normal": [1, 0, 0], "offset": 1}}}]});
    let (state, ended, counts) = followed(parse(&of), &Compute::Cpu);
    assert_eq!((counts[0], ended.len(), state.bodies.lineage[0].id), (1, 2, 2));
}

#[test]
fn a_run_without_bodies_ends_and_says_so() {
    for (name, compute) in computes() {
        let bodies: Vec<Value> = (0..5).map(|i| sphere(0.4, [0.9 * f64::from(i), 0.0, 0.0])).collect();
        let of =
            json!({"name": "brief", "time": {"dt": 0.1, "end": 100.0}, "bodies": bodies, "removal": [{"rate": 2.0}]});
        let parent = tempfile::tempdir().unwrap();
        let folder = Folder::create_in(parent.path(), "brief").unwrap();
        let simulation = Simulation::builder(parse(&of)).on(&compute).build().unwrap();
        let mut run = Run::start(simulation, folder.clone(), Duration::ZERO).unwrap();
        while !run.done() {
            run.advance().unwrap();
        }
        let summary = run.finish().unwrap();
        assert_eq!((summary.stopped_by, summary.status), (Some(StopReason::NoBodies), RunStatus::Done), "{name}");
        assert_eq!((summary.bodies, summary.removed), (0, vec![5]), "{name}");
        assert!(folder.summary().exists() && folder.last().exists(), "{name}");
        let taken_up = Run::resume(parse(&of), folder, &compute).unwrap();
        assert!(taken_up.done() && taken_up.simulation().bodies() == 0, "{name}");
        // A user of the library may step on: nothing happens.
        let mut simulation = Simulation::builder(parse(&of)).on(&compute).build().unwrap();
        while !simulation.done() {
            simulation.step().unwrap();
        }
        let report = simulation.step().unwrap();
        assert_eq!((report.bodies, report.constraints, report.max_overlap), (0, 0, 0.0), "{name}");
    }
}

fn lives(folder: &Folder) -> Vec<LifeRow> {
    csv::Reader::from_path(folder.lineage()).unwrap().deserialize().map(Result::unwrap).collect()
}

/// A run that is killed after its checkpoint goes on to the bits, and the rows, of one that was not.
#[test]
fn a_killed_run_goes_on_with_its_lineage() {
    let mut of = mother_machine(6.0);
    of["output"] = json!({"every": 0.5, "measures": ["groups", "removal"]});
    let scene = parse(&of);
    let parent = tempfile::tempdir().unwrap();
    let start = |name: &str| {
        let folder = Folder::create_in(parent.path(), name).unwrap();
        (Run::start(Simulation::new(scene.clone()).unwrap(), folder.clone(), Duration::ZERO).unwrap(), folder)
    };
    let (mut whole, whole_folder) = start("whole");
    while !whole.done() {
        whole.advance().unwrap();
    }
    let expected = whole.finish().unwrap();
    let rows = lives(&whole_folder);
    assert!(rows.len() > 15 && rows.iter().any(|row| row.cause == "outside" && row.rule == Some(0)), "{rows:?}");
    let (mut killed, folder) = start("killed");
    for step in 0..260 {
        killed.advance().unwrap();
        if step == 199 {
            killed.checkpoint().unwrap();
        }
    }
    drop(killed);
    // What the system had not written whole.
    let torn = std::fs::read_to_string(folder.lineage()).unwrap() + "259,5.2,9";
    std::fs::write(folder.lineage(), torn).unwrap();
    let mut again = Run::resume(scene.clone(), folder.clone(), &Compute::Cpu).unwrap();
    assert_eq!(again.simulation().steps(), 200);
    while !again.done() {
        again.advance().unwrap();
    }
    let summary = again.finish().unwrap();
    assert_eq!((summary.state_hash, &summary.removed), (expected.state_hash, &expected.removed));
    assert_eq!(std::fs::read(folder.lineage()).unwrap(), std::fs::read(whole_folder.lineage()).unwrap());
    let measured = |folder: &Folder| std::fs::read_to_string(folder.measures()).unwrap();
    assert_eq!(measured(&folder), measured(&whole_folder));
    let states = States::open(folder.path()).unwrap();
    let measures = select(&["removal".into(), "groups".into()]).unwrap();
    let found = measure(folder.path(), &states, &measures, &Settings::default(), &mut |_, _| true).unwrap();
    let last = found.len() - 1;
    assert_eq!(found.value(last, "removed"), Some(expected.removed[0] as f64));
    let left =
        |i: usize| rows.iter().filter(|row| row.cause == "outside" && row.time <= found.times[i] + 1e-9).count() as f64;
    for i in 1..found.len() - 1 {
        let rate = (left(i) - left(i - 1)) / (found.times[i] - found.times[i - 1]);
        assert!((found.value(i, "removal_rate").unwrap() - rate).abs() < 1e-9, "state {i}");
    }
    // The final state and the rows are the ancestry of all.
    let last = Scene::read(folder.last()).unwrap().build().unwrap();
    let mut ids: Vec<u64> = rows.iter().map(|row| row.id).chain(last.lineage.iter().map(|line| line.id)).collect();
    ids.sort_unstable();
    let all = ids.len() as u64;
    assert_eq!(ids, (0..all).collect::<Vec<_>>());
    assert_eq!(expected.removed, [rows.iter().filter(|row| row.cause == "outside").count() as u64]);
}

#[test]
fn a_final_scene_keeps_who_is_fixed_and_forgets_species_that_died_out() {
    let mut of = crowd(true, &laws()[0], "euler");
    of["removal"] = json!([{"rate": 1e3, "group": "cells"}, {"rate": 1e3, "group": "balls"}]);
    of["time"]["end"] = json!(0.1);
    let scene = parse(&of);
    let (state, ..) = followed(scene.clone(), &Compute::Cpu);
    let last = scene.final_scene(&state.bodies, 0.1);
    let again = parse(&serde_json::from_str(&last.to_json()).unwrap());
    assert!(again.bodies.len() == 6 && again.bodies.iter().all(|body| body.fixed), "{}", again.to_json());
    assert!(again.growth.is_empty() && again.forces.is_empty() && again.removal.is_empty());
}

#[test]
fn a_scene_without_removal_has_no_trace_of_it() {
    let mut of = mother_machine(0.2);
    of.as_object_mut().unwrap().remove("removal");
    let scene = parse(&of);
    assert!(!scene.to_json().contains("removal"));
    let parent = tempfile::tempdir().unwrap();
    let folder = Folder::create_in(parent.path(), "none").unwrap();
    let mut run = Run::start(Simulation::new(scene).unwrap(), folder.clone(), Duration::ZERO).unwrap();
    while !run.done() {
        run.advance().unwrap();
        assert!(run.simulation().ended().is_empty());
    }
    run.finish().unwrap();
    assert!(!folder.lineage().exists());
    assert!(!std::fs::read_to_string(folder.summary()).unwrap().contains("removed"));
}

#[test]
fn what_removal_cannot_be_is_refused() {
    let half = json!({"half_space": {"normal": [1, 0, 0], "offset": 0}});
    let of = |removal: Value| {
        let mut of = mother_machine(1.0);
        of["removal"] = removal;
        refusal(&of)
    };
    for ((at, message), key, words) in [
        (of(json!([{}])), "removal.0", "must have"),
        (of(json!([{"group": "a"}])), "removal.0", "must have"),
        (of(json!([{"rate": 1}, {"rate": -1}])), "removal.1.rate", "positive"),
        (of(json!([{"rate": 0}])), "removal.0.rate", "positive"),
        (of(json!([{"rate": "often"}])), "removal.0.rate", "number"),
        (of(json!([{"rate": 1, "outside": half}])), "removal.0.rate", "two rules"),
        (of(json!([{"inside": half, "outside": half}])), "removal.0.inside", "two rules"),
        (of(json!([{"rate": 1, "group": "b"}])), "removal.0.group", "no body is in the group"),
        (
            of(json!([{"outside": {"half_space": {"normal": [0, 0, 0], "offset": 0}}}])),
            "removal.0.outside.half_space.normal",
            "direction",
        ),
        (
            of(json!([{"inside": {"sphere": {"center": [0, 0, 1], "radius": 1}}}])),
            "removal.0.inside.sphere.center.2",
            "plane",
        ),
        (
            of(json!([{"inside": {"sphere": {"center": [0, 0, 0], "radius": -1}}}])),
            "removal.0.inside.sphere.radius",
            "positive",
        ),
        (of(json!([{"inside": {"cube": {"side": 1}}}])), "removal.0.inside.cube", "box"),
        (of(json!([{"beyond": half}])), "removal.0.beyond", "beyond"),
        (of(json!({"rate": 1})), "removal", "list"),
        (of(Value::from(vec![json!({"rate": 1}); 65])), "removal", "at most 64"),
    ] {
        assert!(at == key && message.contains(words), "{at} for {key}: {message}");
    }
    let mut held = mother_machine(1.0);
    held["growth"] = Value::Null;
    held["bodies"][0]["group"] = json!("posts");
    (held["groups"], held["removal"]) = (json!({"posts": {"fixed": true}}), json!([{"rate": 1, "group": "posts"}]));
    let (at, message) = refusal(&held);
    assert!(at == "removal.0.group" && message.contains("never removed"), "{at}: {message}");
}
