//! Species that grow and divide by rules of their own.

use crate::device::{device, precisions};
use crate::scenes::{agrees_on_device, apart, parse, refusal, run};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::internals::dynamics::{Cells, Waiting};
use relcp::record::Folder;
use relcp::run::Run;
use relcp::scene::{DivisionRule, Growth};
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::LN_2;
use std::time::Duration;

/// Two founders far from each other, of two groups.
fn two_founders(growth: &Value) -> Value {
    let cell = |group: &str, x: f64, length: f64| {
        json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": length}}, "position": [x, 0, 0],
               "axis": [0.6, 0.8, 0], "group": group})
    };
    json!({"name": "species", "seed": 5, "planar": true, "time": {"dt": 0.02, "end": 2.6}, "growth": growth,
           "dynamics": {"overdamped": {"drag": 200.0}}, "bodies": [cell("a", -20.0, 1.5), cell("b", 20.0, 1.5)]})
}

fn length_of(bodies: &Bodies, group: u32) -> f64 {
    let own = |(shape, of): (&Shape, &u32)| if *of == group { shape.growing_length() } else { None };
    bodies.shape.iter().zip(&bodies.group).filter_map(own).sum()
}

/// Lengths add up to `L e^(rate t)` whatever divides, and without noise a strain has `2^k` cells with the least `k` for
/// which they are shorter than they divide at.
#[test]
fn two_strains_grow_apart_as_their_rates_do() {
    let growth = json!([
        {"group": "a", "rate": 1.0, "division_length": 2.0, "reorientation_degrees": 3},
        {"rate": 1.2, "division_length": 2.0, "reorientation_degrees": 3}
    ]);
    let scene = parse(&two_founders(&growth));
    let check = |bodies: &Bodies, name: &str, bound: f64| {
        let ratio = length_of(bodies, 1) / length_of(bodies, 0);
        let off = ratio / (0.2_f64 * 2.6).exp() - 1.0;
        println!("{name}: ratio of lengths off by {off:.1e}");
        assert!(off.abs() < bound, "{name}: {off:e}");
        for (group, rate) in [(0, 1.0_f64), (1, 1.2)] {
            let count = bodies.group.iter().filter(|of| **of == group).count();
            // A cell divides at the start of the step after the one in which it reaches the length.
            let doublings = ((rate * 2.58 + (1.5_f64 / 2.0).ln()) / LN_2).floor() + 1.0;
            assert_eq!(count as f64, doublings.exp2(), "{name}, group {group}");
        }
        let children = bodies.lineage.iter().filter(|line| line.generation > 0).count();
        assert_eq!(children, bodies.len(), "{name}");
    };
    let cpu = run(scene.clone(), &Compute::Cpu);
    check(&cpu.bodies, "cpu", 1e-13);
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let ours = run(scene.clone(), &Compute::Gpu { gpu: gpu.clone(), precision });
        check(&ours.bodies, &format!("{precision:?}"), 1e-5);
        assert_eq!((&ours.bodies.lineage, &ours.bodies.group), (&cpu.bodies.lineage, &cpu.bodies.group));
        assert!(apart(&ours.bodies, &cpu.bodies) < 2e-3);
    }
}

/// A cell's length at its birth and where it divided.
#[derive(Clone, Copy)]
struct Life {
    birth: f64,
    division: f64,
}

