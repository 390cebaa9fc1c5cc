//! What users tripped over, each test named by its symptom.

use super::place::Place;
use serde_json::{Value, json};
use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A message of at most this many bytes fits a terminal.
const MOST_BYTES: usize = 2_000;

/// A scene of so many spheres in a row.
fn spheres(count: usize) -> Value {
    let bodies: Vec<Value> =
        (0..count).map(|i| json!({"shape": {"sphere": {"radius": 1}}, "position": [3 * i, 0, 0]})).collect();
    json!({"name": "row", "time": {"dt": 0.1, "end": 1}, "bodies": bodies})
}

#[test]
fn a_fault_near_the_end_of_one_long_line_is_an_excerpt() {
    let place = Place::new();
    let mut scene = spheres(2_000);
    scene["bodies"][1_995]["position"][2] = json!("a");
    fs::write(place.at("long.json"), scene.to_string()).unwrap();
    let err = place.relcp(&["check", "long.json"]).expect(2).err;
    assert!(err.contains("bodies.1995.position.2: expected a number"), "{err}");
    assert!(err.lines().any(|line| line.contains("[5985,0,\"a\"]")), "{err}");
    assert!(err.len() <= MOST_BYTES, "{} bytes", err.len());
}

#[test]
fn no_fault_prints_more_than_fits_a_terminal_whatever_the_scene() {
    let place = Place::new();
    let long = "x".repeat(100_000);
    let mut scenes =
        vec![json!({ long.clone(): 1 }), json!({"name": long, "time": 3}), json!({"name": 1, "seed": long})];
    let mut scene = spheres(1);
    scene["forces"] = json!([{ long.clone(): {} }]);
    scenes.push(scene.clone());
    scene["forces"] = json!([long]);
    scenes.push(scene.clone());
    scene["forces"] = json!([]);
    scene["bodies"][0]["shape"] = json!({"sphere": {long.clone(): 1}});
    scenes.push(scene);
    for scene in scenes {
        fs::write(place.at("long.json"), scene.to_string()).unwrap();
        let err = place.relcp(&["check", "long.json"]).expect(2).err;
        assert!(err.len() <= MOST_BYTES, "{} bytes: {err}", err.len());
    }
    let err = place.relcp(&["check", "rods.json", "--set", &format!("{long}=1")]).expect(2).err;
    assert!(err.len() <= MOST_BYTES, "{} bytes: {err}", err.len());
}

#[test]
fn messages_break_lines_at_spaces_only() {
    let place = Place::new();
    let name = format!("{}-{}.json", "folder-with-a-long-name".repeat(4), "0.123456789-and-more".repeat(3));
    let err = place.relcp(&["run", &name]).expect(4).err;
    assert!(err.contains(&name), "{err}");
}

#[test]
fn a_key_that_is_like_no_other_has_no_nearest() {
    let place = Place::new();
    let mut scene = spheres(1);
    scene["forces"] = json!([{"spring": {}}]);
    fs::write(place.at("spring.json"), scene.to_string()).unwrap();
    let err = place.relcp(&["check", "spring.json"]).expect(2).err;
    assert!(!err.contains("nearest") && err.contains("gravity"), "{err}");
}

#[test]
fn a_negative_number_is_a_bad_value_not_an_unknown_option() {
    let place = Place::new();
    for [command, option] in [["run", "--max-wall"], ["run", "--threads"], ["batch", "--jobs"], ["render", "--fps"]] {
        let err = place.relcp(&[command, "rods.json", option, "-1"]).expect(2).err;
        assert!(err.contains("invalid value '-1'") && !err.contains("tip:"), "{err}");
    }
}

