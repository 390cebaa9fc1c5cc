//! One run by several processes, started by `mpirun`: the bits of one process, at any number of them; checkpoints that
//! any number takes up; processes that are killed; bad input.
//!
//! They need the feature `mpi` and an `mpirun`; without one they print `SKIP`, but with `RELCP_REQUIRE_MPI=1` they
//! fail.
#![allow(clippy::unwrap_used)]

use assert_cmd::cargo::cargo_bin;
use std::path::Path;
use std::process::{Command, Output, Stdio};

#[cfg(feature = "mpi")]
mod together {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use relcp::Scene;
    use relcp::record::read_state;
    use serde_json::{Value, json};
    use std::fs;
    use std::time::Duration;

    fn has_mpirun(test: &str) -> bool {
        let found = Command::new("mpirun").arg("--version").output().is_ok_and(|output| output.status.success());
        assert!(found || std::env::var_os("RELCP_REQUIRE_MPI").is_none(), "{test}: mpirun is required");
        if !found {
            println!("SKIP {test}: there is no mpirun");
        }
        found
    }

    fn mpirun(place: &Path, processes: usize) -> Command {
        let mut command = Command::new("mpirun");
        // Open MPI refuses the user root, and more processes than cores, unless it is told.
        for allowed in ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_rmaps_base_oversubscribe"]
        {
            command.env(allowed, "1");
        }
        command.current_dir(place).args(["-n", &processes.to_string()]).arg(cargo_bin("relcp"));
        command.stdin(Stdio::null());
        command
    }

    fn by_processes(place: &Path, processes: usize, arguments: &[&str]) -> Output {
        let mut command = mpirun(place, processes);
        command.args(["run", "--backend", "mpi", "--quiet"]).args(arguments);
        command.output().unwrap()
    }

    fn by_the_cpu(place: &Path, arguments: &[&str]) {
        let mut command = Command::new(cargo_bin("relcp"));
        command.current_dir(place).args(["run", "--backend", "cpu", "--quiet"]).args(arguments);
        assert!(command.status().unwrap().success(), "{arguments:?}");
    }

    fn summary(folder: &Path) -> Value {
        serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap()
    }

    /// What must not depend on who computed: the state, the counts, all rows but their wall times, and the lives that
    /// ended.
    fn result(folder: &Path) -> (Value, Value, Vec<String>, Option<String>) {
        let summary = summary(folder);
        let steps = fs::read_to_string(folder.join("steps.csv")).unwrap();
        let rows = steps.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect();
        let lives = fs::read_to_string(folder.join("lineage.csv")).ok();
        (summary["state_hash"].clone(), summary["solver"]["products"].clone(), rows, lives)
    }

