//! What a sweep file means, and which ones are refused.

use relcp::batch::{BatchError, MAX_MEMBERS, Member, Plan};
use relcp::scene::{FaultKind, SceneError};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn plan(sweep: &str) -> Result<Plan, BatchError> {
    Plan::parse(sweep, "sweep.json", Path::new("tests/data"))
}

#[track_caller]
fn refused(sweep: &str) -> SceneError {
    match plan(sweep) {
        Err(BatchError::Scene(error)) => error,
        Err(other) => panic!("{other}"),
        Ok(plan) => panic!("{} members", plan.members().len()),
    }
}

fn labels(plan: &Plan) -> Vec<String> {
    plan.members().iter().map(Member::label).collect()
}

#[test]
fn a_grid_a_list_and_seeds_are_combined_in_the_order_of_the_file() {
    let plan = plan(
        r#"{ "name": "s", "scene": "rods.json", "set": { "time.end": 0.2, "contact.max_recursions": 9 },
             "grid": { "time.dt": [0.02, 0.01], "planar": [false] },
             "list": [ { "contact.method": "snsd" }, { "contact.max_recursions": 7 } ], "seeds": { "from": 5, "count": 2 } }"#,
    )
    .unwrap();
    assert_eq!(plan.columns(), ["time.dt", "planar", "contact.method", "contact.max_recursions", "seed"]);
    let expected = [
        "time.dt=0.02, planar=false, contact.method=\"snsd\", seed=5",
        "time.dt=0.02, planar=false, contact.method=\"snsd\", seed=6",
        "time.dt=0.02, planar=false, contact.max_recursions=7, seed=5",
        "time.dt=0.02, planar=false, contact.max_recursions=7, seed=6",
        "time.dt=0.01, planar=false, contact.method=\"snsd\", seed=5",
    ];
    assert_eq!((&labels(&plan)[..5], plan.members().len()), (&expected.map(str::to_owned)[..], 8));
    // What a member does not set is what its scene has: by `set`, or by default.
    let values: Vec<Value> = [0, 2].map(|i| serde_json::to_value(&plan.members()[i].values).unwrap()).into();
    assert_eq!((&values[0]["contact.max_recursions"], &values[1]["contact.method"]), (&json!(9), &json!("relcp")));
    let scene = plan.scene(7).unwrap();
    assert_eq!((scene.time.dt, scene.time.end, scene.seed, scene.contact.max_recursions), (0.01, 0.2, 6, 7));
    assert_eq!((plan.members()[7].steps, plan.members()[7].index), (20, 7));
    assert!(plan.members()[7].name().starts_with("0007-"));
    assert!(plan.scene(8).is_err());
}

