//! The program from outside: exit statuses, what goes to which stream, files.
#![allow(clippy::unwrap_used)]

mod compute;
mod flags;
mod pages;
mod place;
#[path = "../../../../tests/common/ran.rs"]
mod ran;
mod threads;
#[path = "../../../../tests/common/waiting.rs"]
mod waiting;

use assert_cmd::Command;
use place::Place;
use ran::Ran;
use relcp::Scene;
use serde_json::Value;
use std::fs;

/// The study of the solvers on the LCPs of a run.
#[test]
fn lcps_of_a_run_are_studied() {
    let place = Place::new();
    let sets = ["solver.dump.when=all", "solver.dump.most=3", "contact.rows=paper"];
    place.run(Scene::load("three-capsules", sets).unwrap(), "run");
    let study = ["solvers", "--quick", "--backend", "cpu", "--out", "st"];
    let out = place.lab(&[&study[..], &["run", "run/lcps/step-000001-rec-0.npz", "--json", "--quiet"]].concat());
    let numbers: Value = serde_json::from_str(&out.expect(0).out).unwrap();
    let lcps = numbers["lcps"].as_array().unwrap();
    let names: Vec<&str> = lcps.iter().map(|lcp| lcp["lcp"].as_str().unwrap()).collect();
    let repeated = "step-000001-rec-0-2";
    assert_eq!(names, ["step-000001-rec-0", "step-000001-rec-1", "step-000002-rec-0", repeated]);
    for lcp in lcps {
        for attempt in lcp["attempts"].as_array().unwrap() {
            let solved = attempt["status"] == "solved" && attempt["residual"].as_f64() <= attempt["tolerance"].as_f64();
            assert!(solved || attempt["status"] == "refused", "{attempt}");
        }
    }
    assert_eq!(numbers["runs"].as_array().unwrap().len(), 0);
    assert_eq!(place.json("st/solvers.json"), numbers);
    let page = fs::read_to_string(place.at("st/solvers.md")).unwrap();
    for name in names {
        assert!(page.contains(&format!("### {name} on CPU f64")) && page.contains(&format!("solvers-{name}.svg")));
        assert!(fs::read_to_string(place.at(&format!("st/solvers-{name}.svg"))).unwrap().starts_with("<svg"));
    }
    assert!(fs::read_to_string(place.at("st/solvers.csv")).unwrap().lines().count() > 4 * 30);
    assert!(!place.at("st/solvers-runs.csv").exists());

    fs::write(place.at("cut.npz"), &fs::read(place.at("run/lcps/step-000001-rec-0.npz")).unwrap()[..900]).unwrap();
    fs::create_dir(place.at("empty")).unwrap();
    for (file, status, says) in [
        ("cut.npz", 4, "the end of the file is damaged"),
        ("rods.json", 4, "this is not an LCP (.npz): it is no zip"),
        ("run/checkpoint.npz", 4, "it is a `relcp-state`"),
        ("absent.npz", 4, "could not read it"),
        ("empty", 2, "there is no .npz in it"),
    ] {
        let refused = place.lab(&[&study[..], &[file]].concat()).expect(status);
        assert!(refused.err.contains(says) && refused.err.contains(file), "{}", refused.err);
    }
    // Nothing is measured for tables that have no place.
    let nowhere = place.lab(&["solvers", "run", "--backend", "cpu", "--out", "rods.json/st"]).expect(4);
    assert!(nowhere.err.contains("rods.json/st") && !nowhere.err.contains("rows"), "{}", nowhere.err);
    let refused = place.lab(&["throughput", "cut.npz"]).expect(2);
    assert!(refused.err.contains("relcp-lab solvers"), "{}", refused.err);
}

