//! Steps on the device: laws, growth in space, mixed shapes, forces of a user's own, the same bits twice, buffers that
//! overflow, far from the origin, and what is refused.

use crate::device::{device, precisions};
use crate::long::precisions_of_long_runs;
use glam::{DQuat, DVec3};
use relcp::Error;
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::gpu::{Choice, Gpu, GpuError, Precision};
use relcp::lcp::Stored;
use relcp::record::state_hash;
use relcp::scene::{self, Scene};
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Fault, State, StepReport, contacts};
use relcp::warm::Warm;
use std::collections::BTreeMap;
use std::sync::Arc;

fn compute(gpu: &Arc<Gpu>, precision: Precision) -> Compute {
    Compute::Gpu { gpu: gpu.clone(), precision }
}

fn parse(text: &str) -> Scene {
    Scene::parse(text, "test").unwrap()
}

/// Takes `steps` steps of a scene from its start.
fn steps(compute: &Compute, scene: &Scene, steps: usize) -> (State, Vec<StepReport>) {
    let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
    let reports = (0..steps).map(|_| simulation.step().unwrap()).collect();
    (simulation.state().unwrap().clone(), reports)
}

/// How far two states are apart: positions, and turns times a length of one.
fn apart(a: &Bodies, b: &Bodies) -> f64 {
    let place = a.position.iter().zip(&b.position).map(|(x, y)| (*x - *y).length());
    let turn = |(p, q): (&DQuat, &DQuat)| (*p - *q).length().min((*p + *q).length());
    place.chain(a.orientation.iter().zip(&b.orientation).map(turn)).fold(0.0, f64::max)
}

/// Holds the device to the CPU's path over `count` steps.
fn follows_the_cpu(scene: &Scene, count: usize, f32_bound: f64, f64_bound: f64) {
    let Some(gpu) = device() else { return };
    let (cpu, cpu_reports) = steps(&Compute::Cpu, scene, count);
    assert!(cpu_reports.iter().any(|r| r.constraints > 0), "{}: no contact in {count} steps", scene.name);
    for precision in precisions(gpu) {
        let (state, reports) = steps(&compute(gpu, precision), scene, count);
        let off = apart(&state.bodies, &cpu.bodies);
        let worst = reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        println!("{} {precision:?}: off by {off:.1e}, worst overlap {worst:.1e}", scene.name);
        assert_eq!(state.bodies.lineage, cpu.bodies.lineage);
        assert!(worst <= 1e-5, "{worst:e}");
        assert!(off < if precision == Precision::F32 { f32_bound } else { f64_bound }, "{}: {off:e}", scene.name);
    }
}