/// The lives of one cell of each of `chains` lines of descent, each `generations` after its founder.
fn lives(growth: Growth, founder: f64, chains: usize, generations: u32, dt: f64) -> Vec<Life> {
    let cells = Cells::new(&[growth], &[], false, 11);
    let mut bodies = Bodies::default();
    for i in 0..chains {
        let shape = Shape::Spherocylinder { diameter: 0.4, length: founder };
        let at = Placed { shape, position: glam::DVec3::X * i as f64, orientation: glam::DQuat::IDENTITY };
        bodies.push(at, NO_GROUP);
    }
    cells.settle(&mut bodies);
    let (mut next_id, mut births) = (chains as u64, vec![founder; chains]);
    let mut found: Vec<Option<Life>> = vec![None; chains];
    let mut step = 0_u32;
    while found.iter().any(Option::is_none) {
        let before = bodies.clone();
        let span = (f64::from(step) * dt, dt);
        cells.grow(&mut bodies, span, &mut next_id, &mut Vec::new(), &Waiting::None);
        step += 1;
        for i in 0..chains {
            let line = before.lineage[i];
            if bodies.lineage[i].id == line.id {
                continue;
            }
            let division = before.shape[i].growing_length().unwrap();
            if line.generation == generations {
                found[i] = Some(Life { birth: births[i], division });
            }
            births[i] = 0.5 * division;
            assert!(bodies.lineage[i].birth_length.is_none_or(|length| length == births[i]));
        }
        // Each line goes on with its lower daughter.
        bodies.shape.truncate(chains);
        bodies.position.truncate(chains);
        bodies.orientation.truncate(chains);
        bodies.velocity.truncate(chains);
        bodies.angular_velocity.truncate(chains);
        bodies.group.truncate(chains);
        bodies.lineage.truncate(chains);
    }
    found.into_iter().flatten().collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    mean(&values.iter().map(|x| (x - middle).powi(2)).collect::<Vec<_>>()).sqrt()
}

/// Slope of the length at division over that at birth, with its standard error.
fn slope(lives: &[Life]) -> [f64; 2] {
    let [births, divisions] =
        [|l: &Life| l.birth, |l: &Life| l.division].map(|of| lives.iter().map(of).collect::<Vec<_>>());
    let (b, d) = (mean(&births), mean(&divisions));
    let covariance = mean(&lives.iter().map(|l| (l.birth - b) * (l.division - d)).collect::<Vec<_>>());
    let slope = covariance / deviation(&births).powi(2);
    let left: Vec<f64> = lives.iter().map(|l| l.division - d - slope * (l.birth - b)).collect();
    [slope, deviation(&left) / (deviation(&births) * (lives.len() as f64).sqrt())]
}

const CHAINS: usize = 1_500;
const DT: f64 = 0.005;
const NOISE: f64 = 0.2;
/// Standard errors that a figure may be off by.
const ERRORS: f64 = 4.0;

/// How far the mean and the variation of lengths at birth are from a closed form, in standard errors.
fn births_off(lives: &[Life], [expected, variation]: [f64; 2], name: &str) -> [f64; 2] {
    let births: Vec<f64> = lives.iter().map(|l| l.birth).collect();
    let (mean, deviation, root) = (mean(&births), deviation(&births), (births.len() as f64).sqrt());
    // The error of a standard deviation of a distribution no heavier than the normal one.
    let off =
        [(mean / expected - 1.0) / (variation / root), (deviation / mean / variation - 1.0) * 2.0_f64.sqrt() * root];
    println!(
        "{name}: mean {mean:.4} of {expected:.4}, CV {:.4} of {variation:.4}; {off:.1?} standard errors",
        deviation / mean
    );
    off
}

/// Taheri-Araghi et al. 2015: lengths at birth come to the length that is added; Amir 2014: their variance is a third
/// of that of what is added, and the length at division goes with that at birth with slope 1.
#[test]
fn an_adder_is_born_at_what_it_adds() {
    let mut growth = Growth::adder(1.0, 2.0);
    growth.added_length_noise = NOISE;
    // From a founder far too long: half of the excess is left after each division.
    let found = lives(growth, 3.5, CHAINS, 9, DT);
    // A cell divides at the first step's start past its target: on average half a step's growth later.
    let off = births_off(&found, [2.0 * (1.0 + DT), NOISE / 3.0], "adder");
    let [slope, error] = slope(&found);
    println!("adder: slope {slope:.3} +- {error:.3}");
    assert!(off.iter().all(|off| off.abs() < ERRORS) && (slope - 1.0).abs() < ERRORS * error, "{off:?} {slope}");
}

