//! Friction and restitution in steps on the device: rows verb by verb, closed forms, a pile and a heap, against the
//! CPU's steps and what is right.

use crate::device::{device, precisions};
use crate::rough::{G, assert_near, ball, floor, inertial, parse, pyramid, rod, weight, with};
use crate::traffic::own;
use relcp::bodies::Bodies;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::step::Verbs;
use relcp::lcp::{Cone, Problem};
use relcp::scene::{Rows, Scene};
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use serde_json::{Value, json};
use std::sync::Arc;

/// What rows may differ by from the CPU's: blocks of J relative to the largest entry, lengths relative to sizes and
/// moves, and the compliance of stick, relative to it.
const BOUNDS: [(Precision, [f64; 3]); 2] =
    [(Precision::F32, [3e-5, 1e-5, 1e-3]), (Precision::F64, [1e-12, 1e-12, 1e-10])];

/// A row: its bodies, its blocks of `J`, its offset, what its multiplier may be, its compliance and its multiplier.
type Row = ([u32; 2], Vec<f64>, f64, Cone, f64, f64);

/// Rows by pair, those of a pair in the order made.
fn by_pair<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> Vec<Row> {
    let blocks = |row: usize| problem.jacobian[row].iter().flat_map(|block| block.to_vec()).collect();
    let cone = |row: usize| problem.cones.get(row).copied().unwrap_or(Cone::Ray);
    let compliance = |row: usize| problem.compliance.get(row).copied().unwrap_or(0.0);
    let row = |row: usize| (problem.pair[row], blocks(row), problem.q[row], cone(row), compliance(row), gamma[row]);
    let mut rows: Vec<Row> = (0..problem.q.len()).map(row).collect();
    rows.sort_by_key(|row| row.0);
    rows
}

/// The first `D` numbers of each block.
fn narrowed<const D: usize>(problem: Problem<SPATIAL>) -> Problem<D> {
    let block = |block: &[f64; SPATIAL]| std::array::from_fn(|k| block[k]);
    let jacobian = problem.jacobian.iter().map(|blocks| blocks.each_ref().map(block)).collect();
    let Problem { bodies, pair, q, cones, compliance, .. } = problem;
    Problem { bodies, pair, jacobian, q, cones, compliance }
}

fn compare<const D: usize>(what: &str, device: &Device, cpu: &Cpu<D>, [blocks, lengths, stick]: [f64; 3]) {
    let (problem, gamma) = device.lcp_on_host().unwrap();
    let (ours, theirs) = (by_pair(&narrowed::<D>(problem), &gamma), by_pair(cpu.lcp().0, cpu.lcp().1));
    let which = |rows: &[Row]| rows.iter().map(|row| (row.0, row.3)).collect::<Vec<_>>();
    assert_eq!(which(&ours), which(&theirs), "{what}");
    let most = |of: fn(&Row) -> f64| theirs.iter().map(of).fold(0.0, f64::max);
    let largest = most(|row| row.1.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
    let (size, softest, push) = (most(|row| row.2.abs()).max(2.0), most(|row| row.4), most(|row| row.5.abs()));
    let off = |of: &dyn Fn(&Row, &Row) -> f64| ours.iter().zip(&theirs).map(|(a, b)| of(a, b)).fold(0.0, f64::max);
    let part = |off: f64, of: f64| if of > 0.0 { off / of } else { off };
    let found = [
        off(&|a, b| a.1.iter().zip(&b.1).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)) / largest,
        off(&|a, b| (a.2 - b.2).abs()) / size,
        part(off(&|a, b| (a.4 - b.4).abs()), softest),
        part(off(&|a, b| (a.5 - b.5).abs()), push),
    ];
    println!("{what}: {} rows, off by {}", ours.len(), found.map(|off| format!("{off:.1e}")).join(", "));
    let within = found.iter().zip([blocks, lengths, stick, stick]).all(|(found, most)| *found <= most);
    assert!(within && !ours.is_empty(), "{what}: {found:?}");
}

/// The first steps of a scene on the CPU.
const BEFORE: usize = 3;

/// From which overlap on pairs violate.
const VIOLATING: f64 = 1e-4;

