//! The program from outside: exit statuses, what goes to which stream, files, interruption.
#![allow(clippy::unwrap_used)]

mod browser;
mod completions;
mod first_use;
mod flags;
mod found_by_use;
mod live;
mod pages;
mod place;
#[path = "../common/ran.rs"]
mod ran;
mod resume;
mod tutorials;
#[path = "../common/waiting.rs"]
mod waiting;

use assert_cmd::Command;
use place::Place;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

fn rows(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("steps.csv")).unwrap();
    text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
}

#[test]
#[cfg(unix)]
fn drivers_are_silent_without_a_runtime_folder() {
    let place = Place::new();
    for arguments in [&["devices"][..], &["run", "rods.json", "--quiet", "--out", "run"]] {
        let mut command = Command::cargo_bin("relcp").unwrap();
        let output = command.current_dir(&place.0).env_remove("XDG_RUNTIME_DIR").args(arguments).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        // Without an adapter `devices` ends with a message of its own.
        let none = output.status.code() == Some(5) && arguments == ["devices"];
        assert!((output.status.success() && err.is_empty()) || (none && !err.contains("XDG")), "{arguments:?}: {err}");
    }
}

#[test]
fn help_and_version() {
    let place = Place::new();
    let help = place.relcp(&["run", "--help"]).expect(0).out;
    assert!(help.contains("Examples:") && help.contains("--resume") && help.contains("gpu"), "{help}");
    assert!(place.relcp(&["--version"]).expect(0).out.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn what_goes_on_is_told_by_level() {
    let place = Place::new();
    let lines = |arguments: &[&str], level: &str| {
        let ran = place.relcp(arguments).expect(0);
        ran.err.lines().filter(|line| line.split_whitespace().nth(1) == Some(level)).count()
    };
    let counts = |log: &[&str]| {
        let out = format!("out{}", log.join("").replace('=', ""));
        let run = [&["run", "rods.json", "--quiet", "--backend", "cpu", "--out", &out], log].concat();
        ["INFO", "DEBUG", "TRACE"].map(|level| {
            let _ = fs::remove_dir_all(place.at(&out));
            lines(&run, level)
        })
    };
    assert_eq!(counts(&[]), [0, 0, 0]);
    assert_eq!(counts(&["--log", "warn"]), [0, 0, 0]);
    let [states, steps, solves] = counts(&["--log=trace"]);
    assert!(states >= 3 && steps == 60 && solves >= 60, "{states} {steps} {solves}");
    assert_eq!(counts(&["--log", "info"]), [states, 0, 0]);
    assert_eq!(counts(&["--log", "debug"]), [states, 60, 0]);
    place.relcp(&["scenes", "--log", "loud"]).expect(2);
}

#[test]
fn bad_arguments_are_status_2_and_write_nothing() {
    let place = Place::new();
    for arguments in [
        &["run"] as &[&str],
        &["walk"],
        &["run", "rods.json", "--threads", "0"],
        &["run", "rods.json", "--backend", "cpu", "--precision", "f32"],
        &["run", "rods.json", "--backend", "cpu", "--adapter", "x"],
        &["run", "rods.json", "--backend", "tpu"],
        &["run", "--resume"],
        &["run", "rods.json", "--set", "time.dtt=1"],
        &["run", "rods.json", "--set", "time.dt=-1"],
        &["contacts", "rods.json", "--cutoff", "inf"],
        &["scenes", "no-such-scene"],
    ] {
        let ran = place.relcp(arguments).expect(2);
        assert!(ran.out.is_empty() && !ran.err.is_empty(), "{arguments:?}: {ran:?}");
    }
    assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 1);
}

#[test]
fn a_bad_scene_is_status_2_with_its_place() {
    let place = Place::new();
    fs::write(place.at("bad.json"), "{\n  \"name\": \"x\",\n  \"tme\": {}\n}\n").unwrap();
    for command in ["run", "check", "contacts"] {
        let ran = place.relcp(&[command, "bad.json"]).expect(2);
        assert!(ran.err.contains("bad.json:3:3") && ran.err.contains("tme"), "{}", ran.err);
    }
    assert!(!place.at("runs").exists());
}

#[test]
fn files_that_cannot_be_read_or_written_are_status_4() {
    let place = Place::new();
    for command in ["run", "check", "contacts"] {
        assert!(place.relcp(&[command, "absent.json"]).expect(4).err.contains("absent.json"));
    }
    assert!(place.relcp(&["contacts", "absent.npz"]).expect(4).err.contains("absent.npz"));
    let under_a_file = place.relcp(&["run", "rods.json", "--out", "rods.json/run"]).expect(4);
    assert!(under_a_file.err.contains("rods.json/run"), "{}", under_a_file.err);
    place.relcp(&["run", "rods.json", "--out", "rods.json"]).expect(4);
    fs::create_dir(place.at("empty")).unwrap();
    let nothing = place.relcp(&["run", "rods.json", "--resume", "--out", "empty"]).expect(4);
    assert!(nothing.err.contains("no checkpoint"), "{}", nothing.err);
    place.relcp(&["run", "rods.json", "--resume"]).expect(4);
}

#[test]
fn an_adapter_that_is_not_there_is_status_5() {
    let place = Place::new();
    let ran = place.relcp(&["run", "rods.json", "--backend", "gpu", "--adapter", "no such adapter"]).expect(5);
    assert!(ran.err.contains("no usable adapter named no such adapter"), "{}", ran.err);
    assert!(ran.err.contains("help: use --backend cpu"), "{}", ran.err);
    assert!(!place.at("runs").exists());
    place.relcp(&["devices", "--adapter", "no such adapter"]).expect(5);
}

#[test]
fn a_folder_with_something_in_it_is_refused_and_left_alone() {
    let place = Place::new();
    fs::create_dir(place.at("mine")).unwrap();
    fs::write(place.at("mine/notes.txt"), "mine").unwrap();
    let ran = place.relcp(&["run", "rods.json", "--out", "mine"]).expect(2);
    assert!(ran.err.contains("--out") && ran.err.contains("--resume"), "{}", ran.err);
    assert_eq!(fs::read_dir(place.at("mine")).unwrap().count(), 1);
}

#[test]
fn scenes_schema_and_check() {
    let place = Place::new();
    let list: Value = serde_json::from_str(&place.relcp(&["scenes", "--json"]).expect(0).out).unwrap();
    let lines = place.relcp(&["scenes"]).expect(0).out;
    assert_eq!(lines.lines().count(), list["scenes"].as_array().unwrap().len());
    let name = list["scenes"][0]["name"].as_str().unwrap();
    let text = place.relcp(&["scenes", name]).expect(0).out;
    fs::write(place.at("printed.json"), text).unwrap();
    let checked: Value =
        serde_json::from_str(&place.relcp(&["check", "printed.json", "--json"]).expect(0).out).unwrap();
    assert_eq!(checked["valid"], true);
    let rods = place.relcp(&["check", "rods.json", "--set", "time.end=2.4"]).expect(0).out;
    assert!(rods.contains("2 bodies") && rods.contains("120 steps"), "{rods}");
    let schema: Value = serde_json::from_str(&place.relcp(&["schema"]).expect(0).out).unwrap();
    assert!(schema["properties"]["bodies"].is_object(), "{schema}");
}

#[test]
fn a_run_leaves_its_folder() {
    let place = Place::new();
    let ran = place.relcp(&["run", "rods.json", "--json"]).expect(0);
    let summary: Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(summary["folder"], "runs/rods");
    for key in ["name", "method", "stepping", "backend", "adapter", "precision", "version", "bodies", "steps", "time"]
        .into_iter()
        .chain(["dt", "seed", "completed", "max_overlap", "final_max_overlap", "steps_over_tolerance", "recursions"])
        .chain(["constraints", "solver", "wall_seconds", "peak_bytes"])
    {
        assert!(summary.get(key).is_some(), "{key}: {summary}");
    }
    assert_eq!((&summary["steps"], &summary["completed"]), (&60.into(), &true.into()));
    assert!(summary["final_max_overlap"].as_f64().unwrap() <= 1e-5);
    assert_eq!(place.json("runs/rods/summary.json")["state_hash"], summary["state_hash"]);
    let rows = fs::read_to_string(place.at("runs/rods/steps.csv")).unwrap();
    let columns = "step,time,bodies,constraints,recursions,iterations,products,residual,first_violation,max_overlap,pieces,largest_move,largest_push_gap,contact_energy,axial_spin,broken_bonds,sliding,sticking,friction_work,wall_seconds";
    assert_eq!((rows.lines().next(), rows.lines().count()), (Some(columns), 61));
    assert_eq!(fs::read_dir(place.at("runs/rods/states")).unwrap().count(), 13);
    assert_eq!(place.json("runs/rods/scene.json")["contact"]["max_recursions"], 64);
    assert_eq!(place.relcp(&["run", "rods.json", "--quiet"]).expect(0).out, "");
    assert!(place.at("runs/rods-2/final.json").exists());
    let picture = fs::read(place.at("runs/rods/final.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n") && picture.len() > 1_000, "{} bytes", picture.len());
    assert!(picture == fs::read(place.at("runs/rods-2/final.png")).unwrap());
}

#[test]
fn without_a_backend_a_run_is_computed_on_the_cpu_whatever_devices_there_are() {
    let place = Place::new();
    let [auto, cpu] = ["auto", "cpu"].map(|backend| {
        let ran = place.relcp(&["run", "rods.json", "--json", "--backend", backend, "--out", backend]).expect(0);
        assert!(!ran.err.contains("--backend gpu"), "few bodies are not worth a device: {}", ran.err);
        serde_json::from_str::<Value>(&ran.out).unwrap()
    });
    assert_eq!(auto["state_hash"], cpu["state_hash"]);
    let leg = serde_json::json!([{ "machine": "cpu", "adapter": null, "precision": "f64", "from_step": 1, "time": 0.0,
        "bodies": 2 }]);
    assert_eq!((&auto["legs"], &cpu["legs"]), (&leg, &leg));
}

#[test]
fn a_picture_that_cannot_be_written_is_status_4() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--out", "run", "--quiet"]).expect(0);
    fs::remove_file(place.at("run/final.png")).unwrap();
    fs::create_dir(place.at("run/final.png")).unwrap();
    let ran = place.relcp(&["run", "--resume", "--out", "run", "--quiet"]).expect(4);
    assert!(ran.err.contains("run/final.png"), "{}", ran.err);
}

