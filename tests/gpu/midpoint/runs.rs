//! Runs of midpoint steps on the device against the CPU's: their order, recursions, overlaps audited in f64, lengths,
//! forces in time, the same bits, what is left of a step that fails.

use crate::device::{device, precisions};
use crate::long::precisions_of_long_runs;
use crate::steps::{patch, with_banks};
use glam::{DQuat, DVec3};
use relcp::Error;
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::gpu::{Choice, Gpu, GpuError, Precision};
use relcp::record::state_hash;
use relcp::scene::{Scene, Stepping};
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Fault, State, StepReport, contacts};
use std::sync::Arc;

fn compute(gpu: &Arc<Gpu>, precision: Precision) -> Compute {
    Compute::Gpu { gpu: gpu.clone(), precision }
}

fn midpoint(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().copied().chain(["time.stepping=midpoint"]).map(str::to_owned).collect();
    Scene::load(name, &sets).unwrap()
}

fn parse(text: &str) -> Scene {
    let mut scene = Scene::parse(text, "test").unwrap();
    scene.time.stepping = Stepping::Midpoint;
    scene
}

struct Ran {
    state: State,
    reports: Vec<StepReport>,
}

impl Ran {
    fn on(compute: &Compute, scene: &Scene) -> Ran {
        let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
        let mut reports = Vec::new();
        while !simulation.done() {
            reports.push(simulation.step().unwrap());
        }
        Ran { state: simulation.state().unwrap().clone(), reports }
    }

    fn bodies(&self) -> &Bodies {
        &self.state.bodies
    }

    fn sum(&self, of: impl Fn(&StepReport) -> u64) -> u64 {
        self.reports.iter().map(of).sum()
    }
}

/// The largest overlap of bodies, and with walls, in f64 on the CPU.
fn audited(scene: &Scene, bodies: &Bodies) -> f64 {
    let pairs = contacts(bodies, 0.0).iter().fold(0.0_f64, |worst, contact| worst.max(-contact.separation));
    pairs.max(scene.walls().max_overlap(bodies))
}

/// How far positions and orientations of two runs are apart, and their velocities.
fn apart(a: &Bodies, b: &Bodies) -> [f64; 2] {
    let worst = |of: &dyn Fn(usize) -> f64| (0..a.len()).map(of).fold(0.0, f64::max);
    let turned = |p: DQuat, q: DQuat| (p - q).length().min((p + q).length());
    [
        worst(&|i| a.position[i].distance(b.position[i]).max(turned(a.orientation[i], b.orientation[i]))),
        worst(&|i| a.velocity[i].distance(b.velocity[i]).max(a.angular_velocity[i].distance(b.angular_velocity[i]))),
    ]
}

/// Holds the device to the CPU's recursions and to the tolerance, and in f32 and f64 to its places as far as `bounds`.
fn follows_the_cpu(scene: &Scene, bounds: [f64; 2], check: impl Fn(Precision, &Ran, &Ran)) {
    let Some(gpu) = device() else { return };
    let cpu = Ran::on(&Compute::Cpu, scene);
    let recursions = |ran: &Ran| ran.sum(|r| u64::from(r.recursions));
    assert!(recursions(&cpu) >= 3, "{}: nothing to recur for", scene.name);
    for precision in precisions(gpu) {
        let ran = Ran::on(&compute(gpu, precision), scene);
        let same = ran.reports.iter().zip(&cpu.reports).filter(|(a, b)| a.recursions == b.recursions).count();
        let part = same as f64 / cpu.reports.len() as f64;
        let worst = ran.reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        let (found, [off, speeds]) = (audited(scene, ran.bodies()), apart(ran.bodies(), cpu.bodies()));
        println!(
            "{} {precision:?}: {:.1} % of {} steps with the CPU's recursions ({} and {}), worst {worst:.2e}, audited {found:.2e}, {} bodies off by {off:.1e}, velocities by {speeds:.1e}, products {} (CPU {})",
            scene.name,
            100.0 * part,
            ran.reports.len(),
            recursions(&ran),
            recursions(&cpu),
            ran.bodies().len(),
            ran.sum(|r| r.products),
            cpu.sum(|r| r.products),
        );
        assert_eq!((ran.reports.len(), &ran.bodies().lineage), (cpu.reports.len(), &cpu.bodies().lineage));
        assert!(ran.reports.iter().all(|r| r.unconverged == 0));
        let told = |ran: &Ran| ran.sum(|r| u64::from(r.passed.is_some()));
        assert_eq!(told(&ran), told(&cpu));
        assert!(part >= 0.95 && worst <= 1e-5 && found <= 1e-5, "{}: {part} {worst:e} {found:e}", scene.name);
        assert!(off < bounds[usize::from(precision == Precision::F64)], "{}: {off:e}", scene.name);
        check(precision, &ran, &cpu);
    }
}

