//! What a new user trips over: names, hints, numbers, warnings. Each test is named by its symptom.

use super::place::Place;
use serde_json::{Value, json};
use std::fs;

/// Help is wrapped at this width by a terminal that tells nothing.
const WIDTH: usize = 80;

fn ball(more: &Value) -> Value {
    let mut scene = json!({"name": "ball", "time": {"dt": 0.1, "end": 1}, "output": {"picture": false},
        "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}]});
    scene.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    scene
}

/// The words of a message, whatever lines they stand on.
fn words(text: &str) -> String {
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

#[test]
fn a_misspelt_scene_has_one_status_whatever_the_command_and_the_nearest_name() {
    let place = Place::new();
    for command in ["run", "check", "scenes", "contacts", "view", "measure", "render"] {
        let err = words(&place.relcp(&[command, "colny"]).expect(2).err);
        assert!(err.contains("`colny`") && err.contains("`colony`"), "{command}: {err}");
    }
    fs::write(place.at("sweep.json"), r#"{"name": "s", "scene": "colny", "seeds": [1]}"#).unwrap();
    place.relcp(&["batch", "sweep.json"]).expect(2);
    // What has an ending or is in a folder is a file.
    for name in ["colny.json", "here/colny"] {
        place.relcp(&["run", name]).expect(4);
    }
    assert!(words(&place.relcp(&["run", "colny.json"]).expect(4).err).contains("`colony`"));
    assert!(words(&place.relcp(&["run", "qwertz"]).expect(2).err).contains("`relcp scenes` lists"));
}

#[test]
fn a_misspelt_command_has_the_nearest() {
    let place = Place::new();
    for (typed, meant) in [("rnu", "'run'"), ("bathc", "'batch'"), ("mesure", "'measure'"), ("chekc", "'check'")] {
        let err = place.relcp(&[typed, "colony"]).expect(2).err;
        assert!(err.contains(meant), "{err}");
    }
    assert!(place.relcp(&["man", "rnu"]).expect(2).err.contains("`run`"));
    assert!(!place.relcp(&["qwertz"]).expect(2).err.contains("similar"));
}

#[test]
fn the_backend_cuda_is_the_gpu_not_the_cpu() {
    let place = Place::new();
    for (command, name) in [("run", "cuda"), ("batch", "vulkan"), ("render", "Metal"), ("contacts", "opencl")] {
        let err = place.relcp(&[command, "rods.json", "--backend", name]).expect(2).err;
        assert!(err.contains("'gpu'") && !err.contains("exists: 'cpu'"), "{err}");
    }
    let help = place.relcp(&["run", "--help"]).expect(0).out;
    assert!(
        words(&help).contains("[possible values: auto, cpu, gpu, mpi]") || words(&help).contains("- mpi"),
        "{help}"
    );
}

#[test]
fn words_of_other_programs_have_a_hint() {
    let place = Place::new();
    let shape = |name: &str| json!({"bodies": [{"shape": {name: {"radius": 1}}, "position": [0, 0, 0]}]});
    for (scene, says) in [
        (ball(&shape("rod")), "`spherocylinder`"),
        (ball(&shape("capsule")), "`spherocylinder`"),
        (ball(&shape("ring")), "`torus`"),
        (ball(&json!({"friction": 0.3})), "contact.friction"),
        (ball(&json!({"contact": {"mu": 0.3}})), "`friction`"),
        (ball(&json!({"gravity": [0, 0, -9.81]})), "acceleration"),
        (ball(&json!({"timestep": 0.1})), "time.dt"),
        (ball(&json!({"walls": [{"floor": {}}]})), "`half_space`"),
    ] {
        fs::write(place.at("hint.json"), scene.to_string()).unwrap();
        let err = words(&place.relcp(&["check", "hint.json"]).expect(2).err);
        assert!(err.contains(says) && !err.contains("nearest"), "{err}");
    }
}

#[test]
fn numbers_have_no_noise_and_as_many_digits_as_their_bound_needs() {
    let place = Place::new();
    let out = place.relcp(&["run", "rods.json", "--set", "time.dt=0.008", "--set", "time.end=0.504"]).expect(0).out;
    assert!(out.starts_with("rods: 63 steps to time 0.504 with 2 bodies\n"), "{out}");
    assert!(out.contains(" at most of 1e-5 allowed, "), "{out}");
    assert!(!out.contains("e0") && !out.contains("00000"), "{out}");
    let err = place.relcp(&["run", "rods.json", "--set", "time.dt=-1"]).expect(2).err;
    assert!(words(&err).ends_with("must be positive, not -1"), "{err}");
}

#[test]
fn the_end_of_a_run_says_how_to_look_at_it() {
    let place = Place::new();
    let out = place.relcp(&["run", "rods.json"]).expect(0).out;
    assert!(out.contains("relcp view runs/rods --open"), "{out}");
    let out = place.relcp(&["run", "rods.json", "--view", "--out", "two words"]).expect(0).out;
    assert!(out.contains("two words/view.html") && !out.contains("--open"), "{out}");
    let out = place.relcp(&["run", "rods.json", "--out", "its run"]).expect(0).out;
    assert!(out.contains("relcp view 'its run' --open"), "{out}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_browser_that_is_not_there_is_said() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--out", "run"]).expect(0);
    fs::create_dir(place.at("bin")).unwrap();
    let opener = place.at("bin/xdg-open");
    let view = |script: Option<&str>| {
        if let Some(script) = script {
            fs::write(&opener, format!("#!/bin/sh\n{script}\n")).unwrap();
            fs::set_permissions(&opener, fs::Permissions::from_mode(0o755)).unwrap();
        }
        let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
        command.current_dir(&place.0).env("PATH", place.at("bin")).args(["view", "run", "--open"]);
        let output = command.output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    for script in [None, Some("exit 3")] {
        let err = view(script);
        assert!(err.contains("could not open a browser") && err.contains("run/view.html"), "{script:?}: {err}");
    }
    assert_eq!(view(Some("exit 0")), "");
}

#[test]
fn an_overlap_tolerance_of_most_of_a_thickness_is_warned_of() {
    let place = Place::new();
    let small = json!({"bodies": [{"shape": {"sphere": {"radius": 6e-6}}, "position": [0, 0, 0]}]});
    fs::write(place.at("small.json"), ball(&small).to_string()).unwrap();
    let says = "warning: contact.overlap_tolerance, 1e-5 by default, is 83 % of the thinnest body's thickness, 1.2e-5";
    assert!(place.relcp(&["check", "small.json"]).expect(0).err.contains(says));
    let ran = place.relcp(&["run", "small.json", "--out", "run"]).expect(0);
    assert!(ran.err.contains(says) && ran.out.contains(says), "{ran:?}");
    assert!(place.json("run/summary.json")["warnings"][0].as_str().unwrap().contains("83 %"));
    let out = place.relcp(&["check", "small.json", "--json"]).expect(0).out;
    assert_eq!(serde_json::from_str::<Value>(&out).unwrap()["warnings"].as_array().unwrap().len(), 1);
    let fine = place.relcp(&["check", "small.json", "--set", "contact.overlap_tolerance=1e-10"]).expect(0);
    assert_eq!(fine.err, "");
}

#[test]
fn a_time_step_a_hundred_times_too_long_is_warned_of() {
    let place = Place::new();
    let push = json!({"forces": [{"uniform": {"force": [1, 0, 0]}}]});
    fs::write(place.at("pushed.json"), ball(&push).to_string()).unwrap();
    let warnings = |dt: &str| {
        let out = format!("run-{dt}");
        let set = format!("time.dt={dt}");
        let end = format!("time.end={}", 5.0 * dt.parse::<f64>().unwrap());
        let sets = ["--set", "dynamics.overdamped.drag=1", "--set", &set, "--set", &end];
        let out = place.relcp(&[&["run", "pushed.json", "--out", &out, "--json"], &sets[..]].concat()).expect(0).out;
        serde_json::from_str::<Value>(&out).unwrap()["warnings"].clone()
    };
    assert_eq!(warnings("0.1"), json!([]));
    let warned = warnings("100");
    assert_eq!(warned.as_array().unwrap().len(), 1, "{warned}");
    assert!(
        warned[0].as_str().unwrap().starts_with("time.dt is too long: forces.0 moves a body by 25 of its"),
        "{warned}"
    );
}

#[test]
fn a_batch_says_nothing_of_devices_that_nobody_asked_for() {
    let place = Place::new();
    fs::write(place.at("sweep.json"), r#"{"name": "s", "scene": "rods.json", "seeds": [1, 2]}"#).unwrap();
    let err = place.relcp(&["batch", "sweep.json"]).expect(0).err;
    assert!(!err.contains("adapter") && !err.contains("not used"), "{err}");
}

/// The help of every command, without the part that clap makes.
fn epilogues() -> Vec<(String, String)> {
    let help = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
        let output = command.env("COLUMNS", WIDTH.to_string()).args(arguments).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let commands = ["run", "batch", "contacts", "export", "measure", "render", "view", "completions", "man"];
    let of = |name: &str| {
        let help = help(&[name, "--help"]);
        let start = help.find("\nExamples:\n").unwrap_or_else(|| panic!("{name}: {help}"));
        (name.to_owned(), help[start..].to_owned())
    };
    commands.into_iter().map(of).collect()
}

#[test]
fn help_wraps_once() {
    for (name, text) in epilogues() {
        let lines: Vec<&str> = text.lines().collect();
        for pair in lines.windows(2) {
            let [line, next] = [pair[0], pair[1]];
            assert!(line.len() <= WIDTH, "{name}: {line}");
            if line.starts_with("  relcp ") {
                // An example is one line: what follows is another, a comment of its own, or blank.
                assert!(next.is_empty() || next.starts_with("  "), "{name}: {line}\n{next}");
                continue;
            }
            let first = next.split_whitespace().next().unwrap_or_default();
            let ends = line.is_empty()
                || next.is_empty()
                || line.ends_with(['.', ':', ')', ',', '}'])
                || line.starts_with("  ");
            let is_full = line.len() + 1 + first.len() > WIDTH - 2;
            assert!(ends || is_full, "{name}: broken before its end: {line}\n{next}");
        }
    }
}

#[test]
fn a_refusal_about_placing_has_no_place_in_the_file() {
    let place = Place::new();
    let founder = json!({"name": "f", "planar": true, "walls": [{"half_space": {"normal": [1, 0, 0], "offset": 0}}],
        "generate": [{"founder": {"position": [-5, 0, 0], "diameter": 1, "length": 2}}],
        "growth": {"division_length": 4, "rate": 1}, "time": {"dt": 0.1, "end": 1}});
    fs::write(place.at("f.json"), founder.to_string()).unwrap();
    for command in ["check", "run"] {
        let err = words(&place.relcp(&[command, "f.json"]).expect(2).err);
        assert!(err.contains("f.json:1:") && err.contains("generate.0.founder: the body reaches"), "{command}: {err}");
    }
    let set = "generate.0.founder.position.0=-6";
    let err = words(&place.relcp(&["check", "f.json", "--set", set]).expect(2).err);
    assert!(err.contains("generate.0.founder") && err.contains("reaches 7"), "{err}");
}

#[test]
fn an_object_with_a_wrong_key_or_a_list_in_its_place_does_not_say_what_may_stand_there() {
    let place = Place::new();
    let refusal = |more: Value| {
        fs::write(place.at("b.json"), ball(&more).to_string()).unwrap();
        words(&place.relcp(&["check", "b.json"]).expect(2).err)
    };
    let err = refusal(json!({"generate": [{"placement": "random", "count": 3}]}));
    assert!(err.contains("the keys here are isotropic, chainmail, founder"), "{err}");
    let err = refusal(json!({"walls": [{"half_space": {"normal": [0, 0, 1], "offset": 0}, "name": "floor"}]}));
    assert!(err.contains("the keys here are half_space"), "{err}");
    let err = refusal(json!({"periodic": [10, 10, 10]}));
    assert!(err.contains("b.json:1:") && err.contains("periodic: expected an object"), "{err}");
    assert!(err.contains("write \"periodic\": {\"lengths\": [...]}"), "{err}");
    let err = refusal(json!({"walls": [{"box": {"minimum": [-5, -5, -5], "maximum": [5, 5, null]}}]}));
    assert!(
        err.contains("walls.0.box.maximum.2: expected a number, found null") && err.contains("half_space"),
        "{err}"
    );
    let err = words(&place.relcp(&["run", "none.json"]).expect(4).err);
    assert!(err.contains("the current folder has no such file"), "{err}");
}