#[test]
fn mixed_convex_shapes() {
    let scene = parse(
        r#"{"name": "mixed", "seed": 3, "time": {"dt": 0.02, "end": 2}, "forces": [{"radial_inward": {}}],
        "generate": [{"isotropic": {"count": 12, "shape": {"sphere": {"radius": 0.4}}, "volume_fraction": 0.02}},
                     {"isotropic": {"count": 12, "shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "volume_fraction": 0.05}},
                     {"isotropic": {"count": 12, "shape": {"ellipsoid": {"radii": [0.4, 0.7, 1.1]}}, "volume_fraction": 0.06}}]}"#,
    );
    follows_the_cpu(&scene, 100, 1e-3, 1e-5);
}

/// Of all pairs of shapes that a device has with superellipsoids.
pub fn crowd_of_superellipsoids() -> Scene {
    parse(
        r#"{"name": "superellipsoids", "seed": 3, "time": {"dt": 0.02, "end": 2}, "forces": [{"radial_inward": {}}],
        "walls": [{"half_space": {"normal": [0, 0, 1], "offset": -1}}, {"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4}}],
        "generate": [{"isotropic": {"count": 8, "shape": {"superellipsoid": {"radii": [0.4, 0.4, 0.4], "exponents": [5, 5]}},
          "region": {"box": {"minimum": [-2, -2, -0.9], "maximum": [2, 2, 4]}},
          "mixture": [{"count": 6, "shape": {"superellipsoid": {"radii": [0.3, 0.3, 0.8], "exponents": [8, 2.5]}}},
                      {"count": 4, "shape": {"sphere": {"radius": 0.4}}},
                      {"count": 4, "shape": {"spherocylinder": {"diameter": 0.5, "length": 1.5}}},
                      {"count": 4, "shape": {"ellipsoid": {"radii": [0.4, 0.5, 0.7]}}}]}}]}"#,
    )
}

#[test]
fn superellipsoids_with_other_shapes_and_walls() {
    follows_the_cpu(&crowd_of_superellipsoids(), 60, 5e-3, 1e-4);
}

/// Dice and tablets that fall onto each other and the floor of a tube, with inertia.
fn poured() -> Scene {
    parse(
        r#"{"name": "poured", "seed": 2, "time": {"dt": 0.01, "end": 1}, "dynamics": {"inertial": {"density": 1}},
        "forces": [{"gravity": {"acceleration": [0, 0, -9.81]}}],
        "walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}}, {"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1.5}}],
        "generate": [{"isotropic": {"count": 8, "shape": {"superellipsoid": {"radii": [0.4, 0.4, 0.4], "exponents": [5, 5]}},
          "region": {"box": {"minimum": [-1.5, -1.5, 0], "maximum": [1.5, 1.5, 9]}},
          "mixture": [{"count": 4, "shape": {"superellipsoid": {"radii": [0.6, 0.6, 0.3], "exponents": [2.5, 2]}}}]}}]}"#,
    )
}

#[test]
fn superellipsoids_are_poured() {
    follows_the_cpu(&poured(), 30, 1e-3, 1e-6);
}

/// The overlaps of all pairs in every state, in 64 bits on the CPU: at most the tolerance, and at most what the device
/// reports, but for what rounding hides of pairs that it finds apart.
#[test]
fn superellipsoids_overlap_by_no_more_than_the_tolerance() {
    let Some(gpu) = device() else { return };
    for (scene, count) in [(crowd_of_superellipsoids(), 60), (poured(), 100)] {
        for precision in precisions(gpu) {
            let mut simulation = Simulation::builder(scene.clone()).on(&compute(gpu, precision)).build().unwrap();
            let (mut worst, mut touching) = (0.0_f64, 0);
            let hidden = if precision == Precision::F32 { 5e-7 } else { 1e-12 };
            for _ in 0..count {
                let report = simulation.step().unwrap();
                let found = contacts(&simulation.state().unwrap().bodies, 0.0);
                let overlap = found.iter().map(|contact| -contact.separation).fold(0.0, f64::max);
                assert!(overlap <= report.max_overlap + hidden, "{precision:?} {overlap:e} {:e}", report.max_overlap);
                touching += found.len();
                worst = worst.max(overlap);
            }
            println!("{} {precision:?}: {touching} overlaps of at most {worst:e}", scene.name);
            assert!(touching > 0 && worst <= 1e-5, "{precision:?} {worst:e}");
        }
    }
}

#[test]
fn rings_rods_and_balls() {
    let scene = parse(
        r#"{"name": "rings", "seed": 5, "time": {"dt": 0.02, "end": 2}, "forces": [{"radial_inward": {}}],
        "generate": [{"isotropic": {"count": 8, "shape": {"torus": {"major_radius": 1, "minor_radius": 0.2}}, "volume_fraction": 0.01}},
                     {"isotropic": {"count": 8, "shape": {"spherocylinder": {"diameter": 0.3, "length": 2}}, "volume_fraction": 0.01}},
                     {"isotropic": {"count": 8, "shape": {"sphere": {"radius": 0.4}}, "volume_fraction": 0.01}}]}"#,
    );
    follows_the_cpu(&scene, 100, 2e-3, 1e-5);
}