#[test]
fn two_ellipsoids_pass_at_second_order() {
    let Some(gpu) = device() else { return };
    let at = |compute: &Compute, dt: f64| {
        let ran = Ran::on(compute, &midpoint("two-ellipsoids", &[&format!("time.dt={dt}"), "time.end=16"]));
        assert!(ran.reports.iter().all(|r| r.max_overlap <= 1e-5 && r.unconverged == 0));
        ran
    };
    let fine = at(&Compute::Cpu, 0.00625);
    let steps = [0.2, 0.1, 0.05];
    let on_cpu = steps.map(|dt| at(&Compute::Cpu, dt));
    for precision in precisions(gpu) {
        let coarse = steps.map(|dt| at(&compute(gpu, precision), dt));
        let errors = coarse.each_ref().map(|ran| ran.bodies().position[0].distance(fine.bodies().position[0]));
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        let off = coarse.iter().zip(&on_cpu).map(|(ran, cpu)| apart(ran.bodies(), cpu.bodies())[0]).fold(0.0, f64::max);
        println!("{precision:?}: errors {errors:?}, orders {orders:.2?}, off from the CPU's by {off:.1e}");
        assert!(orders.iter().all(|order| *order >= 1.8), "{precision:?}: {errors:?}");
        assert!(off < if precision == Precision::F32 { 1e-4 } else { 1e-7 }, "{precision:?}: {off:e}");
    }
}

#[test]
fn a_colony_of_32_cells() {
    let gyration = |bodies: &Bodies| {
        (bodies.position.iter().map(|x| x.length_squared()).sum::<f64>() / bodies.len() as f64).sqrt()
    };
    // It buckles, so that cells in f32 end elsewhere; the colony is as large.
    follows_the_cpu(&midpoint("colony", &["time.end=3.5", "time.dt=0.01"]), [0.5, 1e-5], |_, ran, cpu| {
        assert!(ran.bodies().len() >= 32 && ran.bodies().position.iter().all(|x| x.z == 0.0));
        let off = (gyration(ran.bodies()) / gyration(cpu.bodies()) - 1.0).abs();
        println!("  radius of gyration off by {off:.1e}");
        assert!(off < 1e-3, "{off:e}");
    });
}

#[test]
fn compaction_of_40_ellipsoids() {
    let sets = ["generate.0.isotropic.count=40", "time.end=60", "time.dt=0.3"];
    follows_the_cpu(&midpoint("compaction", &sets), [1e-2, 1e-5], |_, _, _| ());
}

/// Two ellipsoids and a rod that spin, collide and are held together.
fn collision() -> Scene {
    parse(
        r#"{"name": "collision", "seed": 1, "time": {"dt": 0.01, "end": 1}, "dynamics": {"inertial": {"density": 1.5}},
        "forces": [{"gravity": {"acceleration": [0, 0, -2]}}, {"uniform": {"force": [0, 0, 40], "group": "up"}}],
        "bodies": [
          {"shape": {"ellipsoid": {"radii": [0.5, 0.8, 1.2]}}, "position": [0, 0, 2.1], "angular_velocity": [1, 2, 0.5]},
          {"shape": {"spherocylinder": {"diameter": 0.8, "length": 2.5}}, "position": [0.3, 0.2, 0], "group": "up", "velocity": [0, 0, 1],
           "orientation": [0.8, 0.6, 0, 0]},
          {"shape": {"ellipsoid": {"radii": [0.7, 0.6, 0.8]}}, "position": [0.2, 0.1, -2.2], "group": "up", "angular_velocity": [0, 3, 0]}]}"#,
    )
}

#[test]
fn bodies_with_inertia() {
    follows_the_cpu(&collision(), [1e-4, 1e-8], |precision, ran, cpu| {
        let [_, speeds] = apart(ran.bodies(), cpu.bodies());
        assert!(speeds < if precision == Precision::F32 { 1e-2 } else { 1e-6 }, "{speeds:e}");
    });
}