/// A sizer forgets its length at birth: slope 0, and half of what it divides at is what its daughters are born with.
#[test]
fn a_sizer_forgets_its_birth() {
    let mut growth = Growth::new(1.0, 4.0);
    growth.division_length_noise = NOISE;
    let found = lives(growth, 2.0, CHAINS, 3, DT);
    let off = births_off(&found, [2.0 * (1.0 + 0.5 * DT), NOISE / 3.0_f64.sqrt()], "sizer");
    let [slope, error] = slope(&found);
    println!("sizer: slope {slope:.3} +- {error:.3}");
    assert!(off.iter().all(|off| off.abs() < ERRORS) && slope.abs() < ERRORS * error, "{off:?} {slope}");
}

/// A timer of exponential growth keeps what it is born with: slope 2, and the logarithm of the length at birth walks at
/// random, its variance growing by that of `rate time` in each generation.
#[test]
fn a_timer_keeps_its_birth() {
    let (generations, noise) = (8_u32, 0.1);
    let mut growth = Growth::timer(1.0, LN_2 - 0.5 * DT);
    growth.division_time_noise = noise;
    let found = lives(growth, 2.0, CHAINS, generations, DT);
    let logarithms: Vec<f64> = found.iter().map(|l| (0.5 * l.birth).ln()).collect();
    let (walked, root) = (mean(&logarithms), (CHAINS as f64).sqrt());
    let expected = noise * (LN_2 - 0.5 * DT) * (f64::from(generations) / 3.0).sqrt();
    let deviation = deviation(&logarithms);
    let off = [walked / (expected / root), (deviation / expected - 1.0) * 2.0_f64.sqrt() * root];
    let [slope, error] = slope(&found);
    println!(
        "timer: {walked:.4}, sd {deviation:.4} of {expected:.4}, {off:.1?} standard errors; slope {slope:.3} +- {error:.3}"
    );
    assert!(off.iter().all(|off| off.abs() < ERRORS) && (slope - 2.0).abs() < ERRORS * error, "{off:?} {slope}");
}

/// Three species in contact, each with a rule of its own and every noise.
fn mixture(planar: bool, stepping: &str, end: f64) -> Value {
    let noises = json!({"rate_noise": 0.2, "reorientation_degrees": 5});
    let of = |own: &Value| {
        let mut of = noises.clone();
        of.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
        of
    };
    let growth = json!([
        of(&json!({"group": "a", "rate": 1.0, "division_length": 2.0, "division_length_noise": 0.1})),
        of(&json!({"group": "b", "rate": 1.2, "rule": "adder", "added_length": 0.9, "added_length_noise": 0.2})),
        of(&json!({"rate": 0.9, "rule": "timer", "division_time": 0.6, "division_time_noise": 0.3}))
    ]);
    let mut of = two_founders(&growth);
    (of["planar"], of["time"]) = (json!(planar), json!({"dt": 0.01, "end": end, "stepping": stepping}));
    (of["bodies"][0]["position"], of["bodies"][1]["position"]) = (json!([-0.8, 0, 0]), json!([0.8, 0, 0]));
    let mut third = of["bodies"][0].clone();
    third.as_object_mut().unwrap().remove("group");
    third["position"] = json!([0.0, 1.6, 0.0]);
    of["bodies"].as_array_mut().unwrap().push(third.clone());
    // It has no length, and does not grow.
    let ball = json!({"shape": {"sphere": {"radius": 0.4}}, "position": [0, -1.6, 0], "group": "a"});
    of["bodies"].as_array_mut().unwrap().push(ball);
    of
}

