//! Members of an ensemble against the same scenes alone on the device.

use crate::device::device;
use crate::friction::heap_on_device;
use crate::long::precisions_of_long_runs;
use relcp::batch::{Ended, Member, Options, Plan, Watch, run as run_batch};
use relcp::gpu::{Ensemble, Gpu, Precision};
use relcp::record::state_hash;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scenes that differ in kernels, sizes and lengths.
fn scenes() -> Vec<Scene> {
    let colony = |seed: u64, rate: f64| {
        let sets =
            [format!("seed={seed}"), format!("growth.rate={rate}"), "time.dt=0.02".into(), "time.end=2.2".into()];
        Scene::load("colony", &sets).unwrap()
    };
    let short = |name: &str, sets: &[&str]| Scene::load(name, sets.iter().copied()).unwrap();
    vec![
        colony(1, 1.0),
        colony(2, 1.0),
        colony(3, 1.3),
        short("two-ellipsoids", &["time.end=0.2"]),
        short("chainmail", &["time.end=0.1"]),
        short("piston", &["time.end=0.05"]),
        short("three-capsules", &[]),
        short("ladder", &["time.end=0.2"]),
        heap_on_device(30),
    ]
}

fn run(gpu: Arc<Gpu>, precision: Precision, scene: Scene) -> String {
    let mut simulation = Simulation::builder(scene).on(&Compute::Gpu { gpu, precision }).build().unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    state_hash(simulation.state().unwrap())
}

#[test]
fn a_members_bits_are_those_of_the_scene_alone_on_that_device() {
    let Some(gpu) = device() else { return };
    for precision in precisions_of_long_runs(gpu) {
        let alone: Vec<String> = scenes().into_iter().map(|scene| run(gpu.clone(), precision, scene)).collect();
        let ensemble = Ensemble::new(gpu.clone()).unwrap();
        let together: Vec<String> = std::thread::scope(|scope| {
            let begin = |scene: Scene| {
                let member = ensemble.member();
                scope.spawn(move || run(member, precision, scene))
            };
            let threads: Vec<_> = scenes().into_iter().rev().map(begin).collect();
            threads.into_iter().rev().map(|thread| thread.join().unwrap()).collect()
        });
        println!("{precision:?}: {:?}", ensemble.rounds());
        assert_eq!(together, alone, "{precision:?}");
        assert!(ensemble.rounds().dispatches < ensemble.rounds().asked);
    }
}

/// Four colonies, and one in a container that is full in its third step.
fn plan() -> Plan {
    let text = r#"{ "name": "colonies", "scene": "colony",
        "set": { "time.dt": 0.02, "time.end": 0.7, "output.every": 10, "output.picture": false },
        "list": [ { "seed": 1 }, { "seed": 2, "growth.rate": 1.1 },
                  { "walls": [ { "cylinder": { "center": [0, 0, 0], "axis": [0, 0, 1], "radius": 1.05 } } ] },
                  { "seed": 4, "contact.overlap_tolerance": 1e-4 }, { "seed": 5 } ] }"#;
    Plan::parse(text, "sweep.json", Path::new(".")).unwrap()
}

/// Stops a batch after so many steps of all members.
struct After(u64, AtomicU64);

impl Watch for After {
    fn stop(&self) -> bool {
        self.1.load(Ordering::Relaxed) >= self.0
    }

    fn stepped(&self, _: &Member, _: &StepReport) {
        self.1.fetch_add(1, Ordering::Relaxed);
    }
}

/// Runs members of the plan, several at a time, and gives how each ended.
fn batch(gpu: &Arc<Gpu>, out: &Path, order: &[usize], jobs: usize, most_steps: u64) -> Vec<Ended> {
    let plan = plan();
    let members: Vec<Member> = order.iter().map(|index| plan.members()[*index].clone()).collect();
    let ensemble = (jobs > 1).then(|| Ensemble::new(gpu.clone()).unwrap());
    let settle = |_: &Scene| {
        let gpu = ensemble.as_ref().map_or_else(|| gpu.clone(), Ensemble::member);
        Ok(Compute::Gpu { gpu, precision: Precision::F32 })
    };
    let options = Options { jobs, threads: 2, retry: false };
    let watch = After(most_steps, AtomicU64::new(0));
    run_batch(&plan, out, &members, options, &settle, &watch).unwrap()
}

/// The final states, by the members' folders.
fn finals(out: &Path) -> Vec<(String, Vec<u8>)> {
    let folders = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap());
    let of = |entry: std::fs::DirEntry| {
        Some((entry.file_name().into_string().unwrap(), std::fs::read(entry.path().join("final.json")).ok()?))
    };
    let mut finals: Vec<_> = folders.filter_map(of).collect();
    finals.sort();
    finals
}