#[test]
fn threads_do_not_change_a_bit() {
    let place = Place::new();
    let hash = |threads: &str| {
        place.relcp(&["run", "rods.json", "--out", threads, "--threads", threads, "--quiet"]).expect(0);
        place.json(&format!("{threads}/summary.json"))["state_hash"].clone()
    };
    assert_eq!(hash("1"), hash("3"));
}

#[test]
fn contacts_of_a_scene_of_a_final_state_and_of_a_state() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--out", "run", "--quiet"]).expect(0);
    let contacts = |state: &str| -> Value {
        let out = place.relcp(&["contacts", state, "--cutoff", "1", "--json"]).expect(0).out;
        serde_json::from_str(&out).unwrap()
    };
    let (last, state) = (contacts("run/final.json"), contacts("run/states/state_0000000060.npz"));
    assert_eq!(last, state);
    assert_eq!(last, contacts("run"));
    assert!(place.relcp(&["contacts", "."]).expect(4).err.contains("checkpoint.npz"));
    assert_eq!(last["max_overlap"], place.json("run/summary.json")["final_max_overlap"]);
    let pair = &last["contacts"][0];
    assert_eq!((&pair["a"], &pair["b"]), (&0.into(), &1.into()));
    for key in ["normal", "point_a", "point_b"] {
        assert_eq!(pair[key].as_array().unwrap().len(), 3);
    }
    // The start: crossed rods of diameter 1 whose axes are 1.2 apart.
    let start = contacts("rods.json");
    assert!((start["contacts"][0]["separation"].as_f64().unwrap() - 0.2).abs() < 1e-12, "{start}");
    assert_eq!(start["max_overlap"].as_f64(), Some(0.0));
    let none: Value = serde_json::from_str(&place.relcp(&["contacts", "rods.json", "--json"]).expect(0).out).unwrap();
    assert_eq!(none["contacts"].as_array().unwrap().len(), 0);
}