/// A step's verbs after some steps of the CPU, whose multipliers are never solved for: they would depend on rounding.
/// Returns how many tangents were held by the last step.
fn step_by_verbs<const D: usize>(gpu: &Arc<Gpu>, scene: &Scene, precision: Precision, bounds: [f64; 3]) -> usize {
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    (0..BEFORE).for_each(|_| assert!(simulation.step().is_ok()));
    let state = simulation.state().unwrap();
    let mut ours = Device::new(gpu.clone(), precision, &scene.model(), state.clone()).unwrap();
    let mut theirs = Cpu::<D>::new(&scene.model(), state.clone()).unwrap();
    let what = format!("{} {precision:?}", scene.name);
    let verb = |ours: &mut Device, theirs: &mut Cpu<D>, verb: &dyn Fn(&mut dyn Verbs)| {
        verb(ours);
        verb(theirs);
    };
    verb(&mut ours, &mut theirs, &|backend| backend.begin().unwrap());
    verb(&mut ours, &mut theirs, &|backend| backend.append_near().unwrap());
    compare(&format!("{what}, first rows"), &ours, &theirs, bounds);
    let (problem, gamma) = theirs.lcp();
    let held = problem.cones.iter().zip(gamma).filter(|(cone, x)| **cone == Cone::Tangent && **x != 0.0).count();
    // No step tightens the paper's rows.
    let answers = if scene.contact.rows == Rows::Paper { &[false, false][..] } else { &[true, false] };
    for tightens in answers.iter().copied() {
        let found = [ours.trial(VIOLATING).unwrap(), theirs.trial(VIOLATING).unwrap()];
        assert_eq!(found[0].violations, found[1].violations, "{what}");
        verb(&mut ours, &mut theirs, &|backend| {
            if tightens { backend.tighten_violations() } else { backend.append_violations(false) }.unwrap();
        });
        compare(&format!("{what}, {} violations answered", found[1].violations), &ours, &theirs, bounds);
    }
    verb(&mut ours, &mut theirs, &|backend| assert!(backend.trial(VIOLATING).is_ok()));
    let effects = [ours.effect(0.02).unwrap(), theirs.effect(0.02).unwrap()];
    let [a, b] = effects.map(|effect| effect.friction.map(|found| (found.sliding + found.sticking, found.locked)));
    assert_eq!(a, b, "{what}");
    held
}

/// Bodies that are drawn together.
fn crowd(name: &str, more: Value) -> Scene {
    let rods = json!({"spherocylinder": {"diameter": 0.5, "length": 2}});
    let balls = json!({"sphere": {"radius": 0.5}});
    let of = |shape: Value, group: &str| {
        let inner = json!({"count": 30, "shape": shape, "volume_fraction": 0.1, "group": group});
        json!({ "isotropic": inner })
    };
    let mut scene = json!({"name": name, "seed": 4, "time": {"dt": 0.3, "end": 100},
        "contact": {"friction": {"bodies": 0.4, "walls": 0.2, "groups": [{"between": ["rods", "balls"], "is": 0.7}]}},
        "forces": [{"radial_inward": {}}],
        "generate": [of(rods, "rods"), of(balls, "balls")]});
    for (key, value) in more.as_object().unwrap() {
        scene[key] = value.clone();
    }
    if more.get("periodic").is_some() {
        // The cell says how dense bodies are.
        for i in 0..2 {
            scene["generate"][i]["isotropic"].as_object_mut().unwrap().remove("volume_fraction");
        }
    }
    parse(&scene)
}

/// Rods in the plane between walls, of which one moves.
fn flat(name: &str, more: Value) -> Scene {
    let body = |i: usize| {
        let turn = 2.0 * (7.3 * i as f64).sin();
        json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "axis": [turn.cos(), turn.sin(), 0],
            "position": [(i % 8) as f64 * 1.5 - 5.3, (i / 8) as f64 * 2.1 - 4.1, 0]})
    };
    let belt = json!({"half_space": {"normal": [0, 1, 0], "offset": -5.2, "motion": {"velocity": [0.3, 0.1, 0]}}});
    let mut scene = json!({"name": name, "planar": true, "time": {"dt": 0.2, "end": 100}, "contact": {"friction": 0.5},
        "walls": [belt], "forces": [{"radial_inward": {}}], "bodies": (0..40).map(body).collect::<Vec<_>>()});
    for (key, value) in more.as_object().unwrap() {
        scene[key] = value.clone();
    }
    parse(&scene)
}