#[test]
fn the_order_of_a_grid_is_that_of_the_file_and_not_of_the_alphabet() {
    let plan = plan(r#"{"name": "s", "scene": "rods.json", "grid": {"time.end": [1, 2], "seed": [3, 4]}}"#).unwrap();
    assert_eq!(labels(&plan)[1], "time.end=1, seed=4");
}

#[test]
fn a_sweep_that_varies_nothing_is_one_run() {
    let plan = plan("\u{feff}{\"name\": \"s\", \"scene\": \"three-capsules\"}").unwrap();
    assert_eq!((labels(&plan), plan.columns().len()), (vec![String::new()], 0));
}

#[test]
fn the_hash_in_a_name_is_that_of_the_run() {
    let plan = plan(r#"{"name": "s", "scene": "rods.json", "seeds": [3]}"#).unwrap();
    let scene = relcp::Scene::load("tests/data/rods.json", ["seed=3"]).unwrap();
    assert_eq!(plan.members()[0].scene_hash, relcp::record::scene_hash(&scene));
}

#[test]
fn bad_sweeps_are_refused_with_their_place() {
    use FaultKind::{BadOverride, BadValue, DuplicateKey, MissingKey, Syntax, UnknownKey, WrongType};
    let start = r#"{"name": "s", "scene": "rods.json","#;
    let mut wrong = Vec::new();
    for (rest, kind, line, column, key, says) in [
        (r#" "sedes": 1}"#, UnknownKey, 2, 2, "sedes", "`seeds`"),
        (r#" "grid": {"time.dtt": [1]}}"#, UnknownKey, 2, 11, "time.dtt", "the nearest is `dt`"),
        (r#" "grid": {"time.dt": [0.1, -2]}}"#, BadValue, 2, 28, "time.dt", "positive"),
        (r#" "grid": {"time.dt": [0.1, "x"]}}"#, WrongType, 2, 28, "time.dt", "a number"),
        (r#" "grid": {"time.dt": 0.1}}"#, WrongType, 2, 22, "grid.time.dt", "a list"),
        (r#" "grid": {"time.dt": []}}"#, BadValue, 2, 22, "grid.time.dt", "no values"),
        (r#" "grid": {"time..dt": [1]}}"#, BadOverride, 2, 11, "time..dt", "empty parts"),
        (r#" "grid": {"seed": [1], "seed": [2]}}"#, DuplicateKey, 2, 24, "grid.seed", "twice"),
        (r#" "list": [{"time.end": 1}, {"tim.end": 2}]}"#, UnknownKey, 2, 29, "tim", "`time`"),
        (r#" "list": [{"seed": 1}, {"seed": 1.5}]}"#, WrongType, 2, 33, "seed", "whole number"),
        (r#" "list": []}"#, BadValue, 2, 10, "list", "omit it"),
        (r#" "set": {"forces.9.uniform.group": "a"}}"#, BadOverride, 2, 10, "forces.9", "0 to 2"),
        (r#" "set": ["seed"]}"#, WrongType, 2, 9, "set", "an object"),
        (r#" "seeds": [1, -1]}"#, BadValue, 2, 15, "seeds.1", "whole number"),
        (r#" "seeds": {"from": 1, "cont": 2}}"#, UnknownKey, 2, 23, "seeds.cont", "`count`"),
        (r#" "seeds": {"from": 1}}"#, MissingKey, 2, 2, "seeds.count", "missing"),
        (r#" "seeds": {"from": 1, "count": 0}}"#, BadValue, 2, 32, "seeds.count", "1 or more"),
        (r#" "seeds": {"from": 18446744073709551615, "count": 2}}"#, BadValue, 2, 11, "seeds", "largest seed"),
        (r#" "seeds": []}"#, BadValue, 2, 11, "seeds", "omit it"),
        (r#" "seeds": 3}"#, WrongType, 2, 11, "seeds", "a list of seeds"),
        (r#" "seeds": [1], "grid": {"seed": [2]}}"#, BadValue, 2, 33, "grid.seed", "also varied by `seeds`"),
        (r#" "grid": {"time": [{}]}, "list": [{"time.dt": 1}]}"#, BadValue, 2, 47, "list.0.time.dt", "`time`"),
        (r#" "seeds": [1 2]}"#, Syntax, 2, 14, "seeds", "JSON"),
    ] {
        let error = refused(&format!("{start}\n{rest}"));
        let found = (error.kind(), error.line(), error.column(), error.key());
        let told =
            error.to_string().contains(says) && error.origin() == Some("sweep.json") && error.kind() != FaultKind::Io;
        if found != (kind, Some(line), Some(column), key) || !told {
            wrong.push(format!("{rest}: {found:?} {error}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_sweep_as_a_whole_may_be_wrong() {
    for (sweep, says) in [
        (r#"["s", "rods.json"]"#, "found a list"),
        ("", "empty"),
        (r#"{"name": "s"}"#, "missing"),
        (r#"{"name": "a/b", "scene": "rods.json"}"#, "slashes"),
        (r#"{"name": "..", "scene": "rods.json"}"#, "folder"),
        (r#"{"name": "s", "scene": "rods.json", "seeds": {"from": 1, "count": 100001}}"#, "more than 100000"),
        (
            r#"{"name": "s", "scene": "rods.json", "seeds": {"from": 1, "count": 18446744073709551615},
             "grid": {"time.dt": [1, 2]}}"#,
            "more than 100000",
        ),
        (r#"{"name": "s", "scene": "rods.json", "grid": {"seed": [1, 2, 1]}}"#, "members 0 and 2 are the same scene"),
        (r#"{"name": "s", "scene": "rods.json", "list": [{}, {"seed": 0}]}"#, "members 0 and 1 are the same scene"),
    ] {
        let error = refused(sweep);
        assert!(error.to_string().contains(says), "{sweep}: {error}");
    }
    assert_eq!(MAX_MEMBERS, 100_000);
}

#[test]
fn a_scene_that_is_not_there_or_is_wrong_itself_is_told() {
    let absent = refused("{\"name\": \"s\",\n \"scene\": \"colny\"}");
    assert_eq!((absent.kind(), absent.line(), absent.key()), (FaultKind::UnknownScene, Some(2), "scene"));
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("bad.json"), "{\"name\": \"x\",\n\"tme\": 1}").unwrap();
    let sweep = r#"{"name": "s", "scene": "bad.json", "seeds": [1]}"#;
    match Plan::parse(sweep, "sweep.json", place.path()) {
        Err(BatchError::Scene(error)) => {
            assert!(error.origin().unwrap().ends_with("bad.json"));
            assert_eq!((error.key(), error.line(), error.help_text()), ("tme", Some(2), Some("member 0: seed=1")));
        }
        _ => panic!("not refused"),
    }
}

/// Every example of the documentation is a sweep.
#[test]
fn documented_sweeps_are_sweeps() {
    let text = include_str!("../../docs/batch.md");
    let sweeps: Vec<&str> = text.split("```json\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(sweeps.len() >= 2);
    for sweep in sweeps {
        let plan = Plan::parse(sweep, "docs/batch.md", Path::new("docs")).unwrap();
        assert!(plan.members().len() > 1);
    }
}

#[test]
fn sweeps_whose_names_are_alike_have_folders_of_their_own() {
    let folder = |name: &str| {
        let sweep = format!(r#"{{"name": "{name}", "scene": "three-capsules", "seeds": [1, 2]}}"#);
        Plan::parse(&sweep, "sweep.json", Path::new("")).unwrap().folder_in(Path::new("runs"))
    };
    assert_eq!(folder("sweep-1"), Path::new("runs/sweep-1"));
    let names =
        ["sweep \u{f6}", "sweep \u{fc}", "sweep", "sweep ", "sweep-\u{f6}", "sweep+\u{f6}", "\u{1f600}", "\u{1f601}"];
    let folders: std::collections::BTreeSet<_> = names.iter().map(|name| folder(name)).collect();
    assert_eq!(folders.len(), names.len(), "{folders:?}");
}