#[test]
fn inertial_bodies_with_gravity_and_groups() {
    let scene = parse(
        r#"{"name": "inertial", "seed": 1, "time": {"dt": 0.005, "end": 1}, "dynamics": {"inertial": {"density": 1.5}},
        "forces": [{"gravity": {"acceleration": [0, 0, -2]}}, {"uniform": {"force": [0, 0, 40], "group": "up"}}],
        "bodies": [
          {"shape": {"ellipsoid": {"radii": [0.5, 0.8, 1.2]}}, "position": [0, 0, 2.1], "angular_velocity": [1, 2, 0.5]},
          {"shape": {"spherocylinder": {"diameter": 0.8, "length": 2.5}}, "position": [0.3, 0.2, 0], "group": "up", "velocity": [0, 0, 1],
           "orientation": [0.8, 0.6, 0, 0]},
          {"shape": {"sphere": {"radius": 0.7}}, "position": [0.2, 0.1, -2.2], "group": "up"}]}"#,
    );
    follows_the_cpu(&scene, 200, 5e-4, 1e-6);
}

#[test]
fn growth_and_division_in_space() {
    let scene = parse(
        r#"{"name": "growth", "seed": 2, "time": {"dt": 0.005, "end": 2.2},
        "growth": {"rate": 1, "division_length": 3, "reorientation_degrees": 20},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [0, 0, 0]},
                   {"shape": {"sphere": {"radius": 0.5}}, "position": [1.2, 0, 0.3]}]}"#,
    );
    follows_the_cpu(&scene, 320, 2e-3, 1e-5);
}

#[test]
fn a_force_of_the_users_own() {
    let Some(gpu) = device() else { return };
    let scene = Scene::load("two-ellipsoids", ["time.dt=0.05"]).unwrap();
    let ran = |compute: &Compute| {
        let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
        simulation.add_force(Box::new(|bodies: &Bodies, i: usize, time: f64| Load {
            force: DVec3::X * (0.1 * time) - 0.2 * bodies.position[i],
            torque: DVec3::Z * 0.3,
        }));
        for _ in 0..100 {
            simulation.step().unwrap();
        }
        simulation.state().unwrap().bodies.clone()
    };
    let off = apart(&ran(&compute(gpu, Precision::F32)), &ran(&Compute::Cpu));
    assert!(off < 1e-4, "{off:e}");
}

/// Rods packed side by side and end to end, each pressed by its neighbours from the start: `n x n` of them, some
/// overlapping a little.
pub fn patch(n: usize, offset: DVec3) -> Scene {
    let mut scene = Scene::load("colony", ["time.end=1"]).unwrap();
    scene.generate.clear();
    let along = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    for i in 0..n {
        for k in 0..n {
            // Uneven places, the same at every offset: multiples of 2^-20.
            let wave = ((7 * i + 3 * k) % 11) as f64 / 2048.0;
            let place = DVec3::new(2.4 * k as f64 + 0.6 * (i % 3) as f64 + wave, 0.502 * i as f64 - 0.5 * wave, 0.0);
            let place = (place * 1_048_576.0).round() / 1_048_576.0 + offset;
            let turn = DQuat::from_rotation_z(0.002 * (((5 * i + k) % 7) as f64 - 3.0)) * along;
            let rod = relcp::shape::Shape::Spherocylinder { diameter: 0.5, length: 2.35 };
            let mut body = scene::Body::new(rod, place.to_array());
            body.orientation = Some([turn.w, turn.x, turn.y, turn.z]);
            scene.bodies.push(body);
        }
    }
    scene
}

fn overlaps(bodies: &Bodies) -> Vec<([usize; 2], f64)> {
    contacts(bodies, 1e-4).into_iter().map(|contact| (contact.bodies, contact.separation)).collect()
}