#[test]
fn rows_of_friction_are_the_cpus_verb_by_verb() {
    let Some(gpu) = device() else { return };
    let inertia = json!({"inertial": {"density": 2}});
    let spatial = [
        crowd("rods and balls", json!({})),
        crowd(
            "with inertia in a turning ball",
            json!({"dynamics": inertia, "walls": [{"sphere": {"center": [0, 0, 0],
            "radius": 6, "motion": {"velocity": [0, 0, 0], "angular_velocity": [0.1, 0.2, 0.3]}}}]}),
        ),
        crowd(
            "in a sheared cell",
            json!({"time": {"dt": 0.1, "end": 100}, "forces": [],
            "periodic": {"lengths": [7, 7, 7], "shear": {"direction": "x", "gradient": "y", "rate": 0.3}}}),
        ),
        crowd("with restitution", json!({"dynamics": inertia, "contact": {"friction": 0.3, "restitution": 0.8}})),
        crowd("restitution alone", json!({"dynamics": inertia, "contact": {"restitution": 0.8}})),
        crowd("one row a pair", json!({"dynamics": inertia, "contact": {"friction": 0.3, "rows": "paper"}})),
    ];
    let growth = json!({"rate": 0.05, "division_length": 2.03, "reorientation_degrees": 8});
    let planar = [
        flat("rods in the plane", json!({})),
        flat("cells in the plane", json!({"growth": growth})),
        flat("one row a pair in the plane", json!({"contact": {"friction": 0.5, "rows": "paper"}})),
    ];
    for (precision, bounds) in BOUNDS.into_iter().filter(|bounds| precisions(gpu).contains(&bounds.0)) {
        let spatial = spatial.iter().map(|scene| step_by_verbs::<SPATIAL>(gpu, scene, precision, bounds));
        let planar = planar.iter().map(|scene| step_by_verbs::<PLANAR>(gpu, scene, precision, bounds));
        let held: usize = spatial.chain(planar).sum();
        assert!(held > 100, "{held} tangents that the last step held");
    }
}

/// Takes all steps on the device; each must hold there.
fn run_all(gpu: &Arc<Gpu>, precision: Precision, scene: &Value) -> (Bodies, Vec<StepReport>) {
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let mut simulation = Simulation::builder(parse(scene)).on(&compute).build().unwrap();
    let tolerance = simulation.scene().contact.overlap_tolerance;
    let mut reports = Vec::new();
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.within(tolerance) && report.settled(tolerance), "{report:?}");
        assert!(!report.by_cpu, "{report:?}");
        reports.push(report);
    }
    (simulation.state().unwrap().bodies.clone(), reports)
}

/// Solvers: by the first one the host solves, by the second one the device.
const SOLVERS: [&str; 2] = ["auto", "pair_block_cg"];

/// A scene with this solver.
fn by(scene: &Value, solver: &str) -> Value {
    let mut scene = scene.clone();
    scene["solver"]["kind"] = json!(solver);
    scene
}

/// Each precision of the device and each solver, and what an error of some 1e-9 in f64 may be in it.
fn each(mut check: impl FnMut(&dyn Fn(&Value) -> Bodies, f64)) {
    let Some(gpu) = device() else { return };
    for (precision, solver) in precisions(gpu).into_iter().flat_map(|precision| SOLVERS.map(|of| (precision, of))) {
        let error = if precision == Precision::F32 { 5e-6 } else { 1e-8 };
        println!("{precision:?}, {solver}");
        check(&|scene| run_all(gpu, precision, &by(scene, solver)).0, error);
    }
}

#[test]
fn rods_and_balls_on_an_incline_slide_stick_and_roll() {
    each(|run, error| {
        let limit = 0.5_f64.atan();
        for (angle, friction) in [(0.4, 0.3), (0.4, 0.5), (limit - 1e-3, 0.5), (limit + 1e-3, 0.5)] {
            let bodies = run(&inertial(friction, weight(angle), json!([floor()]), vec![rod(0.5)], [0.01, 1.0]));
            let speed = (G * (angle.sin() - friction * angle.cos())).max(0.0);
            assert_near(bodies.velocity[0].x, speed, error);
            assert_near(bodies.position[0].z, 0.5, error);
        }
        let at_rest = || ball([0.0, 0.0, 1.0]);
        let rolls = run(&inertial(0.3, weight(0.5), json!([floor()]), vec![at_rest()], [0.01, 1.0]));
        // Stick gives by the elastic slip.
        assert_near(rolls.velocity[0].x, 5.0 / 7.0 * G * 0.5_f64.sin(), error.max(1e-6));
        let slips = run(&inertial(0.1, weight(0.5), json!([floor()]), vec![at_rest()], [0.01, 1.0]));
        assert_near(slips.velocity[0].x, G * (0.5_f64.sin() - 0.1 * 0.5_f64.cos()), error);
        assert_near(slips.angular_velocity[0].y, 2.5 * 0.1 * G * 0.5_f64.cos(), error);
        let thrown = with(at_rest(), "velocity", json!([5, 0, 0]));
        let thrown = run(&inertial(0.3, weight(0.0), json!([floor()]), vec![thrown], [0.01, 1.0]));
        assert_near(thrown.velocity[0].x, 25.0 / 7.0, error);
        assert_near(thrown.angular_velocity[0].y, 25.0 / 7.0, error);
        assert_near(thrown.position[0].z, 1.0, error);
    });
}