/// The paper's own tests, at their quick size.
#[test]
fn the_papers_tests_are_studied() {
    let place = Place::new();
    let study = |name: &str| -> Value {
        let out = place.lab(&[name, "--quick", "--backend", "cpu", "--out", "st", "--json", "--quiet"]).expect(0);
        assert_eq!(out.err, "");
        let numbers: Value = serde_json::from_str(&out.out).unwrap();
        assert_eq!(place.json(&format!("st/{name}.json")), numbers);
        numbers
    };
    let numbers = study("two-ellipsoids");
    let rows = numbers["rows"].as_array().unwrap();
    let errors_to = |side: &str, scheme: &str| -> Vec<f64> {
        let of = rows.iter().filter(|row| row["side"] == side && row["scheme"] == scheme);
        of.map(|row| row["worst"].as_f64().unwrap()).collect()
    };
    let errors = |scheme: &str| errors_to("right", scheme);
    let (euler, midpoint) = (errors("euler"), errors("midpoint"));
    let left = errors_to("left", "euler");
    assert!(left.windows(2).all(|pair| (8.0..12.0).contains(&(pair[0] / pair[1]))), "{left:?}");
    let spheres = errors_to("left", "multisphere");
    assert!(spheres[0] > spheres[1] && spheres[1] > left[2] && errors_to("left", "midpoint").is_empty(), "{spheres:?}");
    assert_eq!((euler.len(), midpoint.len(), errors("multisphere").len()), (3, 6, 2));
    assert!((8.0..12.0).contains(&(euler[1] / euler[2])), "{euler:?}");
    assert!(midpoint.windows(2).all(|pair| pair[0] / pair[1] >= 2f64.powf(1.8)), "{midpoint:?}");
    assert!(errors("multisphere").iter().all(|error| *error > euler[2]));
    for reference in numbers["references"].as_array().unwrap() {
        let apart = reference["difference"].as_array().unwrap();
        assert!(apart.iter().all(|d| d.as_f64().unwrap() < midpoint[5]), "{apart:?}");
    }
    let page = fs::read_to_string(place.at("st/two-ellipsoids.md")).unwrap();
    for part in ["| 1e-2 |", "0.0256, 0.0243, 0.0041", "two-ellipsoids-work.svg", "two-ellipsoids-paths.svg"] {
        assert!(page.contains(part), "{part}: {page}");
    }

    let numbers = study("jitter");
    let runs = numbers["runs"].as_array().unwrap();
    for run in runs {
        let over = run["steps_over"].as_u64().unwrap();
        assert_eq!(over > 0, run["case"]["method"] == "snsd", "{run}");
    }
    assert!(numbers["targets"].as_array().unwrap().iter().all(|target| target["met"] == true), "{numbers}");
    assert!(fs::read_to_string(place.at("st/jitter.md")).unwrap().contains("![](jitter.svg)"));
    for (name, lines) in [("jitter.csv", runs.len()), ("jitter-steps.csv", 500), ("two-ellipsoids.csv", rows.len())] {
        assert!(fs::read_to_string(place.at(&format!("st/{name}"))).unwrap().lines().count() > lines, "{name}");
    }
    for name in ["jitter.svg", "two-ellipsoids-work.svg", "two-ellipsoids-paths.svg"] {
        assert!(fs::read_to_string(place.at(&format!("st/{name}"))).unwrap().starts_with("<svg"), "{name}");
    }

    for (arguments, status, says) in [
        (["--backend", "gpu"], 2, "computed on the CPU"),
        (["--backend", "mpi"], 2, "--backend"),
        (["--precision", "f32"], 2, "the CPU computes in f64"),
        (["--adapter", "any"], 2, "--adapter names a device"),
        (["--out", "rods.json/st"], 4, "rods.json/st"),
        (["rods.json", "--quick"], 2, "relcp-lab solvers"),
    ] {
        let refused = place.lab(&[&["jitter"], &arguments[..]].concat()).expect(status);
        assert!(refused.err.contains(says) && refused.out.is_empty(), "{}", refused.err);
    }
}

/// Work against precision, at its quick size, and what is refused of it.
#[test]
fn work_and_precision_are_studied() {
    let place = Place::new();
    let study = ["work-precision", "--quick", "--backend", "cpu", "--out", "st", "--json", "--quiet"];
    let out = place.lab(&study).expect(0);
    assert_eq!(out.err, "");
    let numbers: Value = serde_json::from_str(&out.out).unwrap();
    assert_eq!(place.json("st/work-precision.json"), numbers);
    let (rows, problems) = (numbers["rows"].as_array().unwrap(), numbers["problems"].as_array().unwrap());
    assert!(problems.len() == 5 && rows.iter().all(|row| row["error"].as_f64().is_some_and(f64::is_finite)));
    let page = fs::read_to_string(place.at("st/work-precision.md")).unwrap();
    for problem in problems {
        let name = problem["problem"].as_str().unwrap();
        let errors = |curve: &str| -> Vec<f64> {
            let on = rows.iter().filter(|row| row["problem"] == name && row["curve"] == curve);
            on.map(|row| row["error"].as_f64().unwrap()).collect()
        };
        let (euler, midpoint) = (errors("ReLCP"), errors("ReLCP, midpoint"));
        assert_eq!((euler.len(), midpoint.len()), (4, 4), "{name}");
        assert!(euler[3] < euler[0] && midpoint[3] < midpoint[0], "{name}: {euler:?} {midpoint:?}");
        let plot = format!("work-precision-{name}.svg");
        assert!(page.contains(&format!("![]({plot})")) && page.contains(&format!("\n## {name}\n")), "{page}");
        assert!(fs::read_to_string(place.at(&format!("st/{plot}"))).unwrap().starts_with("<svg"));
    }
    assert_eq!(fs::read_to_string(place.at("st/work-precision.csv")).unwrap().lines().count(), 1 + rows.len());
    for (arguments, status, says) in [
        (["jitter", "--make-references", "refs"], 2, "relcp-lab work-precision"),
        (["work-precision", "--make-references", "rods.json/refs"], 4, "rods.json/refs"),
        (["work-precision", "--out", "rods.json/st"], 4, "rods.json/st"),
    ] {
        let refused = place.lab(&arguments).expect(status);
        assert!(refused.err.contains(says) && refused.out.is_empty(), "{}", refused.err);
    }
}