#[test]
fn a_patch_far_from_the_origin_has_the_overlaps_of_one_at_it() {
    let Some(gpu) = device() else { return };
    let take = |offset| {
        let mut scene = patch(23, offset);
        scene.time.dt = 0.002;
        steps(&compute(gpu, Precision::F32), &scene, 4)
    };
    let (here, here_reports) = take(DVec3::ZERO);
    assert!(here.bodies.len() >= 500 && here_reports[3].constraints > 500, "{}", here_reports[3].constraints);
    let found = overlaps(&here.bodies);
    for offset in [DVec3::new(300.0, 300.0, 0.0), DVec3::new(2000.0, -1500.0, 0.0), DVec3::new(0.7, 1.0 / 3.0, 0.0)] {
        let (there, reports) = take(offset);
        let moved = overlaps(&there.bodies);
        let pairs = |list: &[([usize; 2], f64)]| list.iter().map(|(pair, _)| *pair).collect::<Vec<_>>();
        let both = found.iter().filter_map(|(pair, s)| moved.iter().find(|m| m.0 == *pair).map(|m| (s - m.1).abs()));
        let differ = both.fold(0.0, f64::max);
        let worst = reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        println!("moved by {offset}: overlaps differ by {differ:.1e}, worst {worst:.2e}, {} contacts", found.len());
        assert!(worst <= 1e-5, "{worst:e}");
        assert!(pairs(&moved).len().abs_diff(pairs(&found).len()) <= 2);
        assert!(differ < 1e-6, "{differ:e}");
    }
}

#[test]
fn a_slow_drift_is_not_lost_in_steps() {
    let Some(gpu) = device() else { return };
    let mut scene = parse(
        r#"{"name": "drift", "time": {"dt": 1, "end": 2000}, "dynamics": {"overdamped": {"drag": 1}},
        "forces": [{"uniform": {"force": [1e-8, 0, 0]}}],
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [1000.3, 0, 0]}]}"#,
    );
    scene.time.dt = 1.0;
    let (state, _) = steps(&compute(gpu, Precision::F32), &scene, 2000);
    let moved = state.bodies.position[0].x - 1000.3;
    assert!((moved / 2e-5 - 1.0).abs() < 0.01, "{moved:e}");
}

#[test]
fn two_runs_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    let scene = patch(12, DVec3::ZERO);
    for precision in precisions(gpu) {
        let [first, second] = [(); 2].map(|()| steps(&compute(gpu, precision), &scene, 6).0);
        assert_eq!(state_hash(&first), state_hash(&second), "{precision:?}");
    }
}

#[test]
fn buffers_that_overflow_drop_nothing() {
    let Some(gpu) = device() else { return };
    // A device of its own, so that no other test's buffers are small.
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, ..Choice::default() };
    let small = Arc::new(Gpu::open(&choice).unwrap());
    small.set_least_capacity(16);
    let scene = patch(40, DVec3::ZERO);
    let (ample, reports) = steps(&compute(gpu, Precision::F32), &scene, 3);
    let (grown, grown_reports) = steps(&compute(&small, Precision::F32), &scene, 3);
    assert!(ample.bodies.len() == 1600 && reports[2].constraints > 2000, "{}", reports[2].constraints);
    assert_eq!(state_hash(&ample), state_hash(&grown));
    let rows = |reports: &[StepReport]| reports.iter().map(|r| (r.constraints, r.products)).collect::<Vec<_>>();
    assert_eq!(rows(&reports), rows(&grown_reports));
    // From one cell to many: bodies overflow too.
    let colony = Scene::load("colony", ["time.end=3.6", "time.dt=0.005"]).unwrap();
    let [a, b] = [gpu, &small].map(|gpu| steps(&compute(gpu, Precision::F32), &colony, 720).0);
    assert!(a.bodies.len() >= 32);
    assert_eq!(state_hash(&a), state_hash(&b));
}