#[test]
fn a_conveyor_carries_a_rod_and_pressed_bodies_without_inertia_slide_or_roll() {
    each(|run, error| {
        let belt = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0, "motion": {"velocity": [2, 0, 0]}}}]);
        for (end, speed) in [(0.5, 0.25 * G * 0.5), (2.0, 2.0)] {
            let bodies = run(&inertial(0.25, weight(0.0), belt.clone(), vec![rod(0.5)], [0.01, end]));
            assert_near(bodies.velocity[0].x, speed, error);
        }
        for (body, against, moved) in
            [(rod(0.5), 1.0, 0.7 / 4.0), (ball([0.0, 0.0, 1.0]), 1.0, 0.375), (ball([0.0, 0.0, 1.0]), 0.2, 0.47)]
        {
            let bodies = run(&json!({"name": "pressed", "time": {"dt": 0.01, "end": 1.0}, "walls": [floor()],
                "dynamics": {"overdamped": {"drag": 1.0}}, "contact": {"friction": 0.3},
                "forces": [{"uniform": {"force": [1.0, 0.0, -against]}}], "bodies": [body]}));
            assert_near(bodies.position[0].x, moved, error.max(1e-6));
        }
    });
}

#[test]
fn a_pile_of_ten_balls_rests() {
    each(|run, _| {
        let moved = |friction: f64, time: [f64; 2]| {
            let scene = inertial(friction, weight(0.0), json!([floor()]), pyramid(), time);
            let (before, after) = (parse(&scene).build().unwrap(), run(&scene));
            before.position.iter().zip(&after.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
        };
        let [rough, smooth] = [0.6, 0.01].map(|friction| moved(friction, [0.01, 3.0]));
        // Stick then gives by 1e-6 only, so that a solve to 1e-6, the default of f32, lets the pile collapse.
        let short = moved(0.6, [1e-3, 0.5]);
        println!("with friction moved by {rough:.1e}, in short steps {short:.1e}, nearly without by {smooth:.1e}");
        assert!(rough < 5e-5 && short < 5e-6 && smooth > 0.1, "{rough:e} {short:e} {smooth:e}");
    });
}

#[test]
fn a_dropped_ball_reaches_the_square_of_the_coefficient_of_its_height() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let mut scene = inertial(0.0, weight(0.0), json!([floor()]), vec![ball([0.0, 0.0, 2.0])], [1e-3, 1.4]);
        scene["contact"]["restitution"] = json!(0.5);
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let mut simulation = Simulation::builder(parse(&scene)).on(&compute).build().unwrap();
        let (mut peaks, mut before) = (Vec::new(), [2.0, 2.0]);
        while !simulation.done() {
            simulation.step().unwrap();
            let z = simulation.state().unwrap().bodies.position[0].z;
            if before[1] > before[0] && before[1] > z && before[1] > 1.001 {
                peaks.push(before[1] - 1.0);
            }
            before = [before[1], z];
        }
        // A step of 1e-3 ends up to 4e-3 from the floor, and the ball turns back there.
        assert!(!peaks.is_empty(), "no bounce");
        peaks.iter().zip([0.25, 0.0625]).for_each(|(peak, right)| assert_near(*peak, right, 5e-3));
    }
}

/// Balls and rods that fall into a box.
fn heap(steps: u32) -> Value {
    let mut bodies = Vec::new();
    for i in 0..24 {
        let at = [1.3 * f64::from(i % 3) - 1.4, 1.2 * f64::from(i / 3 % 3) - 1.1, 1.0 + 1.3 * f64::from(i / 9)];
        let turn = f64::from(i);
        bodies.push(match i % 2 {
            0 => json!({"shape": {"sphere": {"radius": 0.5}}, "position": at}),
            _ => json!({"shape": {"spherocylinder": {"diameter": 0.6, "length": 1.1}}, "position": at,
                "axis": [turn.cos(), turn.sin(), 0.4]}),
        });
    }
    let walls = json!([{"box": {"minimum": [-2.2, -2, 0], "maximum": [2.2, 2, 12], "friction": 0.3}}]);
    inertial(0.5, weight(0.0), walls, bodies, [0.01, 0.01 * f64::from(steps)])
}