/// A signal ends the placement of many bodies at once, and nothing is left.
#[test]
#[cfg(unix)]
fn a_signal_while_bodies_are_placed_ends_the_run() {
    let place = Place::new();
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_relcp"))
        .current_dir(place.0.path())
        .args(["run", "compaction", "--set", "generate.0.isotropic.count=10000000", "--out", "big"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    super::place::signal(&child, "-TERM");
    let asked = Instant::now();
    let status = child.wait().unwrap();
    // Within a second on an idle machine; this bound only tells it from minutes.
    assert!(asked.elapsed() < Duration::from_secs(20), "{:?}", asked.elapsed());
    assert_eq!(status.code(), Some(130));
    let err = std::io::read_to_string(child.stderr.take().unwrap()).unwrap();
    assert!(err.contains("10000000 bodies") && err.contains("GB of memory"), "{err}");
    assert!(err.contains("of 10000000 bodies were placed"), "{err}");
    assert!(!place.at("big").exists());
}

#[test]
fn a_run_ends_at_its_end_where_dt_does_not_divide_it() {
    let place = Place::new();
    for (dt, end, steps) in [("5", "1", 1), ("0.3", "1", 4), ("0.1", "1", 10)] {
        let run = format!("run-{dt}");
        let (dt, end) = (format!("time.dt={dt}"), format!("time.end={end}"));
        place.relcp(&["run", "rods.json", "--set", &dt, "--set", &end, "--quiet", "--out", &run]).expect(0);
        let summary = place.json(&format!("{run}/summary.json"));
        assert_eq!((&summary["time"], &summary["steps"]), (&json!(1.0), &json!(steps)), "{dt}");
        assert_eq!(place.json(&format!("{run}/final.json"))["time"]["start"], json!(1.0));
    }
}

/// Where nothing is in the way, the shorter last step ends where steps that divide the time do.
#[test]
fn a_shorter_last_step_moves_bodies_by_its_part() {
    let place = Place::new();
    let mut scene = spheres(1);
    scene["forces"] = json!([{"uniform": {"force": [1, 0, 0]}}]);
    fs::write(place.at("one.json"), scene.to_string()).unwrap();
    let end = |dt: &str| {
        let run = format!("run-{dt}");
        let dt = format!("time.dt={dt}");
        place.relcp(&["run", "one.json", "--set", &dt, "--quiet", "--out", &run]).expect(0);
        place.json(&format!("{run}/final.json"))["bodies"][0]["position"][0].as_f64().unwrap()
    };
    let whole = end("0.1");
    for dt in ["0.3", "0.7", "4"] {
        assert!((end(dt) - whole).abs() < 1e-12, "{dt}");
    }
}

#[test]
fn a_damaged_state_is_left_out_with_a_note() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--out", "run"]).expect(0);
    let states = || fs::read_dir(place.at("run/states")).unwrap().map(|entry| entry.unwrap().path());
    let all = states().count();
    let broken = states().max().unwrap();
    // The checkpoint stands in the place of the last one.
    let broken = states().filter(|path| *path != broken).max().unwrap();
    let mut bytes = fs::read(&broken).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&broken, &bytes).unwrap();
    let name = broken.file_name().unwrap().to_str().unwrap().to_owned();
    for command in ["measure", "export", "render", "view"] {
        let mut arguments = vec![command, "run", "--json"];
        match command {
            "export" => arguments.extend(["--format", "gsd"]),
            "render" => arguments.extend(["--size", "64x36"]),
            _ => {}
        }
        let printed: Value = serde_json::from_str(&place.relcp(&arguments).expect(0).out).unwrap();
        let notes = printed["notes"].to_string();
        assert!(notes.contains(&name) && notes.contains("left out"), "{command}: {notes}");
        if let Some(frames) = printed["frames"].as_array() {
            assert_eq!(frames.len(), all - 1);
        }
    }
    // Alone it is refused.
    place.relcp(&["measure", broken.to_str().unwrap()]).expect(4);
}