/// Five spheres in a row that overlap by a tenth and are pressed together: one iteration cannot solve four coupled
/// rows, and without recursion the overlaps stay.
const PRESSED: &str = r#"{
  "name": "pressed", "time": { "dt": 0.01, "end": 0.2 },
  "contact": { "method": "snsd" }, "solver": { "kind": "projected_jacobi", "max_iterations": 1 },
  "forces": [ { "uniform": { "force": [1, 0, 0], "group": "left" } },
              { "uniform": { "force": [-3, 0, 0], "group": "right" } } ],
  "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0], "group": "left" },
              { "shape": { "sphere": { "radius": 1 } }, "position": [1.9, 0, 0] },
              { "shape": { "sphere": { "radius": 1 } }, "position": [3.8, 0, 0] },
              { "shape": { "sphere": { "radius": 1 } }, "position": [5.7, 0, 0] },
              { "shape": { "sphere": { "radius": 1 } }, "position": [7.6, 0, 0], "group": "right" } ]
}"#;

#[test]
fn steps_out_of_tolerance_are_status_3_and_named() {
    let place = Place::new();
    fs::write(place.at("pressed.json"), PRESSED).unwrap();
    let ran = place.relcp(&["run", "pressed.json", "--out", "run"]).expect(3);
    assert!(ran.out.contains("more overlap than allowed: 1 ("), "{}", ran.out);
    assert!(ran.out.contains("unconverged solves, in steps 1 ("), "{}", ran.out);
    let summary = place.json("run/summary.json");
    assert_eq!((&summary["status"], &summary["completed"]), (&"out_of_tolerance".into(), &true.into()));
    assert_eq!(summary["first_over_tolerance"][0]["step"], 1);
    assert!((summary["start_max_overlap"].as_f64().unwrap() - 0.1).abs() < 1e-12, "{summary}");
    assert!(summary["max_overlap"].as_f64().unwrap() > 1e-5 && summary["solver"]["unconverged"].as_u64().unwrap() > 0);
}