/// How far a heap is from the CPU's after so many steps, and the work and the pushing contacts of both by then.
fn beside_the_cpu(gpu: &Arc<Gpu>, precision: Precision, solver: &str, steps: u32) -> (f64, [f64; 2], [usize; 2]) {
    let mut scene = heap(steps);
    scene["solver"] = json!({"tolerance": 1e-9});
    scene["contact"]["elastic_slip"] = json!(1e-4);
    let mut simulation = Simulation::new(parse(&scene)).unwrap();
    let mut theirs = Vec::new();
    while !simulation.done() {
        theirs.push(simulation.step().unwrap());
    }
    let (bodies, ours) = run_all(gpu, precision, &by(&scene, solver));
    // Contact takes energy at least, up to the tolerances.
    assert!(ours.iter().all(|report| report.contact_energy <= 1e-4), "energy rises");
    let cpu = &simulation.state().unwrap().bodies;
    let off = bodies.position.iter().zip(&cpu.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let work = |reports: &[StepReport]| reports.iter().map(|report| report.friction_work.unwrap()).sum();
    let pushing =
        |reports: &[StepReport]| reports.iter().map(|report| report.sliding.unwrap() + report.sticking.unwrap()).sum();
    (off, [work(&ours), work(&theirs)], [pushing(&ours), pushing(&theirs)])
}

#[test]
fn a_heap_follows_the_cpus() {
    let Some(gpu) = device() else { return };
    for (precision, solver) in precisions(gpu).into_iter().flat_map(|precision| SOLVERS.map(|of| (precision, of))) {
        // In step 44 rods come to lie on the floor, where the law has many solutions, and rounding chooses.
        for (steps, [exact, rounded], counted) in [(43, [1e-10, 1e-5], 0.0), (60, [1e-3, 1e-3], 0.1)] {
            let (off, work, pushing) = beside_the_cpu(gpu, precision, solver, steps);
            println!(
                "{precision:?}, {solver}: after {steps} steps positions within {off:.1e}, work {work:?}, {pushing:?} pushes"
            );
            assert!(off <= if precision == Precision::F32 { rounded } else { exact }, "{precision:?} {steps}: {off:e}");
            assert!((work[0] / work[1] - 1.0).abs() <= 0.01 && work[1] > 0.3, "{work:?}");
            let apart = pushing[0].abs_diff(pushing[1]) as f64;
            assert!(apart <= counted * pushing[1] as f64 && pushing[1] > 90, "{pushing:?}");
        }
    }
}

/// A heap with friction and restitution, for resumes.
pub fn bouncing_heap() -> Scene {
    let mut scene = heap(50);
    scene["contact"]["restitution"] = json!(0.4);
    parse(&scene)
}

/// A heap with friction that the device solves.
pub fn heap_on_device(steps: u32) -> Scene {
    parse(&by(&heap(steps), "pair_block_cg"))
}

#[test]
fn a_solve_on_the_device_is_dispatched_there() {
    let Some(gpu) = own() else { return };
    for precision in precisions(&gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let [(_, host), (iterations, device)] = SOLVERS.map(|solver| {
            let scene = parse(&by(&heap(60), solver));
            let mut simulation = Simulation::builder(scene).on(&compute).build().unwrap();
            let before = gpu.counters().dispatches;
            let iterations: u64 = (0..60).map(|_| simulation.step().unwrap().iterations).sum();
            (iterations, gpu.counters().dispatches - before)
        });
        println!("{precision:?}: {iterations} iterations, {device} dispatches, {host} where the host solves");
        // In f32 the host takes the last iterations.
        let each = if precision == Precision::F32 { 1 } else { 5 };
        assert!(iterations > 50 && device > host + each * iterations, "{precision:?}: {iterations}");
    }
}

#[test]
fn one_row_a_pair_has_friction_too() {
    let Some(gpu) = device() else { return };
    let scene = |solver: &str| {
        let mut scene = by(&heap(40), solver);
        scene["contact"]["rows"] = json!("paper");
        scene["solver"]["tolerance"] = json!(1e-9);
        scene
    };
    let mut simulation = Simulation::new(parse(&scene("auto"))).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let cpu = &simulation.state().unwrap().bodies;
    for (precision, solver) in precisions(gpu).into_iter().flat_map(|precision| SOLVERS.map(|of| (precision, of))) {
        let (bodies, _) = run_all(gpu, precision, &scene(solver));
        let off = bodies.position.iter().zip(&cpu.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        println!("{precision:?}, {solver}: positions within {off:.1e}");
        assert!(off < if precision == Precision::F32 { 1e-5 } else { 1e-9 }, "{precision:?}, {solver}: {off:e}");
    }
}
