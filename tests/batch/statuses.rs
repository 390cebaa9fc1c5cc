//! What the program says and its exit status.

use super::{Place, SWEEP};
use crate::ran::Ran;
use assert_cmd::Command;
use serde_json::{Value, json};
use std::fs;

#[test]
fn a_list_names_the_members_and_runs_nothing() {
    let place = Place::new(SWEEP);
    let list = place.batch(&["--list"]).expect(0).out;
    assert_eq!(list.lines().count(), 4);
    assert!(list.lines().nth(2).unwrap().ends_with("forces.0.uniform.force.2=-2, seed=1"), "{list}");
    let json: Value = serde_json::from_str(&place.batch(&["--list", "--json", "--out", "x"]).expect(0).out).unwrap();
    let member = &json["members"][2];
    assert_eq!((&member["index"], &member["set"]["seed"]), (&json!(2), &json!(1)));
    let name = member["folder"].as_str().unwrap().strip_prefix("x/0002-").unwrap();
    assert!(member["scene_hash"].as_str().unwrap().starts_with(name));
    assert_eq!(fs::read_dir(&place.0).unwrap().count(), 2);
}

/// A body so light that it leaves the numbers there are, unless it is dragged.
const BLOWS_UP: &str = r#"{ "name": "blow", "time": { "dt": 1e50, "end": 5e50 },
  "dynamics": { "inertial": { "density": 1e-60 } }, "contact": { "overlap_tolerance": 1e-50 },
  "forces": [ { "uniform": { "force": [1e50, 0, 0] } } ],
  "bodies": [ { "shape": { "sphere": { "radius": 1e-40 } }, "position": [0, 0, 0] } ] }"#;

#[test]
fn a_member_that_stops_is_status_3_and_tried_again_when_asked() {
    let place = Place::new(
        r#"{"name": "b", "scene": "blow.json", "list": [{}, {"dynamics.overdamped.drag": 1, "forces.0.uniform.force.0": 0}]}"#,
    );
    fs::write(place.at("blow.json"), BLOWS_UP).unwrap();
    let first = place.batch(&["--jobs", "1"]).expect(3);
    assert!(
        first.err.contains("stopped: step 1: the ") && first.err.contains("of body 0 is not finite"),
        "{}",
        first.err
    );
    let table = place.json("runs/b/batch.json");
    assert_eq!((&table["members"][0]["status"], &table["members"][1]["status"]), (&json!("stopped"), &json!("done")));
    assert!(table["members"][0]["message"].as_str().unwrap().contains("not finite"));
    let before = place.hashes("runs/b");
    assert_eq!(table["members"][0]["reason"], "not_finite");
    let again = place.batch(&[]).expect(3);
    assert!(again.err.contains("stopped earlier; --retry"), "{}", again.err);
    assert_eq!(place.hashes("runs/b"), before);
    let retried = place.batch(&["--retry"]).expect(3);
    assert!(retried.err.contains("not finite") && place.hashes("runs/b") != before, "{}", retried.err);
    place.batch(&["--table", "--quiet"]).expect(3);
}

/// Two overlapping spheres pushed together: without recursion, and with one iteration, they stay overlapped.
const PRESSED: &str = r#"{
  "name": "pressed", "time": { "dt": 0.01, "end": 0.05 },
  "contact": { "method": "snsd" }, "solver": { "kind": "projected_jacobi", "max_iterations": 1 },
  "forces": [ { "uniform": { "force": [1, 0, 0], "group": "left" } }, { "uniform": { "force": [-3, 0, 0], "group": "right" } } ],
  "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0], "group": "left" },
              { "shape": { "sphere": { "radius": 1 } }, "position": [1.9, 0, 0] },
              { "shape": { "sphere": { "radius": 1 } }, "position": [3.8, 0, 0], "group": "right" } ]
}"#;