/// Cells of uneven lengths and rates that pressure slows, with inertia, in a disc.
#[test]
fn growing_cells_with_inertia_between_walls() {
    let scene = parse(
        r#"{"name": "disc", "seed": 4, "planar": true, "time": {"dt": 0.02, "end": 2.4}, "dynamics": {"inertial": {"density": 1}},
        "walls": [{"cylinder": {"center": [0.1, 0, 0], "axis": [0, 0, 1], "radius": 1.6}}],
        "growth": {"rate": 1, "division_length": 2, "division_length_noise": 0.2, "rate_noise": 0.2, "reorientation_degrees": 2, "stress_sensitivity": 0.02},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.2}}, "position": [0, 0, 0], "orientation": [0.7071067811865476, 0, 0.7071067811865476, 0]}]}"#,
    );
    follows_the_cpu(&scene, [1e-2, 1e-6], |precision, ran, cpu| {
        assert!(ran.bodies().len() >= 6);
        assert!(ran.reports.iter().any(|r| r.worst_wall.is_some()));
        assert!(ran.bodies().position.iter().chain(&ran.bodies().velocity).all(|x| x.z == 0.0));
        let lengths = ran.bodies().shape.iter().zip(&cpu.bodies().shape);
        let off = lengths.map(|(a, b)| (a.growing_length().unwrap() / b.growing_length().unwrap() - 1.0).abs());
        let off = off.fold(0.0, f64::max);
        println!("  lengths off by {off:.1e}");
        // They grow by their pressures, which in f32 are those of another contact a little apart.
        assert!(off < if precision == Precision::F32 { 3e-4 } else { 1e-7 }, "{off:e}");
    });
}

/// Rings, rods and balls on the floor of a box.
#[test]
fn a_fall_into_a_box() {
    let scene = parse(
        r#"{"name": "box", "time": {"dt": 0.04, "end": 2.4}, "walls": [{"box": {"minimum": [-1.8, -1.8, -1.8], "maximum": [1.8, 1.8, 8]}}],
        "forces": [{"uniform": {"force": [0.3, 0, -2]}}],
        "bodies": [
          {"shape": {"torus": {"major_radius": 0.7, "minor_radius": 0.1}}, "position": [-0.8, -0.8, -0.6], "orientation": [1, 0.4, 0.2, 0]},
          {"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.6}}, "position": [0.8, -0.7, -0.6], "orientation": [1, 0.6, -0.3, 0.2]},
          {"shape": {"sphere": {"radius": 0.5}}, "position": [-0.7, 0.8, -0.5], "orientation": [1, -0.4, 0.8, 0.1]},
          {"shape": {"torus": {"major_radius": 0.7, "minor_radius": 0.1}}, "position": [0.7, 0.8, 1.2], "orientation": [1, -0.2, 0.9, 0.1]},
          {"shape": {"spherocylinder": {"diameter": 0.4, "length": 1.4}}, "position": [0.6, -0.6, 1.3], "orientation": [1, 0.5, 0.1, 0.3]}]}"#,
    );
    follows_the_cpu(&scene, [2e-3, 1e-5], |_, ran, _| {
        assert!(ran.reports.iter().filter(|r| r.worst_wall.is_some()).count() >= 10);
    });
}

#[test]
fn cells_divide_and_push_their_own_kind_through_a_boundary() {
    let scene = parse(
        r#"{"name": "periodic cells", "seed": 3, "planar": true, "time": {"dt": 0.04, "end": 3.0}, "periodic": {"lengths": [9, 14, null]},
        "growth": {"rate": 1.0, "division_length": 4.0, "reorientation_degrees": 5.0},
        "generate": [{"founder": {"diameter": 0.5, "length": 2.0}}]}"#,
    );
    follows_the_cpu(&scene, [5e-3, 1e-6], |_, ran, _| {
        let outside = ran.bodies().position.iter().filter(|x| x.x.abs() > 4.5).count();
        assert!(ran.bodies().len() >= 16 && outside >= 1, "{outside}");
    });
}

/// A force that changes in time and with velocity is asked for at the start and in the middle.
#[test]
fn a_force_of_the_users_own_is_that_of_the_middle() {
    let Some(gpu) = device() else { return };
    let scene = collision();
    let ran = |compute: &Compute| {
        let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
        simulation.add_force(Box::new(|bodies: &Bodies, i: usize, time: f64| Load {
            force: DVec3::X * (20.0 * (9.0 * time).sin()) - 0.5 * bodies.velocity[i],
            torque: DVec3::Z * 0.3,
        }));
        for _ in 0..40 {
            simulation.step().unwrap();
        }
        simulation.state().unwrap().bodies.clone()
    };
    let cpu = ran(&Compute::Cpu);
    for precision in precisions(gpu) {
        let off = apart(&ran(&compute(gpu, precision)), &cpu);
        println!("{precision:?}: places off by {:.1e}, velocities by {:.1e}", off[0], off[1]);
        let bound = if precision == Precision::F32 { 1e-4 } else { 1e-8 };
        assert!(off[0] < bound && off[1] < 100.0 * bound, "{precision:?}: {off:?}");
    }
}