#[test]
fn bodies_that_went_through_each_other_are_status_3_and_named() {
    let place = Place::new();
    fs::write(place.at("torn.json"), include_str!("../data/torn-chain.json")).unwrap();
    // Torn so fast that a 64th of the step is too long as well.
    let fast = ["--set", "contact.on_failure=continue", "--set", "time.dt=20", "--set", "time.end=100"];
    let ran = place.relcp(&[&["run", "torn.json", "--backend", "cpu", "--out", "run"], &fast[..]].concat()).expect(3);
    assert!(
        ran.out.trim_end().lines().last().unwrap().contains("out of tolerance: bodies went through"),
        "{}",
        ran.out
    );
    let quiet = place.relcp(&[&["run", "torn.json", "--quiet", "--backend", "cpu"], &fast[..]].concat()).expect(3);
    assert!(quiet.out.is_empty() && quiet.err.contains("out of tolerance: bodies went through"), "{}", quiet.err);
    let summary = place.json("run/summary.json");
    let [a, b] = [0, 1].map(|k| summary["first_passed"][0]["pair"][k].as_u64().unwrap());
    assert!(
        ran.out.contains("went through each other in") && ran.out.contains(&format!("1 (bodies {a} and {b}")),
        "{}",
        ran.out
    );
    assert_eq!((&summary["status"], &summary["steps_over_tolerance"]), (&"out_of_tolerance".into(), &0.into()));
    assert!(summary["steps_passed"].as_u64().unwrap() > 0 && summary["first_passed"][0]["step"] == 1, "{summary}");
}

#[test]
fn solves_that_fall_back_are_counted() {
    let place = Place::new();
    fs::write(place.at("pressed.json"), PRESSED).unwrap();
    let run = |kind: &str, status: i32| {
        let set = format!("solver.kind={kind}");
        let ran =
            place.relcp(&["run", "pressed.json", "--backend", "cpu", "--set", &set, "--out", kind]).expect(status);
        (ran.out, place.json(&format!("{kind}/summary.json"))["solver"].clone())
    };
    let (out, solver) = run("auto", 0);
    let fallbacks = solver["fallbacks"].as_u64().unwrap();
    assert!(fallbacks > 0 && solver["unconverged"] == 0, "{solver}");
    assert!(out.contains(&format!("{fallbacks} solves used the interior-point safeguard")), "{out}");
    let (out, solver) = run("pair_block_cg", 3);
    assert!(solver["fallbacks"] == 0 && solver["unconverged"].as_u64().unwrap() > 0, "{solver}");
    assert!(!out.contains("interior-point"), "{out}");
}

#[test]
fn a_resumed_run_must_be_of_the_same_scene() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--out", "run", "--quiet"]).expect(0);
    let ran = place.relcp(&["run", "rods.json", "--resume", "--out", "run", "--set", "seed=7"]).expect(2);
    assert!(ran.err.contains("seed"), "{}", ran.err);
    let before = place.json("run/summary.json")["state_hash"].clone();
    place.relcp(&["run", "--resume", "--out", "run", "--quiet"]).expect(0);
    assert_eq!(place.json("run/summary.json")["state_hash"], before);
}

#[test]
fn a_run_that_its_scene_stops_is_done() {
    let place = Place::new();
    let sets = ["--set", "time.dt=0.02", "--set", "growth.stop.population=4", "--backend", "cpu", "--out", "run"];
    let ran = place.relcp(&[&["run", "colony"], &sets[..]].concat()).expect(0);
    assert!(ran.out.contains("stopped by growth.stop.population"), "{}", ran.out);
    let summary = place.json("run/summary.json");
    assert_eq!((&summary["status"], &summary["completed"]), (&"done".into(), &true.into()));
    assert_eq!((&summary["stopped_by"], &summary["bodies"]), (&"population".into(), &4.into()));
    let steps = summary["steps"].as_u64().unwrap();
    assert!(steps < 100 && place.at(&format!("run/states/state_{steps:010}.npz")).is_file());
    let again = place.relcp(&["run", "--resume", "--out", "run", "--json"]).expect(0).out;
    assert_eq!(serde_json::from_str::<Value>(&again).unwrap()["steps"], steps);
    assert_eq!(place.json("run/scene.json")["growth"]["stop"]["population"], 4);
    place.relcp(&["run", "rods.json", "--out", "other", "--quiet"]).expect(0);
    assert_eq!(place.json("other/summary.json")["stopped_by"], Value::Null);
}