#[test]
fn the_last_state_alone_is_drawn_exported_and_shown() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--out", "run"]).expect(0);
    for arguments in
        [&["render", "run", "--size", "64x36"][..], &["view", "run"], &["export", "run", "--format", "vtk"]]
    {
        let out = place.relcp(&[arguments, &["--last", "--json"]].concat()).expect(0).out;
        let printed: Value = serde_json::from_str(&out).unwrap();
        let states = printed["frames"].as_array().map_or(printed["states"].as_u64(), |list| Some(list.len() as u64));
        assert_eq!(states, Some(1), "{out}");
    }
}

#[test]
fn colours_by_force_leave_out_states_without_forces() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--out", "run"]).expect(0);
    let out = place.relcp(&["render", "run", "--colour", "force", "--size", "64x36", "--json"]).expect(0).out;
    let printed: Value = serde_json::from_str(&out).unwrap();
    // The checkpoint's forces are known, those of the states are not.
    assert_eq!(printed["frames"].as_array().unwrap().len(), 1);
    assert!(printed["notes"].to_string().contains("have no force"), "{out}");
}

#[test]
fn the_picture_of_a_run_can_be_left_out() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--set", "output.picture=false", "--out", "run"]).expect(0);
    assert!(!place.at("run/final.png").exists() && place.at("run/final.json").exists());
}

#[test]
fn contacts_have_a_head_and_ids_and_a_precision_without_a_device_is_refused() {
    let place = Place::new();
    place.relcp(&["run", "rods.json", "--quiet", "--out", "run"]).expect(0);
    let out = place.relcp(&["contacts", "run", "--cutoff", "1"]).expect(0).out;
    assert_eq!(
        out.lines().next().unwrap().split_whitespace().collect::<Vec<_>>().join(" "),
        "body a body b id a id b separation"
    );
    let printed: Value =
        serde_json::from_str(&place.relcp(&["contacts", "run", "--cutoff", "1", "--json"]).expect(0).out).unwrap();
    assert_eq!((&printed["contacts"][0]["id_a"], &printed["contacts"][0]["id_b"]), (&json!(0), &json!(1)));
    assert_eq!((&printed["backend"], &printed["precision"]), (&json!("cpu"), &json!("f64")));
    for option in [["--precision", "f32"], ["--adapter", "x"]] {
        place.relcp(&[&["contacts", "run"], &option[..]].concat()).expect(2);
    }
}

#[test]
fn a_scene_is_read_from_standard_input() {
    let place = Place::new();
    let text = fs::read(place.at("rods.json")).unwrap();
    let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
    let arguments = ["run", "-", "--set", "time.end=0.1", "--quiet", "--out", "run"];
    command.current_dir(place.0.path()).args(arguments).write_stdin(text).assert().success();
    assert_eq!(place.json("run/summary.json")["time"], json!(0.1));
    let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
    let output = command.args(["check", "-"]).write_stdin("{\"nme\": 1}").output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && err.contains("standard input:1:2: nme: unknown key"), "{err}");
}

#[test]
#[cfg(unix)]
fn paths_need_not_be_unicode() {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let place = Place::new();
    let name = |text: &[u8]| OsString::from_vec(text.to_vec());
    fs::copy(place.at("rods.json"), place.0.path().join(name(b"rods-\xff.json"))).unwrap();
    let run = |arguments: &[OsString]| {
        let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
        command.current_dir(place.0.path()).args(arguments).assert().success();
    };
    let words = |words: &[&str]| -> Vec<OsString> { words.iter().map(Into::into).collect() };
    let out = name(b"run-\xfe");
    run(&[
        words(&["run", "--quiet", "--view", "--set", "time.end=0.1"]),
        vec![name(b"rods-\xff.json"), "--out".into(), out.clone()],
    ]
    .concat());
    for command in [
        &["measure", "--quiet"][..],
        &["contacts"],
        &["export", "--format", "xyz"],
        &["render", "--last", "--size", "64x36"],
    ] {
        run(&[words(command), vec![out.clone()]].concat());
    }
    run(&[words(&["run", "--resume", "--quiet", "--set", "time.end=0.1"]), vec!["--out".into(), out]].concat());
}