#[test]
fn three_rules_on_a_device_are_the_cpus_and_resume_to_the_same_bits() {
    for (planar, stepping, end) in [(true, "euler", 1.2), (false, "midpoint", 0.9)] {
        let scene = parse(&mixture(planar, stepping, end));
        let cpu = run(scene.clone(), &Compute::Cpu);
        let count = |group: u32| cpu.bodies.group.iter().filter(|of| **of == group).count();
        assert!(count(0) >= 2 && count(1) >= 2 && count(NO_GROUP) >= 2, "{:?}", cpu.bodies.group);
        agrees_on_device(&scene, &format!("three rules, planar {planar}"), [2e-3, 2e-5]);
        let Some(gpu) = device() else { continue };
        for precision in precisions(gpu) {
            let ours = run(scene.clone(), &Compute::Gpu { gpu: gpu.clone(), precision });
            assert_eq!((&ours.bodies.lineage, &ours.bodies.group), (&cpu.bodies.lineage, &cpu.bodies.group));
        }
    }
}

#[test]
fn bodies_of_a_group_that_no_entry_holds_for_do_not_grow() {
    let scene = parse(&two_founders(&json!([{"group": "b", "rate": 1.0, "division_length": 2.0}])));
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    while simulation.steps() < 10 {
        simulation.step().unwrap();
    }
    let bodies = &simulation.state().unwrap().bodies;
    assert!((bodies.len(), length_of(bodies, 0)) == (2, 1.5) && length_of(bodies, 1) > 1.8);
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let mut simulation = Simulation::builder(scene.clone()).on(&compute).build().unwrap();
        while simulation.steps() < 10 {
            simulation.step().unwrap();
        }
        let bodies = &simulation.state().unwrap().bodies;
        assert!((bodies.len(), length_of(bodies, 0)) == (2, 1.5) && length_of(bodies, 1) > 1.8, "{precision:?}");
    }
}

/// A run that is interrupted and taken up again, from the file that it left, ends with the bits of one that was not.
#[test]
fn a_checkpoint_keeps_lengths_at_birth() {
    let scene = parse(&mixture(true, "euler", 1.0));
    let whole = run(scene.clone(), &Compute::Cpu);
    let parent = tempfile::tempdir().unwrap();
    let folder = Folder::create_in(parent.path(), "mixture").unwrap();
    let mut first = Run::start(Simulation::new(scene.clone()).unwrap(), folder.clone(), Duration::ZERO).unwrap();
    for _ in 0..60 {
        first.advance().unwrap();
    }
    let born = first.simulation().state().unwrap().bodies.lineage.clone();
    assert!(born.iter().any(|line| line.birth_length.is_some()) && born.iter().any(|line| line.birth_length.is_none()));
    first.finish().unwrap();
    let mut second = Run::resume(scene.clone(), folder.clone(), &Compute::Cpu).unwrap();
    assert_eq!(second.simulation().state().unwrap().bodies.lineage, born);
    while !second.done() {
        second.advance().unwrap();
    }
    assert!(*second.simulation().state().unwrap() == whole);
    second.finish().unwrap();
    let last = relcp::Scene::read(folder.last()).unwrap().build().unwrap();
    assert_eq!(last.lineage, whole.bodies.lineage);
}

#[test]
fn one_object_is_written_as_it_was_and_a_list_as_a_list() {
    let one = parse(&two_founders(&json!({"rate": 1.0, "division_length": 2.0})));
    let written: Value = serde_json::from_str(&one.to_json()).unwrap();
    assert_eq!(written["growth"], json!({"rate": 1.0, "division_length": 2.0, "reorientation_degrees": 0.0}));
    let list = parse(&mixture(true, "euler", 1.0));
    let written: Value = serde_json::from_str(&list.to_json()).unwrap();
    assert_eq!(written["growth"][1]["rule"], "adder");
    assert_eq!(parse(&written), list);
    assert_eq!(list.growth[2].rule, DivisionRule::Timer);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("species.json");
    std::fs::write(&path, list.to_json()).unwrap();
    let set = relcp::Scene::load(path.to_str().unwrap(), ["growth.1.rate=0.25"]).unwrap();
    assert_eq!((set.growth[0].rate, set.growth[1].rate), (1.0, 0.25));
}