/// A device of a test's own that binds at most so many bytes at once.
pub fn with_banks(gpu: &Gpu, bytes: u64, default_limits: bool) -> Arc<Gpu> {
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, default_limits };
    let banked = Arc::new(Gpu::open(&choice).unwrap());
    banked.set_bank_bytes(bytes);
    banked
}

#[test]
fn buffers_larger_than_a_binding_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    // In the plane and in space, large enough for a dispatch a stage.
    let mut space = patch(24, DVec3::ZERO);
    space.planar = false;
    for scene in [patch(24, DVec3::ZERO), space] {
        for precision in precisions_of_long_runs(gpu) {
            let bytes = (1 << 13) * precision.bytes() as u64;
            let banked = with_banks(gpu, bytes, false);
            let (one, reports) = steps(&compute(gpu, precision), &scene, 2);
            let in_banks = || {
                let compute = compute(&banked, precision);
                let mut simulation = Simulation::builder(scene.clone()).on(&compute).build()?;
                (0..2).try_for_each(|_| simulation.step().map(|_| ()))?;
                let most = banked.buffers().iter().map(|(_, size)| size.div_ceil(bytes)).max().unwrap();
                Ok((simulation.state()?.clone(), most))
            };
            let (many, most) = match in_banks() {
                Err(Error::Fault(Fault::Device(fault @ GpuError::Bindings { .. }))) => {
                    println!("SKIP: {fault}");
                    continue;
                }
                many => many.unwrap(),
            };
            println!("{} rows, {most} banks at most", reports[1].constraints);
            assert!(most > 2, "{most} banks");
            assert_eq!(state_hash(&one), state_hash(&many), "{precision:?}");
        }
    }
}

#[test]
fn too_many_bindings_are_refused_by_name() {
    let Some(gpu) = device() else { return };
    let scene = patch(40, DVec3::ZERO);
    let least = with_banks(gpu, 1 << 13, true);
    let built = Simulation::builder(scene.clone()).on(&compute(&least, Precision::F32)).build();
    let fault = built.and_then(|mut simulation| Ok(simulation.step()?)).unwrap_err();
    let Error::Fault(Fault::Device(GpuError::Bindings { kernel, needs, has: 8, .. })) = &fault else {
        panic!("{fault}")
    };
    assert!(!kernel.is_empty() && *needs > 8);
}

#[test]
fn a_fault_leaves_the_last_accepted_state() {
    let Some(gpu) = device() else { return };
    let scene = Scene::built_in("three-capsules").unwrap();
    let mut simulation = Simulation::builder(scene.clone()).on(&compute(gpu, Precision::F32)).build().unwrap();
    simulation.add_force(Box::new(|_: &Bodies, i: usize, time: f64| Load {
        force: DVec3::splat(if time > 4e-4 && i == 1 { f64::NAN } else { 0.0 }),
        torque: DVec3::ZERO,
    }));
    let mut taken = 0;
    let fault = loop {
        match simulation.step() {
            Ok(report) => taken = report.step,
            Err(fault) => break fault,
        }
        assert!(taken < 20, "no fault");
    };
    assert!(matches!(fault, Fault::NotFinite { body: 1, .. }), "{fault}");
    let state = simulation.state().unwrap();
    assert_eq!(state.step, taken);
    assert!(state.bodies.position.iter().all(|x| x.is_finite()));
}

#[test]
fn what_only_the_cpu_does_is_refused() {
    let Some(gpu) = device() else { return };
    for set in ["contact.method={\"multisphere\":{\"count\":7}}", "solver.kind=dense", "solver.kind=interior_point"] {
        let scene = Scene::load("three-capsules", [set]).unwrap();
        let refused = Simulation::builder(scene).on(&compute(gpu, Precision::F32)).build().err();
        let unsupported =
            |error: &relcp::Error| matches!(error, relcp::Error::Fault(Fault::Device(GpuError::Unsupported { .. })));
        assert!(refused.as_ref().is_some_and(unsupported), "{set}: {refused:?}");
    }
}