#[test]
fn a_batch_has_the_same_bits_in_any_packing_and_order_stopped_or_not_and_beside_one_that_fails() {
    let Some(gpu) = device() else { return };
    let folder = || tempfile::tempdir().unwrap();
    let (alone, together, reversed) = (folder(), folder(), folder());
    let twice = folder();
    let first = batch(gpu, alone.path(), &[0, 1, 2, 3, 4], 1, u64::MAX);
    let failed = |ended: &Ended| matches!(ended, Ended::Failed(_));
    let stopped: Vec<usize> = first.iter().enumerate().filter(|(_, e)| failed(e)).map(|(at, _)| at).collect();
    assert_eq!(stopped, [2], "{first:?}");
    batch(gpu, together.path(), &[0, 1, 2, 3, 4], 5, u64::MAX);
    batch(gpu, reversed.path(), &[4, 2, 0, 3, 1], 2, u64::MAX);
    batch(gpu, twice.path(), &[0, 1, 2, 3, 4], 3, 60);
    assert!(finals(twice.path()).len() < 5);
    batch(gpu, twice.path(), &[0, 1, 2, 3, 4], 5, u64::MAX);
    assert_eq!(finals(alone.path()).len(), 5);
    let expected = finals(alone.path());
    for (how, folder) in [("together", &together), ("reversed", &reversed), ("stopped", &twice)] {
        let one = finals(folder.path());
        let names = |all: &[(String, Vec<u8>)]| all.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&one), names(&expected), "{how}");
        for ((name, state), (_, expected)) in one.iter().zip(&expected) {
            assert!(state == expected, "{how}: {name}");
        }
    }
}

#[test]
fn a_member_for_whose_buffers_there_is_no_room_fails_alone() {
    let Some(gpu) = device() else { return };
    let ensemble = Ensemble::new(gpu.clone()).unwrap();
    let fit = ensemble.members_that_fit(100);
    assert!(fit * (400_000 + 400_000) <= ensemble.most_bytes() && fit > 0);
    // The arena is one binding.
    let too_large = ensemble.most_bytes() / 16;
    let scene = Scene::load("two-ellipsoids", ["time.end=0.02"]).unwrap();
    let member = ensemble.member();
    let refused = relcp::internals::gpu::Buffer::new(&member, "much", 32, too_large);
    assert!(refused.is_err_and(|fault| fault.to_string().contains("much")));
    let alone = run(gpu.clone(), Precision::F32, scene.clone());
    let last = ensemble.member();
    drop((member, ensemble));
    // A member is served after the ensemble itself is gone.
    assert_eq!(run(last, Precision::F32, scene), alone);
}

#[test]
fn a_batch_on_a_device_has_the_hashes_of_its_members_alone_whatever_threads_the_driver_has() {
    let Some(gpu) = device() else { return };
    let place = tempfile::tempdir().unwrap();
    let sweep = r#"{ "name": "sweep", "scene": "colony", "seeds": { "from": 1, "count": 4 },
        "set": { "time.dt": 0.02, "time.end": 1.2, "output.picture": false } }"#;
    std::fs::write(place.path().join("sweep.json"), sweep).unwrap();
    let hashes = |out: &str, arguments: &[&str], threads: Option<&str>| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_relcp"));
        command.current_dir(place.path()).args(["batch", "sweep.json", "--backend", "gpu", "--quiet", "--out", out]);
        command.args(["--adapter", gpu.name(), "--precision", "f32"]).args(arguments);
        // Without a number the program chooses: on a software adapter one device a thread, and no threads of the
        // driver.
        match threads {
            Some(number) => command.env("LP_NUM_THREADS", number),
            None => command.env_remove("LP_NUM_THREADS"),
        };
        let ran = command.output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        let table = std::fs::read_to_string(place.path().join(out).join("batch.json")).unwrap();
        let table: serde_json::Value = serde_json::from_str(&table).unwrap();
        let rows = table["members"].as_array().unwrap().iter();
        rows.map(|row| row["state_hash"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let alone = hashes("alone", &["--jobs", "1"], Some("2"));
    assert_eq!(alone.len(), 4);
    assert_eq!(hashes("together", &["--threads", "2"], Some("2")), alone);
    assert_eq!(hashes("side-by-side", &["--threads", "2"], None), alone);
    assert_eq!(hashes("three-devices", &["--threads", "3"], None), alone);
}