#[test]
fn what_species_cannot_be_is_refused() {
    let list = |entries: Value| refusal(&two_founders(&entries));
    let sizer = |group: &str| json!({"group": group, "rate": 1, "division_length": 2});
    let with = |own: Value| {
        let mut of = json!({"rate": 1});
        of.as_object_mut().unwrap().extend(own.as_object().unwrap().clone());
        list(of)
    };
    for ((at, message), key, words) in [
        (list(json!([sizer("a"), sizer("a")])), "growth.1.group", "one entry"),
        (
            list(json!([sizer("a"), {"rate": 1, "division_length": 2}, {"rate": 1, "division_length": 2}])),
            "growth.2.group",
            "one entry",
        ),
        (list(json!([sizer("c")])), "growth.0.group", "no body is in the group"),
        (list(json!([{"group": "a", "rate": -1, "division_length": 2}])), "growth.0.rate", "negative"),
        (list(json!([{"group": "a", "rate": "fast", "division_length": 2}])), "growth.0.rate", "number"),
        (list(json!([{"group": "a", "rte": 1, "division_length": 2}])), "growth.0.rte", "rate"),
        (list(json!(5)), "growth", "list"),
        (list(json!([7])), "growth.0", "object"),
        (with(json!({})), "growth.division_length", "is missing"),
        (with(json!({"rule": "adder"})), "growth.added_length", "is missing"),
        (with(json!({"rule": "timer", "division_length": 2})), "growth.division_length", "no meaning"),
        (
            with(json!({"rule": "adder", "added_length": 1, "division_length_noise": 0.1})),
            "growth.division_length_noise",
            "no meaning",
        ),
        (with(json!({"division_length": 2, "added_length": 1})), "growth.added_length", "no meaning"),
        (with(json!({"rule": "adder", "added_length": 0.4})), "growth.added_length", "at least the diameter"),
        (
            with(json!({"rule": "adder", "added_length": 0.55, "added_length_noise": 0.2})),
            "growth.added_length",
            "less its noise",
        ),
        (
            with(json!({"rule": "adder", "added_length": 1, "added_length_noise": 1})),
            "growth.added_length_noise",
            "under 1",
        ),
        (with(json!({"rule": "timer", "division_time": 0.02})), "growth.division_time", "longer than a step"),
        (with(json!({"rule": "timer", "division_time": 0})), "growth.division_time", "positive"),
        (with(json!({"rule": "timer", "division_time": 0.01})), "growth.division_time", "longer"),
        (with(json!({"rule": "halver", "division_length": 2})), "growth.rule", "adder"),
        (
            list(json!([{"group": "a", "rate": 1, "division_length": 2, "on_no_room": "stall"}, sizer("b")])),
            "growth.1.on_no_room",
            "differs",
        ),
        (
            list(json!([{"group": "a", "rate": 1, "division_length": 2, "stop": {"population": 9}},
                     {"group": "b", "rate": 1, "division_length": 2, "stop": {"population": 8}}])),
            "growth.1.stop",
            "growth.0",
        ),
    ] {
        assert!(at == key && message.contains(words), "{at} for {key}: {message}");
    }
    let mut balls = two_founders(&json!([sizer("a"), sizer("b")]));
    balls["bodies"][1]["shape"] = json!({"sphere": {"radius": 1}});
    let (at, message) = refusal(&balls);
    assert!(at == "growth.1" && message.contains("the group `b` has none"), "{at}: {message}");
    let mut born = two_founders(&json!([sizer("a")]));
    born["bodies"][0]["lineage"] = json!({"id": 1, "parent": null, "birth": 0, "generation": 0, "birth_length": -1});
    let (at, message) = refusal(&born);
    assert!(at == "bodies.0.lineage.birth_length" && message.contains("positive"), "{at}: {message}");
    let mut grows = two_founders(&json!({"rate": 1, "rule": "timer", "division_time": 0.9}));
    (grows["periodic"], grows["time"]["end"]) = (json!({"lengths": [20, 20, null]}), json!(8));
    grows["bodies"] = json!([grows["bodies"][0].clone()]);
    let (at, message) = refusal(&grows);
    assert!(at == "periodic.lengths.0" && message.contains("grows to"), "{at}: {message}");
}
