//! Whole runs on the device against the CPU's, scene by scene.

use crate::device::{device, precisions};
use glam::DVec3;
use relcp::gpu::{Gpu, Precision};
use relcp::scene::{Scene, StopReason};
use relcp::simulation::{Compute, Simulation};
use relcp::step::{StepReport, contacts};
use std::sync::Arc;

#[test]
fn bits_do_not_depend_on_the_threads_of_a_software_adapter() {
    let Some(gpu) = device() else { return };
    let place = tempfile::tempdir().unwrap();
    let hash = |threads: Option<&str>| {
        let out = format!("threads-{}", threads.unwrap_or("unset"));
        let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
        command.current_dir(&place).args(["run", "colony", "--set", "time.dt=0.01", "--set", "time.end=3"]);
        command.args(["--backend", "gpu", "--adapter", gpu.name(), "--quiet", "--out", &out]);
        match threads {
            Some(threads) => command.env("LP_NUM_THREADS", threads),
            None => command.env_remove("LP_NUM_THREADS"),
        };
        command.assert().success();
        let text = std::fs::read_to_string(place.path().join(out).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        summary["state_hash"].as_str().unwrap().to_owned()
    };
    let without = hash(None);
    assert_eq!(hash(Some("2")), without);
    assert_eq!(hash(Some("0")), without);
}

/// A run's end and its reports.
struct Ran {
    simulation: Simulation,
    reports: Vec<StepReport>,
}

impl Ran {
    fn on(compute: &Compute, name: &str, sets: &[&str]) -> Ran {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        let scene = Scene::load(name, &sets).unwrap();
        let mut simulation = Simulation::builder(scene).on(compute).build().unwrap();
        let mut reports = Vec::new();
        while !simulation.done() {
            reports.push(simulation.step().unwrap());
        }
        Ran { simulation, reports }
    }

    fn positions(&self) -> Vec<DVec3> {
        self.simulation.state().unwrap().bodies.position.clone()
    }

    /// The largest overlap of the final state, in f64 on the CPU.
    fn audited(&self) -> f64 {
        let found = contacts(&self.simulation.state().unwrap().bodies, 0.0);
        found.iter().map(|contact| -contact.separation).fold(0.0, f64::max)
    }

    fn gyration(&self) -> f64 {
        let positions = self.positions();
        (positions.iter().map(|x| x.length_squared()).sum::<f64>() / positions.len() as f64).sqrt()
    }
}

fn on_device(gpu: &Arc<Gpu>, precision: Precision) -> Compute {
    Compute::Gpu { gpu: gpu.clone(), precision }
}

/// Runs a scene on the CPU and on the device in every precision, and holds the device to its tolerances and to the
/// CPU's recursions.
fn both(name: &str, sets: &[&str], check: impl Fn(Precision, &Ran, &Ran)) {
    let Some(gpu) = device() else { return };
    let cpu = Ran::on(&Compute::Cpu, name, sets);
    for precision in precisions(gpu) {
        let ran = Ran::on(&on_device(gpu, precision), name, sets);
        let same = ran.reports.iter().zip(&cpu.reports).filter(|(a, b)| a.recursions == b.recursions).count();
        let part = same as f64 / cpu.reports.len() as f64;
        let worst = ran.reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        let unconverged: u32 = ran.reports.iter().map(|r| r.unconverged).sum();
        let products = |ran: &Ran| ran.reports.iter().map(|r| r.products).sum::<u64>();
        println!(
            "{name} {precision:?}: {} steps, {:.1} % with the CPU's recursions, worst overlap {worst:.3e}, audited {:.3e}, unconverged {unconverged}, products {} (CPU {})",
            ran.reports.len(),
            100.0 * part,
            ran.audited(),
            products(&ran),
            products(&cpu),
        );
        assert_eq!(ran.reports.len(), cpu.reports.len());
        assert!(part >= 0.95, "{name} {precision:?}: {part}");
        assert!(worst <= 1e-5 && ran.audited() <= 1e-5, "{worst:e} {:e}", ran.audited());
        assert_eq!(unconverged, 0, "{name} {precision:?}");
        check(precision, &ran, &cpu);
    }
}

fn furthest(a: &Ran, b: &Ran) -> f64 {
    a.positions().iter().zip(b.positions()).map(|(x, y)| (*x - y).length()).fold(0.0, f64::max)
}

#[test]
fn three_capsules() {
    both("three-capsules", &["contact.recursion=exact"], |precision, ran, cpu| {
        let bound = if precision == Precision::F32 { 2e-5 } else { 1e-9 };
        assert!(furthest(ran, cpu) < bound, "{}", furthest(ran, cpu));
        let rows = |ran: &Ran| ran.reports.iter().map(|r| r.constraints).collect::<Vec<_>>();
        assert_eq!(rows(ran), rows(cpu));
    });
}

#[test]
fn two_ellipsoids_move_as_on_the_cpu() {
    both("two-ellipsoids", &["time.dt=0.01", "time.end=30"], |precision, ran, cpu| {
        let off = furthest(ran, cpu);
        println!("  positions off by {off:.1e}");
        assert!(off < if precision == Precision::F32 { 1e-4 } else { 1e-7 }, "{off:e}");
    });
}

/// Where early solves are loose, the trials depend on the last digits; what is promised does not.
#[test]
fn an_inexact_recursion_keeps_the_tolerances() {
    let Some(gpu) = device() else { return };
    // The paper's rows, which leave something to recur for.
    let sets = ["contact.recursion=inexact", "contact.rows=paper", "time.end=2.9"];
    let cpu = Ran::on(&Compute::Cpu, "colony", &sets);
    for precision in precisions(gpu) {
        let ran = Ran::on(&on_device(gpu, precision), "colony", &sets);
        let worst = ran.reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
        let recursions = |ran: &Ran| ran.reports.iter().map(|r| r.recursions).sum::<u32>();
        println!("{precision:?}: worst {worst:.3e}, recursions {} (CPU {})", recursions(&ran), recursions(&cpu));
        assert!(ran.reports.iter().all(|r| r.unconverged == 0 && r.residual <= 1.000_001e-6));
        assert!(worst <= 1e-5 && ran.audited() <= 1e-5 && recursions(&ran) > 0, "{worst:e} {:e}", ran.audited());
        let off = (ran.gyration() / cpu.gyration() - 1.0).abs();
        assert!(ran.simulation.bodies() == cpu.simulation.bodies() && off < 1e-3, "{off:e}");
    }
}

#[test]
fn colony_of_32_cells() {
    both("colony", &["time.end=3.5", "time.dt=0.002"], |_, ran, cpu| {
        let bodies = ran.simulation.state().unwrap().bodies.len();
        assert_eq!(bodies, cpu.simulation.bodies());
        assert!(bodies >= 32);
        assert!(ran.positions().iter().all(|x| x.z == 0.0));
        let off = (ran.gyration() / cpu.gyration() - 1.0).abs();
        println!("  {bodies} cells, radius of gyration off by {off:.1e}");
        assert!(off < 1e-3, "{off:e}");
    });
}

/// Lengths are prescribed, so that the same cells divide in the same steps as on the CPU.
#[test]
fn colony_of_uneven_cells_to_a_population() {
    let sets =
        ["growth.division_length_noise=0.2", "growth.rate_noise=0.3", "growth.stop.population=24", "time.dt=0.002"];
    both("colony", &sets, |_, ran, cpu| {
        let [on_device, on_cpu] = [ran, cpu].map(|ran| ran.simulation.state().unwrap().bodies.clone());
        assert_eq!(ran.simulation.stopped_by(), Some(StopReason::Population));
        assert_eq!((ran.simulation.steps(), &on_device.lineage), (cpu.simulation.steps(), &on_cpu.lineage));
        let lengths = on_device.shape.iter().zip(&on_cpu.shape);
        let off = lengths.map(|(a, b)| (a.growing_length().unwrap() / b.growing_length().unwrap() - 1.0).abs());
        let off = off.fold(0.0, f64::max);
        println!("  {} cells, lengths off by {off:.1e}", on_device.len());
        assert!(on_device.len() >= 24 && off < 1e-6, "{off:e}");
    });
}

#[test]
fn colony_to_a_radius_and_to_a_time() {
    for (stop, reason) in [("growth.stop.radius=3", StopReason::Radius), ("growth.stop.time=1.5", StopReason::Time)] {
        both("colony", &["time.dt=0.01", stop], |_, ran, cpu| {
            assert_eq!(ran.simulation.stopped_by(), Some(reason));
            assert_eq!(ran.simulation.steps(), cpu.simulation.steps());
        });
    }
}

#[test]
fn colony_that_pressure_slows() {
    let sets = ["growth.stress_sensitivity=0.2", "growth.reorientation_degrees=5", "time.dt=0.005", "time.end=3.5"];
    both("colony", &sets, |precision, ran, cpu| {
        let lengths = |ran: &Ran| {
            let bodies = &ran.simulation.state().unwrap().bodies;
            bodies
                .lineage
                .iter()
                .zip(&bodies.shape)
                .map(|(l, s)| (l.id, s.growing_length().unwrap()))
                .collect::<Vec<_>>()
        };
        let (on_device, on_cpu) = (lengths(ran), lengths(cpu));
        assert_eq!(on_device.len(), on_cpu.len());
        let off = on_device.iter().zip(&on_cpu).map(|(a, b)| (a.1 / b.1 - 1.0).abs()).fold(0.0, f64::max);
        let free = 2.0 * (1.0f64 * 3.5).exp() / on_cpu.iter().map(|(_, length)| length).sum::<f64>();
        println!("  {} cells, lengths off by {off:.1e}, {free:.2} times as much without pressure", on_device.len());
        // What the cells press each other with depends on how exactly they lie.
        assert!(off < if precision == Precision::F32 { 1e-3 } else { 1e-7 } && free > 1.1, "{off:e} {free}");
    });
}

#[test]
fn chainmail() {
    both("chainmail", &["time.end=1"], |_, ran, cpu| {
        println!("  positions off by {:.1e}", furthest(ran, cpu));
        assert!(furthest(ran, cpu) < 1e-3);
    });
}

#[test]
fn compaction_of_200_ellipsoids() {
    both("compaction", &["generate.0.isotropic.count=200", "time.end=60"], |_, ran, cpu| {
        let off = (ran.gyration() / cpu.gyration() - 1.0).abs();
        println!("  radius of gyration {} off by {off:.1e}", cpu.gyration());
        assert!(off < 1e-3, "{off:e}");
    });
}