    fn said(output: &Output) -> String {
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    /// A scene that starts from a stored state, written to a file.
    fn from_state(place: &Path, scene: &str, state: &str, steps: u32) -> String {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/states");
        let (header, state) = read_state(&assets.join(state)).unwrap();
        let scene = Scene::built_in(scene).unwrap();
        let mut scene = scene.final_scene(&state.bodies, header.time);
        scene.time.end = scene.time.start + f64::from(steps) * scene.time.dt;
        let name = format!("{}.json", scene.name);
        scene.write_json(&mut fs::File::create(place.join(&name)).unwrap()).unwrap();
        name
    }

    fn same_for_any_number(place: &Path, name: &str, arguments: &[&str], numbers: &[usize]) -> Value {
        let with_out = |out: &str| [arguments, &["--out", out]].concat().iter().map(|a| (*a).to_owned()).collect();
        let alone: Vec<String> = with_out(&format!("{name}-cpu"));
        by_the_cpu(place, &alone.iter().map(String::as_str).collect::<Vec<_>>());
        let expected = result(&place.join(format!("{name}-cpu")));
        for processes in numbers {
            let out = format!("{name}-{processes}");
            let together: Vec<String> = with_out(&out);
            let output = by_processes(place, *processes, &together.iter().map(String::as_str).collect::<Vec<_>>());
            assert!(output.status.success(), "{name}, {processes} processes: {}", said(&output));
            assert!(result(&place.join(&out)) == expected, "{name}, {processes} processes");
        }
        let summary = summary(&place.join(format!("{name}-cpu")));
        assert_eq!(summary["status"], "done", "{name}");
        summary
    }

    #[test]
    fn a_large_problem_is_the_same_bits_for_any_number_of_processes() {
        if !has_mpirun("a large problem") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        // In the plane with cells that grow and divide: rows enough for three processes to share the iterations.
        let colony = from_state(place.path(), "colony", "colony-1024.npz", 2);
        let summary =
            same_for_any_number(place.path(), "packed", &[&colony, "--set", "output.picture=false"], &[1, 2, 3]);
        assert!(summary["constraints"]["max"].as_u64().unwrap() > 3 * 768, "{summary}");
        // In space.
        let compaction = from_state(place.path(), "compaction", "compaction-1000.npz", 2);
        let summary =
            same_for_any_number(place.path(), "ball", &[&compaction, "--set", "output.picture=false"], &[2, 4]);
        assert!(summary["constraints"]["max"].as_u64().unwrap() > 2 * 768, "{summary}");
    }

    #[test]
    fn every_kind_of_scene_is_the_same_bits() {
        if !has_mpirun("every kind of scene") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        for (scene, end, numbers) in [
            ("colony", 2.5, vec![2, 8]),      // divisions; more processes than bodies at first
            ("chainmail", 0.5, vec![3]),      // rings in space
            ("sedimentation", 0.02, vec![2]), // periodic, thermal, a floor
            ("two-strains", 0.5, vec![2]),    // a channel, species, removal
            ("filament", 0.1, vec![2]),       // bonds in a shear flow
            ("piston", 0.1, vec![2]),         // a moving wall
        ] {
            let end = format!("time.end={end}");
            same_for_any_number(place.path(), scene, &[scene, "--set", &end], &numbers);
        }
    }

    /// A lattice of spheres with bonds between neighbours, some of which break.
    fn net() -> Value {
        const SIDE: usize = 24;
        let (mut bodies, mut bonds) = (Vec::new(), Vec::new());
        for body in 0..SIDE * SIDE {
            let (x, y) = (1.1 * (body / SIDE) as f64, 1.1 * (body % SIDE) as f64);
            let position = [x, y, 0.05 * (x * y).sin()];
            bodies.push(json!({ "shape": { "sphere": { "radius": 0.5 } }, "position": position }));
            let mut join = |other: usize| {
                let at = [[0.0; 3]; 2];
                let bond =
                    json!({ "bodies": [other, body], "at": at, "stiffness": 50.0, "length": 1.0, "break_force": 6.0 });
                bonds.push(bond);
            };
            if body >= SIDE {
                join(body - SIDE);
            }
            if body % SIDE > 0 {
                join(body - 1);
            }
        }
        json!({
            "name": "net", "seed": 3, "bodies": bodies, "bonds": bonds,
            "dynamics": { "overdamped": { "drag": 1.0 } },
            "thermal": { "temperature": 0.01 },
            "flow": { "shear": { "rate": 0.5, "direction": [1, 0, 0], "gradient": [0, 1, 0] } },
            "time": { "dt": 0.002, "end": 0.03 },
        })
    }

    /// A sphere that is shot at one of a layer of others, far past the box that its neighbours know.
    fn shot() -> Value {
        const SIDE: usize = 26;
        let at = |k: usize| [4.0 * (k / SIDE) as f64, 4.0 * (k % SIDE) as f64, 0.0];
        let shape = json!({ "sphere": { "radius": 0.5 } });
        let layer = (0..SIDE * SIDE).map(|k| json!({ "shape": shape, "position": at(k) }));
        let shot = json!({ "shape": shape, "position": [-1.2, 40.0, 0.1], "group": "shot" });
        let bodies: Vec<Value> = layer.chain([shot]).collect();
        json!({
            "name": "shot", "seed": 1, "bodies": bodies,
            "dynamics": { "overdamped": { "drag": 1.0 } },
            "forces": [ { "uniform": { "force": [3e4, 0, 0], "group": "shot" } } ],
            "time": { "dt": 0.01, "end": 0.02 },
        })
    }

    fn write(place: &Path, scene: &Value) -> String {
        let name = format!("{}.json", scene["name"].as_str().unwrap());
        fs::write(place.join(&name), scene.to_string()).unwrap();
        name
    }

    /// Scenes of so many bodies that each process has a domain of them.
    #[test]
    fn domains_of_every_kind_of_scene_come_to_the_same_bits() {
        if !has_mpirun("domains") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        let colony = from_state(place.path(), "colony", "colony-1024.npz", 2);
        // Long enough for cells to divide, to leave, and to go from one process to another. Trials of some steps throw
        // cells: those everyone takes alone.
        let long = ["time.dt=0.005", "time.end=7.1"];
        let (net, shot) = (write(place.path(), &net()), write(place.path(), &shot()));
        let channel = [
            "walls=[{\"half_space\":{\"normal\":[0,1,0],\"offset\":-22.5}},\
             {\"half_space\":{\"normal\":[0,-1,0],\"offset\":-22.5}}]",
            "removal=[{\"outside\":{\"half_space\":{\"normal\":[-1,0,0],\"offset\":-21.0}}},{\"rate\":0.5}]",
            long[0],
            long[1],
        ];
        // Where a colony's radius ends the run, all processes are asked for all bodies after each step.
        let radius = ["growth.stop.radius=1000", "growth.stress_sensitivity=0.1", long[0], long[1]];
        let suspension = ["generate.0.isotropic.count=600", "periodic.lengths=[14,14,null]", "time.end=0.05"];
        let mail = ["generate.0.chainmail.columns=24", "generate.0.chainmail.rows=24", "time.end=0.003"];
        // A step that fails, and is taken again in pieces by everyone alone.
        let pieces = ["contact.max_recursions=1", "time.dt=0.002", "removal=[{\"rate\":5}]"];
        let scenes: [(&str, &str, &[&str], usize); 8] = [
            ("channel", &colony, &channel, 3),
            ("radius", &colony, &radius, 2),
            ("pieces", &colony, &pieces, 3),
            ("middle", &colony, &["time.stepping=midpoint"], 2),
            ("suspension", "sedimentation", &suspension, 2),
            ("mail", "chainmail", &mail, 2),
            ("net", &net, &[], 2),
            ("shot", &shot, &[], 2),
        ];
        for (name, scene, set, processes) in scenes {
            let mut arguments = vec![scene, "--set", "output.picture=false"];
            set.iter().for_each(|set| arguments.extend(["--set", set]));
            let summary = same_for_any_number(place.path(), name, &arguments, &[processes]);
            assert!(summary["bodies"].as_u64().unwrap() >= 512, "{name}: too few bodies to share");
        }
    }

    #[test]
    fn any_number_of_processes_takes_up_any_checkpoint() {
        if !has_mpirun("any checkpoint") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        let colony = from_state(place.path(), "colony", "colony-1024.npz", 3);
        by_the_cpu(place.path(), &[&colony, "--out", "whole"]);
        let expected = result(&place.path().join("whole"));
        let halted = by_processes(place.path(), 2, &[&colony, "--out", "run", "--max-wall", "0.01"]);
        assert_eq!(said(&halted).matches("continue with").count(), 1, "{}", said(&halted));
        assert_eq!(summary(&place.path().join("run"))["status"], "interrupted");
        let again = by_processes(place.path(), 3, &["--resume", "--out", "run", "--max-wall", "0.01"]);
        assert!(!said(&again).contains("fault"), "{}", said(&again));
        let last = by_processes(place.path(), 2, &["--resume", "--out", "run"]);
        assert!(last.status.success(), "{}", said(&last));
        assert!(result(&place.path().join("run")) == expected);
    }

    /// The processes that `mpirun` started.
    fn children(of: u32) -> Vec<u32> {
        let list = fs::read_to_string(format!("/proc/{of}/task/{of}/children")).unwrap_or_default();
        list.split_whitespace().filter_map(|id| id.parse().ok()).collect()
    }

    /// Whether a process is there and no zombie, which nobody has asked for its status.
    fn runs(id: u32) -> bool {
        let status = fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        status.rsplit_once(')').is_some_and(|(_, rest)| !rest.trim_start().starts_with('Z'))
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_process_that_dies_ends_the_run_which_goes_on_from_its_checkpoint() {
        if !has_mpirun("a process that dies") {
            return;
        }
        let kills = std::env::var("RELCP_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(2);
        let place = tempfile::tempdir().unwrap();
        // Three processes have domains from the first step on.
        let colony = from_state(place.path(), "colony", "colony-1024.npz", 150);
        let arguments = [&colony, "--set", "output.picture=false"];
        by_the_cpu(place.path(), &[&arguments[..], &["--out", "whole"]].concat());
        let expected = result(&place.path().join("whole"));
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for kill in 0..kills {
            let out = format!("killed-{kill}");
            let folder = place.path().join(&out);
            let mut run = mpirun(place.path(), 3);
            run.args(["run", "--backend", "mpi", "--quiet", "--checkpoint-every", "0.05", "--out", &out]);
            let mut run = run.args(arguments).stderr(Stdio::piped()).spawn().unwrap();
            while !folder.join("checkpoint.npz").exists() {
                assert!(run.try_wait().unwrap().is_none());
                std::thread::sleep(Duration::from_millis(5));
            }
            std::thread::sleep(Duration::from_millis(random.random_range(0..1_000)));
            let processes = children(run.id());
            let victim = processes.get(random.random_range(0..3)).copied();
            if let Some(victim) = victim {
                Command::new("kill").args(["-9", &victim.to_string()]).status().unwrap();
            }
            let ended = run.wait_with_output().unwrap();
            if ended.status.success() {
                // It was over before.
                assert!(result(&folder) == expected, "kill {kill}");
                continue;
            }
            while processes.iter().any(|id| runs(*id)) {
                std::thread::sleep(Duration::from_millis(20));
            }
            assert!(said(&ended).contains("signal 9"), "kill {kill}: {}", said(&ended));
            let again = by_processes(place.path(), 1 + kill % 3, &["--resume", "--out", &out]);
            assert!(again.status.success(), "kill {kill}: {}", said(&again));
            assert!(result(&folder) == expected, "kill {kill}");
        }
    }

    #[test]
    fn bad_input_is_refused_once_and_leaves_nothing() {
        if !has_mpirun("bad input") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("file"), "").unwrap();
        for (arguments, message) in [
            (&["nowhere.json", "--out", "run"][..], "nowhere.json"),
            (&["colony", "--set", "time.dt=-1", "--out", "run"], "time.dt"),
            (&["colony", "--precision", "f32", "--out", "run"], "--precision"),
            (&["colony", "--adapter", "any", "--out", "run"], "--adapter"),
            (&["colony", "--out", "file/run"], "file/run"),
            (&["--resume", "--out", "run"], "run"),
        ] {
            let output = by_processes(place.path(), 3, arguments);
            let said = said(&output);
            assert!(!output.status.success() && said.contains(message), "{arguments:?}: {said}");
            assert_eq!(said.matches("error:").count() + said.matches("× ").count(), 1, "{arguments:?}: {said}");
            assert!(!place.path().join("run").exists(), "{arguments:?}");
        }
    }

    #[test]
    fn processes_of_two_programs_do_not_begin_together() {
        if !has_mpirun("two programs") {
            return;
        }
        let place = tempfile::tempdir().unwrap();
        let other = place.path().join("other");
        fs::copy(cargo_bin("relcp"), &other).unwrap();
        // What follows the end of a program is of no use to it.
        let mut grown = fs::OpenOptions::new().append(true).open(&other).unwrap();
        std::io::Write::write_all(&mut grown, b"0").unwrap();
        drop(grown);
        let run = ["run", "colony", "--backend", "mpi", "--out", "run"];
        let mut command = mpirun(place.path(), 1);
        let output = command.args(run).args([":", "-n", "1"]).arg(&other).args(run).output().unwrap();
        let said = said(&output);
        assert!(!output.status.success() && said.contains("start the same program"), "{said}");
        assert_eq!(said.matches("runs another program").count(), 1, "{said}");
        assert!(!place.path().join("run").exists());
    }
}

#[test]
fn what_is_no_run_of_one_scene_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let relcp = |arguments: &[&str]| -> Output {
        let mut command = Command::new(cargo_bin("relcp"));
        command.current_dir(Path::new(place.path())).args(arguments).stdin(Stdio::null()).output().unwrap()
    };
    for arguments in
        [&["contacts", "three-capsules", "--backend", "mpi"][..], &["render", "three-capsules", "--backend", "mpi"]]
    {
        let output = relcp(arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains("relcp run") || said.contains("--features mpi"), "{arguments:?}: {said}");
    }
    if !cfg!(feature = "mpi") {
        let output = relcp(&["run", "three-capsules", "--backend", "mpi", "--out", "run"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("--features mpi") && !place.path().join("run").exists(), "{said}");
        println!("SKIP runs of several processes: the feature mpi is off");
    }
}