/// The two bodies of a row, its two blocks of `J`, and `q`.
type Row = ([u32; 2], [Vec<f64>; 2], f64);

/// An LCP's rows by bodies, those of a pair in the order in which they were made; both blocks of each row and `q`.
fn ordered(lcp: &Stored) -> Vec<Row> {
    let block = |row: usize, side: usize| lcp.rows[side][row * lcp.unknowns..(row + 1) * lcp.unknowns].to_vec();
    let mut rows: Vec<_> = (0..lcp.q.len()).map(|i| (lcp.pair[i], [block(i, 0), block(i, 1)], lcp.q[i])).collect();
    rows.sort_by_key(|row| row.0);
    rows
}

/// How far the rows of two LCPs are apart: blocks of `J` as a part of the largest number in them, and `q`.
fn rows_apart(ours: &Stored, theirs: &Stored) -> (f64, f64) {
    let (ours, theirs) = (ordered(ours), ordered(theirs));
    let pairs = |rows: &[Row]| rows.iter().map(|row| row.0).collect::<Vec<_>>();
    assert_eq!(pairs(&ours), pairs(&theirs));
    let numbers = |rows: &[Row]| -> Vec<f64> { rows.iter().flat_map(|row| row.1.iter().flatten().copied()).collect() };
    let (a, b) = (numbers(&ours), numbers(&theirs));
    let largest = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let jacobian = a.iter().zip(&b).fold(0.0_f64, |worst, (x, y)| worst.max((x - y).abs())) / largest.max(1e-3);
    (jacobian, ours.iter().zip(&theirs).fold(0.0_f64, |worst, (x, y)| worst.max((x.2 - y.2).abs())))
}

/// How far the least `q` of each pair's rows are apart, of LCPs whose pairs are the same.
fn least_offsets_apart(ours: &Stored, theirs: &Stored) -> f64 {
    let least = |lcp: &Stored| {
        let mut least: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for (pair, q) in lcp.pair.iter().zip(&lcp.q) {
            least.entry(*pair).and_modify(|least| *least = least.min(*q)).or_insert(*q);
        }
        least
    };
    let (ours, theirs) = (least(ours), least(theirs));
    assert!(ours.keys().eq(theirs.keys()), "{ours:?} {theirs:?}");
    ours.values().zip(theirs.values()).fold(0.0, |worst: f64, (x, y)| worst.max((x - y).abs()))
}