#[test]
fn the_exit_status_is_the_worst_of_the_members() {
    let sweep = r#"{"name": "p", "scene": "pressed.json", "list": [{}, {"contact.method": "relcp", "solver.kind": "auto",
                    "solver.max_iterations": 1000}]}"#;
    let place = Place::new(sweep);
    fs::write(place.at("pressed.json"), PRESSED).unwrap();
    let ran = place.batch(&[]).expect(3);
    assert!(
        ran.err.contains("ended out of tolerance") && ran.out.contains("out of tolerance"),
        "{}{}",
        ran.err,
        ran.out
    );
    assert_eq!(place.json("runs/p/batch.json")["members"][1]["status"], "done");
    // The same where it was done before, and from the table; one member alone has its own.
    place.batch(&["--quiet"]).expect(3);
    place.batch(&["--table", "--quiet"]).expect(3);
    place.batch(&["--index", "1", "--quiet"]).expect(0);
    // A file that cannot be written is worse, and does not stop the other.
    for folder in place.folders("runs/p") {
        let picture = place.at("runs/p").join(folder).join("final.png");
        fs::remove_file(&picture).unwrap();
        fs::remove_file(picture.with_file_name("summary.json")).unwrap();
    }
    let first = place.at("runs/p").join(&place.folders("runs/p")[0]);
    fs::create_dir(first.join("final.png")).unwrap();
    let ran = place.batch(&["--jobs", "1"]).expect(4);
    assert!(ran.err.contains("final.png: could not put it in place: "), "{}", ran.err);
    let table = place.json("runs/p/batch.json");
    assert_eq!((&table["members"][0]["status"], &table["members"][1]["status"]), (&json!("failed"), &json!("done")));
}

#[test]
fn bad_sweeps_and_arguments_run_nothing() {
    let place = Place::new(&SWEEP.replace("[-1, -2]", "[-1, 1e100]"));
    let ran = place.batch(&[]).expect(2);
    assert!(ran.err.contains("sweep.json:2:") && ran.err.contains("1e100"), "{}", ran.err);
    for arguments in
        [&["--jobs", "0"] as &[&str], &["--count", "--table"], &["--precision", "f32"], &["--adapter", "x"]]
    {
        place.batch(arguments).expect(2);
    }
    fs::write(place.at("sweep.json"), SWEEP).unwrap();
    place.batch(&["--precision", "f32"]).expect(2);
    assert_eq!(fs::read_dir(&place.0).unwrap().count(), 2);
    fs::remove_file(place.at("rods.json")).unwrap();
    assert!(place.batch(&[]).expect(4).err.contains("rods.json"));
    fs::remove_file(place.at("sweep.json")).unwrap();
    assert!(place.batch(&["--count"]).expect(4).err.contains("sweep.json"));
}

fn relcp(arguments: &[&str]) -> Ran {
    Ran::of(Command::cargo_bin("relcp").unwrap().args(arguments))
}

#[test]
fn the_schema_of_sweeps_is_strict_and_that_of_scenes_is_as_it_was() {
    let schema: Value = serde_json::from_str(&relcp(&["schema", "--sweep"]).expect(0).out).unwrap();
    assert_eq!((&schema["additionalProperties"], &schema["required"]), (&json!(false), &json!(["name", "scene"])));
    let keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
    assert_eq!(keys, ["grid", "list", "name", "scene", "seeds", "set"]);
    assert_eq!(schema["properties"]["grid"]["additionalProperties"]["type"], "array");
    let scene: Value = serde_json::from_str(&relcp(&["schema"]).expect(0).out).unwrap();
    assert_eq!(scene, relcp::scene::schema());
}

#[test]
fn pages_of_the_manual_know_the_commands() {
    let page = relcp(&["man"]).expect(0).out;
    assert!(
        page.contains(".TH relcp 1") && page.contains("relcp\\-batch(1)") && page.contains("Exit status"),
        "{page}"
    );
    let page = relcp(&["man", "run"]).expect(0).out;
    assert!(page.contains(".TH relcp-run 1") && page.contains("\\-\\-resume") && page.contains("Examples"), "{page}");
    assert!(relcp(&["man", "walk"]).expect(2).err.contains("completions"));
}

#[test]
fn misspelt_commands_and_keys_are_told_the_nearest() {
    assert!(relcp(&["bacth"]).expect(2).err.contains("'batch'"));
    assert!(relcp(&["batch", "x.json", "--rety"]).expect(2).err.contains("'--retry'"));
    let key = relcp(&["check", "colony", "--set", "growth.rat=1"]).expect(2);
    assert!(key.err.contains("`rate`"), "{}", key.err);
}