#[test]
fn a_closed_pipe_is_no_fault() {
    let place = Place::new();
    for arguments in [&["schema"] as &[&str], &["run", "rods.json", "--json"]] {
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("relcp"))
            .current_dir(&place.0)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
    }
}

/// A file-size limit stands in for a full disk: writing fails in the middle.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_is_status_4_with_the_path() {
    let place = Place::new();
    let program = assert_cmd::cargo::cargo_bin("relcp");
    let script = "trap '' XFSZ; ulimit -f 2; exec \"$0\" run rods.json --out run --quiet";
    let ran =
        std::process::Command::new("sh").current_dir(&place.0).args(["-c", script]).arg(program).output().unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(4), "{err}");
    assert!(err.contains("run/"), "{err}");
    assert!(!place.at("run/summary.json").exists() && !place.at("run/final.json").exists());
}

/// Interrupts a long run, resumes it, and compares it with one that was left alone.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_to_the_same_bits() {
    const LONG: [&str; 6] = ["run", "rods.json", "--quiet", "--set", "time.dt=0.0001", "--out"];
    let place = Place::new();
    place.relcp(&[&LONG[..], &["whole"]].concat()).expect(0);
    let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("relcp"))
        .current_dir(&place.0)
        .args(LONG)
        .arg("broken")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !place.at("broken/states/state_0000001000.npz").exists() {
        assert!(begun.elapsed() < Duration::from_secs(600), "the run does not get on");
        std::thread::sleep(Duration::from_millis(1));
    }
    place::signal(&child, "-INT");
    let ended = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{err}");
    assert!(err.contains("relcp run --resume --out broken"), "{err}");
    let stopped = place.json("broken/summary.json");
    assert_eq!((&stopped["completed"], &stopped["status"]), (&false.into(), &"interrupted".into()));
    assert!(stopped["steps"].as_u64().unwrap() < 12_000 && !place.at("broken/final.json").exists());
    assert!(place.at("broken/final.png").exists());
    place.relcp(&["run", "--resume", "--quiet", "--out", "broken"]).expect(0);
    let (whole, broken) = (place.json("whole/summary.json"), place.json("broken/summary.json"));
    for key in ["state_hash", "steps", "max_overlap", "solver", "recursions", "constraints", "scene_hash"] {
        assert_eq!(broken[key], whole[key], "{key}");
    }
    assert_eq!(rows(&place.at("broken")), rows(&place.at("whole")));
    assert_eq!(fs::read(place.at("broken/final.json")).unwrap(), fs::read(place.at("whole/final.json")).unwrap());
}

/// The LCPs of a run, as its scene asks for them.
#[test]
fn lcps_of_a_run_are_saved() {
    let place = Place::new();
    let run = ["run", "three-capsules", "--backend", "cpu", "--quiet", "--out", "run", "--set", "contact.rows=paper"];
    let dump = ["--set", "solver.dump.when=all", "--set", "solver.dump.most=3"];
    place.relcp(&[&run[..], &dump[..]].concat()).expect(0);
    for name in ["step-000001-rec-0", "step-000001-rec-1", "step-000002-rec-0"] {
        let (lcp, header) = relcp::record::read_lcp(&place.at(&format!("run/lcps/{name}.npz"))).unwrap();
        assert!(
            lcp.residual(&lcp.gamma) <= 1.001e-6 && header.is_some_and(|header| header.status == "solved"),
            "{name}"
        );
    }
    assert_eq!(fs::read_dir(place.at("run/lcps")).unwrap().count(), 3);
}

/// The studies are a program of another crate: who asks for one learns where it is.
#[test]
fn the_command_study_says_where_the_studies_are() {
    let place = Place::new();
    for arguments in [&["study"][..], &["study", "hard", "--quick"], &["--log", "info", "study", "all"]] {
        let refused = place.relcp(arguments).expect(2);
        let says = refused.err.contains("cargo run --release -p relcp-lab -- NAME");
        assert!(says && refused.out.is_empty(), "{refused:?}");
    }
}