/// The LCPs that a scene asks to be kept are those that the device solved: the same rows as the CPU's, and
/// multipliers that solve them.
#[test]
fn lcps_are_kept() {
    let Some(gpu) = device() else { return };
    let sets = ["solver.dump.when=all".to_string(), "solver.dump.most=4".into()];
    let mut divided = Scene::load("colony", &sets).unwrap();
    divided.growth[0].division_length = Some(2.001);
    let mut many = patch(8, DVec3::ZERO);
    many.solver.dump = divided.solver.dump;
    let mut capsules = Scene::load("three-capsules", &sets).unwrap();
    // An inexact recursion depends on the last digits.
    capsules.contact.recursion = scene::Recursion::Exact;
    for (scene, unknowns) in [(capsules, 6), (divided, 3), (many, 3)] {
        let kept = |compute: &Compute| {
            let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
            (0..4).for_each(|_| assert!(simulation.step().unwrap().max_overlap <= 1e-5));
            simulation.take_lcps()
        };
        let cpu = kept(&Compute::Cpu);
        assert_eq!(cpu.len(), 4);
        for precision in precisions(gpu) {
            let device = kept(&compute(gpu, precision));
            assert_eq!(device.len(), 4);
            for (ours, theirs) in device.iter().zip(&cpu) {
                let name = format!("{} {precision:?} {}.{}", scene.name, ours.step, ours.recursion);
                assert_eq!((ours.step, ours.recursion), (theirs.step, theirs.recursion), "{name}");
                assert_eq!((ours.lcp.unknowns, ours.lcp.bodies), (unknowns, theirs.lcp.bodies), "{name}");
                assert_eq!(ours.lcp.start.len(), ours.lcp.gamma.len());
                let exact = precision == Precision::F64;
                // From the second step on the states differ by what the solves may. In f32 parallel rods then touch in
                // one place on one machine and in two on the other.
                let rounded = !exact && ours.step > 1;
                let (jacobian, q) = match rounded {
                    true => (0.0, least_offsets_apart(&ours.lcp, &theirs.lcp)),
                    false => rows_apart(&ours.lcp, &theirs.lcp),
                };
                let residual = ours.lcp.residual(&ours.lcp.gamma);
                let largest = |v: &[f64]| v.iter().fold(0.0_f64, |worst, x| worst.max(x.abs()));
                let apart: Vec<f64> = ours.lcp.velocity.iter().zip(&theirs.lcp.velocity).map(|(a, b)| a - b).collect();
                let v = largest(&apart) / largest(&theirs.lcp.velocity).max(1e-3);
                println!(
                    "{name}: {} rows, J apart {jacobian:.1e}, q {q:.1e}, v {v:.1e}, residual {residual:.1e}",
                    ours.lcp.q.len()
                );
                // What the device measured of its own numbers, up to their rounding.
                assert!(residual <= if exact { 1.001e-6 } else { 1.1e-6 }, "{name}: {residual:e}");
                match (exact, rounded) {
                    (true, _) => assert!(jacobian <= 1e-12 && q <= 1e-12 && v <= 1e-9, "{name}"),
                    (false, false) => assert!(jacobian <= 1e-6 && q <= 1e-6 && v <= 1e-4, "{name}"),
                    (false, true) => assert!(q <= 1e-5, "{name}"),
                }
            }
            // The first solve starts from nothing, the next one of its step from what the first ended with, and new
            // rows from zero.
            let [first, second] = [&device[0], &device[1]];
            assert!(first.lcp.start.iter().all(|x| *x == 0.0));
            if second.recursion == 1 {
                let held = |gamma: &[f64]| {
                    let mut held: Vec<f64> = gamma.iter().copied().filter(|x| *x > 0.0).collect();
                    held.sort_by(f64::total_cmp);
                    held
                };
                assert_eq!(held(&second.lcp.start), held(&first.lcp.gamma));
                assert!(!held(&first.lcp.gamma).is_empty());
            }
        }
    }
}

#[test]
fn bodies_that_parted_do_not_go_on_pushing_each_other() {
    let Some(gpu) = device() else { return };
    let scene = parse(
        r#"{"name": "parted", "time": {"dt": 1e-3, "end": 1},
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0]},
                   {"shape": {"sphere": {"radius": 0.5}}, "position": [1.05, 0, 0]}]}"#,
    );
    for precision in precisions(gpu) {
        let bodies = scene.build().unwrap();
        let start = bodies.position[1];
        // Within the solver's tolerance in one step.
        let warm = vec![Warm { pair: [0, 1], feature: 0, gamma: 2e-4, normal: DVec3::X, tangent: DVec3::ZERO }];
        let state = State { step: 0, next_id: 2, bodies, warm, ..State::default() };
        let mut simulation =
            Simulation::builder(scene.clone()).on(&compute(gpu, precision)).resume(state).build().unwrap();
        for _ in 0..100 {
            let report = simulation.step().unwrap();
            assert_eq!((report.constraints, report.unconverged), (1, 0), "{report:?}");
        }
        let moved = (simulation.state().unwrap().bodies.position[1] - start).length();
        assert!(moved < 1e-6, "{precision:?} moved it by {moved:e}");
    }
}
