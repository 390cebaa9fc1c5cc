//! Studies of a device. Without an adapter they are skipped, unless `RELCP_REQUIRE_GPU` is set.
#![allow(clippy::unwrap_used)]

use relcp::gpu::{Choice, Gpu, Precision};
use relcp::record::{Folder, read_lcp};
use relcp::run::Run;
use relcp::scene::{Body, Scene};
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use relcp_lab::solvers::{Named, Size, measure};
use relcp_lab::throughput::{self, Kind};
use std::io::Write;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

fn open() -> Result<Arc<Gpu>, String> {
    let name = std::env::var("RELCP_ADAPTER").ok();
    Gpu::open(&Choice { name, software: true, ..Choice::default() }).map(Arc::new).map_err(|e| e.to_string())
}

/// The device, or `None` after a line that says so.
fn device() -> Option<&'static Arc<Gpu>> {
    static DEVICE: OnceLock<Result<Arc<Gpu>, String>> = OnceLock::new();
    match DEVICE.get_or_init(open) {
        Ok(gpu) => Some(gpu),
        Err(why) if std::env::var_os("RELCP_REQUIRE_GPU").is_some() => panic!("a GPU is required: {why}"),
        Err(why) => {
            // Not captured by the test harness.
            let _ = writeln!(std::io::stderr(), "SKIP: {why}");
            None
        }
    }
}

/// What computes, in each precision that the device has.
fn computes(gpu: &Arc<Gpu>) -> impl Iterator<Item = Compute> {
    let precisions = [Precision::F32].into_iter().chain(gpu.has_f64().then_some(Precision::F64));
    precisions.map(|precision| Compute::Gpu { gpu: gpu.clone(), precision })
}

/// Rods in rows that touch.
fn patch(side: usize) -> Scene {
    let mut scene = Scene::load("colony", ["time.end=1", "solver.dump.when=all", "solver.dump.most=4"]).unwrap();
    scene.generate.clear();
    for (i, k) in (0..side * side).map(|n| (n / side, n % side)) {
        let wave = ((7 * i + 3 * k) % 11) as f64 / 2048.0;
        let place = [2.4 * k as f64 + 0.6 * (i % 3) as f64 + wave, 0.502 * i as f64 - 0.5 * wave, 0.0];
        let mut body = Body::new(Shape::Spherocylinder { diameter: 0.5, length: 2.35 }, place);
        let turn = glam::DQuat::from_rotation_z(0.002 * (((5 * i + k) % 7) as f64 - 3.0));
        let turn = turn * glam::DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        body.orientation = Some([turn.w, turn.x, turn.y, turn.z]);
        scene.bodies.push(body);
    }
    scene
}

/// The study's default solver solves an LCP of the device on the CPU and on the device.
#[test]
fn lcps_of_a_device_are_studied() {
    let Some(gpu) = device() else { return };
    for compute in computes(gpu) {
        let mut simulation = Simulation::builder(patch(8)).on(&compute).build().unwrap();
        (0..4).for_each(|_| assert!(simulation.step().unwrap().max_overlap <= 1e-5));
        let kept = simulation.take_lcps();
        let named = Named { name: "kept".into(), lcp: kept[1].lcp.clone() };
        let instance = measure(&named, &[Compute::Cpu, compute.clone()], &Size::QUICK).unwrap();
        let ours: Vec<_> = instance.attempts.iter().filter(|attempt| attempt.solver == "pair_block_cg").collect();
        assert_eq!(ours.len(), 12);
        for attempt in ours {
            assert_eq!(attempt.status, "solved", "{attempt:?}");
            assert!(attempt.residual.unwrap() <= 1.1 * attempt.tolerance, "{attempt:?}");
        }
    }
}

#[test]
fn lcps_of_a_run_on_the_device_are_files_that_the_study_reads() {
    let Some(gpu) = device() else { return };
    let place = tempfile::tempdir().unwrap();
    // The paper's rows, of which a violation makes a second LCP.
    let sets = ["solver.dump.when=all", "solver.dump.most=2", "contact.rows=paper"];
    let scene = Scene::load("three-capsules", sets).unwrap();
    let compute = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    let folder = Folder::create(&place.path().join("run")).unwrap();
    let simulation = Simulation::builder(scene).on(&compute).build().unwrap();
    let mut run = Run::start(simulation, folder, Duration::ZERO).unwrap();
    while !run.done() {
        run.advance().unwrap();
    }
    run.finish().unwrap();
    let (lcp, header) = read_lcp(&place.path().join("run/lcps/step-000001-rec-1.npz")).unwrap();
    let header = header.unwrap();
    assert_eq!((header.precision.as_str(), header.status.as_str(), header.step), ("f32", "solved", 1));
    assert!(lcp.residual(&lcp.gamma) <= 1.1e-6 && lcp.q.len() == 5 && lcp.bodies == 3);
    let mut lab = assert_cmd::Command::cargo_bin("relcp-lab").unwrap();
    lab.current_dir(&place).args(["solvers", "run", "--quick", "--out", "studies", "--backend", "gpu", "--quiet"]);
    let output = lab.args(["--adapter", gpu.name(), "--precision", "f32"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(place.path().join("studies/solvers.csv")).unwrap();
    let of = |computed_by: &str| text.lines().filter(|line| line.contains(computed_by)).count();
    assert!(of("CPU f64") >= 2 * 36 && of(" f32") == of("CPU f64"), "{text}");
}

/// Dispatches, submissions and read-backs of a step of the stored colony of 1,024 cells.
#[test]
fn a_step_of_1024_rods_is_handed_over_and_waited_for_a_few_times() {
    if device().is_none() {
        return;
    }
    // A device of its own, as other tests count too.
    let gpu = open().unwrap();
    for compute in computes(&gpu) {
        let row = throughput::measure(Kind::Colony, 1024, [2, 4], &compute).unwrap();
        println!(
            "{} iterations, {} dispatches, {} submissions, {} read-backs a step",
            row.iterations, row.dispatches, row.submissions, row.reads
        );
        assert!(row.submissions <= 40.0 && row.reads <= 20.0, "{row:?}");
    }
}