/// What the first half ends with is not taken for what the last accepted step remembers.
#[test]
fn a_fault_in_the_middle_leaves_the_last_accepted_state() {
    let Some(gpu) = device() else { return };
    let mut scene = patch(4, DVec3::ZERO);
    scene.time.stepping = Stepping::Midpoint;
    let (dt, taken) = (scene.time.dt, 3);
    for precision in precisions(gpu) {
        let start = || Simulation::builder(scene.clone()).on(&compute(gpu, precision)).build().unwrap();
        let mut simulation = start();
        let last = (f64::from(taken) + 0.25) * dt;
        simulation.add_force(Box::new(move |_: &Bodies, i: usize, time: f64| Load {
            force: DVec3::splat(if time > last && i == 1 { f64::NAN } else { 0.0 }),
            torque: DVec3::ZERO,
        }));
        let mut undisturbed = start();
        for _ in 0..taken {
            simulation.step().unwrap();
            undisturbed.step().unwrap();
        }
        let fault = simulation.step().unwrap_err();
        assert!(matches!(fault, Fault::NotFinite { body: 1, .. }), "{fault}");
        let (left, kept) = (simulation.state().unwrap(), undisturbed.state().unwrap());
        assert_eq!((left.step, &left.bodies), (u64::from(taken as u32), &kept.bodies));
        let multipliers = |state: &State| state.warm.iter().map(|w| (w.pair, w.gamma)).collect::<Vec<_>>();
        assert_eq!(multipliers(left), multipliers(kept));
        assert!(left.warm.iter().any(|w| w.gamma > 0.0));
    }
}

fn hashed(ran: &Ran) -> (String, u64, u64) {
    (state_hash(&ran.state).to_string(), ran.sum(|r| r.products), ran.sum(|r| u64::from(r.recursions)))
}

#[test]
fn two_runs_and_one_with_buffers_that_overflow_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, ..Choice::default() };
    let small = Arc::new(Gpu::open(&choice).unwrap());
    small.set_least_capacity(16);
    let scene = midpoint("colony", &["time.end=2.9", "time.dt=0.02"]);
    for precision in precisions(gpu) {
        let [first, second, grown] = [gpu, gpu, &small].map(|gpu| hashed(&Ran::on(&compute(gpu, precision), &scene)));
        assert!(first.2 > 0);
        assert!(first == second && first == grown, "{precision:?}: {first:?} {second:?} {grown:?}");
    }
}

#[test]
fn buffers_larger_than_a_binding_give_the_same_bits() {
    let Some(gpu) = device() else { return };
    let mut scene = patch(24, DVec3::ZERO);
    scene.time.stepping = Stepping::Midpoint;
    for precision in precisions_of_long_runs(gpu) {
        let bytes = (1 << 13) * precision.bytes() as u64;
        let banked = with_banks(gpu, bytes, false);
        let after = |gpu: &Arc<Gpu>| {
            let compute = compute(gpu, precision);
            let mut simulation = Simulation::builder(scene.clone()).on(&compute).build()?;
            (0..2).for_each(|_| assert!(simulation.step().is_ok()));
            let most = gpu.buffers().iter().map(|(_, size)| size.div_ceil(bytes)).max().unwrap();
            Ok((state_hash(simulation.state().unwrap()), most))
        };
        let one = after(gpu).unwrap();
        let many = match after(&banked) {
            Err(Error::Fault(Fault::Device(fault @ GpuError::Bindings { .. }))) => {
                println!("SKIP: {fault}");
                continue;
            }
            many => many.unwrap(),
        };
        println!("{precision:?}: {} banks at most", many.1);
        assert!(many.1 > 2);
        assert_eq!(one.0, many.0, "{precision:?}");
    }
}

#[test]
fn a_run_goes_on_from_its_state() {
    let Some(gpu) = device() else { return };
    let scene = midpoint("three-capsules", &[]);
    for precision in precisions(gpu) {
        let [ours, cpu] = [compute(gpu, precision), Compute::Cpu];
        for (from, to) in [(&ours, &ours), (&ours, &cpu), (&cpu, &ours)] {
            let mut whole = Simulation::builder(scene.clone()).on(from).build().unwrap();
            (0..4).for_each(|_| assert!(whole.step().is_ok()));
            let half = whole.state().unwrap().clone();
            let mut resumed = Simulation::builder(scene.clone()).on(to).resume(half).build().unwrap();
            for _ in 0..4 {
                let (one, other) = (whole.step().unwrap(), resumed.step().unwrap());
                // In 32 bits two machines may differ in whether a trial is within the tolerance.
                if precision == Precision::F64 || std::ptr::eq(from, to) {
                    assert_eq!((one.recursions, one.constraints), (other.recursions, other.constraints));
                }
            }
            let off = apart(&whole.state().unwrap().bodies, &resumed.state().unwrap().bodies)[0];
            assert!(off < if precision == Precision::F32 { 1e-5 } else { 1e-9 }, "{off:e}");
        }
    }
}