/// Scenes that a seed draws: one that is stopped is there as a scene that stops again.
#[test]
fn drawn_scenes_are_studied_and_those_that_stop_can_be_run_again() {
    let place = Place::new();
    let study = ["hard", "--random", "12", "--confined", "2", "--seed", "2", "--quick"];
    let ways = ["--backend", "cpu", "--out", "st", "--json", "--quiet"];
    let out = place.lab(&[&study[..], &ways[..]].concat()).expect(0);
    let numbers: Value = serde_json::from_str(&out.out).unwrap();
    assert_eq!(place.json("st/drawn.json"), numbers);
    let rows = numbers["rows"].as_array().unwrap();
    assert_eq!((rows.len(), rows[13]["name"].as_str()), (14, Some("confined-2-1")));
    assert_eq!(fs::read_to_string(place.at("st/drawn.csv")).unwrap().lines().count(), 1 + rows.len());
    assert!(fs::read_to_string(place.at("st/drawn.md")).unwrap().contains("12 scenes, "));
    for row in rows.iter().filter(|row| row["verdict"] != "holds") {
        let scene = format!("st/failures/{}.json", row["name"].as_str().unwrap());
        Scene::load(place.at(&scene), [] as [&str; 0]).unwrap();
    }
    let refused = place.lab(&["jitter", "--random", "3"]).expect(2);
    assert!(refused.err.contains("relcp-lab hard"), "{}", refused.err);
}

#[test]
fn throughput_is_measured_of_what_is_asked_for() {
    let place = Place::new();
    let study = ["throughput", "--of", "colony", "--smallest", "1024", "--largest", "2000", "--steps", "1"];
    let ran = place.lab(&[&study[..], &["--warm-up", "0", "--backend", "cpu", "--json"]].concat());
    assert!(matches!(ran.status, Some(0 | 3)), "{ran:?}");
    let rows: Value = serde_json::from_str(&ran.out).unwrap();
    let [row] = &rows.as_array().unwrap()[..] else { panic!("{rows}") };
    assert_eq!((&row["kind"], &row["bodies"], &row["steps"]), (&"colony".into(), &1024.into(), &1.into()));
    assert!(row["constraints"].as_u64().unwrap() > 1024 && row["products"].as_f64().unwrap() > 1.0, "{row}");
    assert_eq!(place.json("studies/throughput.json"), rows);
    let page = fs::read_to_string(place.at("studies/throughput.md")).unwrap();
    assert!(page.contains("1 steps timed after 0") && page.contains("| Colony | 1024 |"), "{page}");
}

/// As of `relcp`: the log that `RELCP_LOG` asks for, drivers that write nothing, errors in a frame with their causes.
#[test]
fn the_log_and_errors_are_those_of_relcp() {
    let place = Place::new();
    let mut program = Command::cargo_bin("relcp-lab").unwrap();
    program.current_dir(&place.0).env_remove("XDG_RUNTIME_DIR").env("RELCP_LOG", "relcp=trace");
    let small = ["--of", "colony", "--largest", "1024", "--steps", "1", "--warm-up", "0", "--quiet", "--out", "st"];
    let logged = Ran::of(program.args(["throughput", "--backend", "cpu"]).args(small));
    assert!(logged.err.lines().any(|line| line.contains("TRACE relcp")), "{}", logged.err);
    assert!(!logged.err.contains("XDG_RUNTIME_DIR"), "{}", logged.err);
    let refused = place.lab(&["solvers", "absent.npz", "--backend", "cpu"]).expect(4).err;
    let lines: Vec<&str> = refused.lines().collect();
    assert!(lines.len() > 1 && lines[0].contains("absent.npz") && lines[1].contains("No such file"), "{refused}");
}
