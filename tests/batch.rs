//! Batches: what a sweep file means, and `relcp batch` from outside.
#![allow(clippy::unwrap_used)]

use assert_cmd::Command;
use relcp::batch::{BatchError, MAX_MEMBERS, Member, Plan};
use relcp::scene::{FaultKind, SceneError};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant, SystemTime};

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
        (r#" "seeds": [1], "grid": {"seed": [2]}}"#, BadValue, 2, 33, "grid.seed", "`seeds` too"),
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

/// A place of its own with the scene of two rods that are pushed together, as `rods.json`, and a sweep of ten steps
/// each.
struct Place(tempfile::TempDir);

const SWEEP: &str = r#"{ "name": "press", "scene": "rods.json", "set": { "time.end": 0.2 },
                         "grid": { "forces.0.uniform.force.2": [-1, -2] }, "seeds": [1, 2] }"#;

impl Place {
    fn new(sweep: &str) -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        fs::write(place.at("rods.json"), include_str!("data/rods.json")).unwrap();
        fs::write(place.at("sweep.json"), sweep).unwrap();
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `relcp batch sweep.json` and these.
    fn batch(&self, arguments: &[&str]) -> Ran {
        let mut command = Command::cargo_bin("relcp").unwrap();
        command.current_dir(&self.0).args(["batch", "sweep.json", "--backend", "cpu"]);
        let output = command.args(arguments).output().unwrap();
        Ran {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.at(name)).unwrap()).unwrap()
    }

    /// The folders of a batch's members.
    fn folders(&self, out: &str) -> Vec<String> {
        let entries = fs::read_dir(self.at(out)).unwrap().map(|entry| entry.unwrap());
        let folders = entries.filter(|entry| entry.file_type().unwrap().is_dir());
        let mut names: Vec<String> = folders.map(|entry| entry.file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Of each member's folder, the hash of the state and when the summary was written.
    fn hashes(&self, out: &str) -> BTreeMap<String, (Value, SystemTime)> {
        let of = |name: String| {
            let path = format!("{out}/{name}/summary.json");
            let written = fs::metadata(self.at(&path)).unwrap().modified().unwrap();
            (name, (self.json(&path)["state_hash"].clone(), written))
        };
        self.folders(out).into_iter().map(of).collect()
    }
}

#[derive(Debug)]
struct Ran {
    status: Option<i32>,
    out: String,
    err: String,
}

impl Ran {
    #[track_caller]
    fn expect(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:#?}");
        self
    }
}

fn states(hashes: &BTreeMap<String, (Value, SystemTime)>) -> Vec<(&String, &Value)> {
    hashes.iter().map(|(name, (hash, _))| (name, hash)).collect()
}

#[test]
fn a_batch_leaves_a_folder_a_member_and_a_table() {
    let place = Place::new(SWEEP);
    let ran = place.batch(&[]).expect(0);
    assert_eq!(ran.out.lines().count(), 5, "{}", ran.out);
    assert!(ran.err.contains("4 of 4: "), "{}", ran.err);
    let table = place.json("runs/press/batch.json");
    assert_eq!(table["columns"], json!(["forces.0.uniform.force.2", "seed"]));
    let last = &table["members"][3];
    assert_eq!((&last["values"]["forces.0.uniform.force.2"], &last["set"]["seed"]), (&json!(-2), &json!(2)));
    let summary = place.json(&format!("runs/press/{}/summary.json", last["folder"].as_str().unwrap()));
    for key in ["status", "steps", "bodies", "max_overlap", "state_hash", "scene_hash"] {
        assert_eq!((last.get(key), last[key].is_null()), (summary.get(key), false), "{key}");
    }
    assert_eq!((&last["products"], &last["steps"]), (&summary["solver"]["products"], &json!(10)));
    let csv = fs::read_to_string(place.at("runs/press/batch.csv")).unwrap();
    let heading =
        "index,forces.0.uniform.force.2,seed,status,stopped_by,steps,bodies,max_overlap,recursions_mean,products,";
    assert!(csv.starts_with(heading) && csv.lines().nth(4).unwrap().starts_with("3,-2,2,done,,10,2,"), "{csv}");
    // Again: nothing is left to do, and nothing is touched.
    let before = place.hashes("runs/press");
    assert_eq!(place.batch(&["--quiet"]).expect(0).out, "");
    assert_eq!(place.hashes("runs/press"), before);
    let json: Value = serde_json::from_str(&place.batch(&["--json"]).expect(0).out).unwrap();
    assert_eq!(json, table);
}

#[test]
fn only_what_is_missing_is_run() {
    let place = Place::new(SWEEP);
    place.batch(&["--quiet"]).expect(0);
    let before = place.hashes("runs/press");
    let names = place.folders("runs/press");
    // One is gone; one was killed before its first checkpoint, one after it.
    fs::remove_dir_all(place.at("runs/press").join(&names[0])).unwrap();
    for (name, kept) in
        [(&names[1], &["scene.json", "steps.csv"][..]), (&names[2], &["scene.json", "steps.csv", "checkpoint.npz"])]
    {
        let folder = place.at("runs/press").join(name);
        for entry in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let file = entry.file_name().unwrap().to_str().unwrap().to_owned();
            if entry.is_file() && !kept.contains(&file.as_str()) {
                fs::remove_file(entry).unwrap();
            }
        }
        if kept.len() == 2 {
            fs::remove_dir_all(folder.join("states")).unwrap();
        }
    }
    let table = place.batch(&["--table", "--json"]).expect(0);
    assert!(table.err.contains("3 of 4 members"), "{}", table.err);
    let table: Value = serde_json::from_str(&table.out).unwrap();
    let status: Vec<&Value> = table["members"].as_array().unwrap().iter().map(|m| &m["status"]).collect();
    assert_eq!(status, ["missing", "unfinished", "unfinished", "done"]);
    let ran = place.batch(&[]).expect(0);
    assert!(ran.err.contains("3 of 3: ") && !ran.err.contains(&names[3]), "{}", ran.err);
    let after = place.hashes("runs/press");
    assert_eq!(states(&after), states(&before));
    for (name, (_, written)) in &after {
        assert_eq!(*written == before[name].1, name == &names[3], "{name}");
    }
}

/// Members that take long enough to be stopped in the middle.
const LONG: &str = r#"{ "name": "long", "scene": "rods.json", "set": { "time.dt": 0.0001, "output.every": 0.01 },
                        "seeds": [1, 2, 3] }"#;

#[cfg(unix)]
fn stopped(place: &Place, out: &str, signal: &str) -> (Option<i32>, String) {
    let started = SystemTime::now();
    let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("relcp"))
        .current_dir(&place.0)
        .args(["batch", "sweep.json", "--backend", "cpu", "--jobs", "2", "--out", out])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    // A state of this time, not one that an earlier time left.
    let written = |name: &String| {
        fs::metadata(place.at(out).join(name).join("states/state_0000000500.npz")).ok()?.modified().ok()
    };
    let in_the_middle = |name: &String| written(name).is_some_and(|at| at > started);
    while !place.at(out).is_dir() || !place.folders(out).iter().any(in_the_middle) {
        assert!(begun.elapsed() < Duration::from_secs(600), "the batch does not get on");
        std::thread::sleep(Duration::from_millis(1));
    }
    // The shell's own: bare systems have no program of this name.
    let kill = format!("kill {signal} {}", child.id());
    let sent = std::process::Command::new("sh").args(["-c", &kill]).status().unwrap();
    assert!(sent.success());
    let ended = child.wait_with_output().unwrap();
    (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
}

/// Killed, gone on with, interrupted, gone on with: the same bits as one that was left alone.
#[cfg(unix)]
#[test]
fn a_stopped_batch_goes_on_to_the_same_bits() {
    let place = Place::new(LONG);
    assert_eq!(stopped(&place, "broken", "-KILL").0, None);
    let (status, err) = stopped(&place, "broken", "-INT");
    assert_eq!(status, Some(130), "{err}");
    assert!(err.contains("stopped; the same command continues"), "{err}");
    let table = place.json("broken/batch.json");
    let status: Vec<&str> =
        table["members"].as_array().unwrap().iter().map(|m| m["status"].as_str().unwrap()).collect();
    assert!(status.contains(&"interrupted") && !status.contains(&"fault"), "{status:?}");
    assert_eq!(place.batch(&["--out", "broken", "--quiet"]).expect(0).out, "");
    place.batch(&["--out", "whole", "--quiet", "--jobs", "1", "--threads", "3"]).expect(0);
    let (whole, broken) = (place.hashes("whole"), place.hashes("broken"));
    assert_eq!((states(&whole), whole.len()), (states(&broken), 3));
}

/// As an array of jobs on a cluster does it; `docs/batch.md` has this line.
#[cfg(unix)]
#[test]
fn members_one_by_one_come_to_the_same_as_the_whole() {
    let place = Place::new(SWEEP);
    assert_eq!(place.batch(&["--count"]).expect(0).out, "4\n");
    let program = assert_cmd::cargo::cargo_bin("relcp");
    let documented = include_str!("../docs/batch.md").lines().find(|line| line.contains("xargs -P")).unwrap();
    let script = documented.replace("rates.json", "sweep.json --backend cpu").replace("relcp batch", "\"$0\" batch");
    let ran =
        std::process::Command::new("sh").current_dir(&place.0).args(["-c", &script]).arg(program).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    assert!(!place.at("runs/press/batch.csv").exists());
    assert!(place.batch(&["--table"]).expect(0).out.contains("done"));
    for jobs in ["1", "2"] {
        place.batch(&["--out", jobs, "--jobs", jobs, "--quiet"]).expect(0);
    }
    let by_one = place.hashes("runs/press");
    for whole in ["1", "2"] {
        assert_eq!(states(&place.hashes(whole)), states(&by_one), "{whole} jobs");
    }
    assert_eq!(by_one.len(), 4);
    let beyond = place.batch(&["--index", "4"]).expect(2);
    assert!(beyond.err.contains("has 4, numbered from 0"), "{}", beyond.err);
    place.batch(&["--index", "1", "--list"]).expect(2);
}

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

#[test]
fn a_folder_of_another_scene_is_refused_before_anything_is_run() {
    let place = Place::new(SWEEP);
    place.batch(&["--index", "0", "--quiet"]).expect(0);
    let list: Value = serde_json::from_str(&place.batch(&["--list", "--json"]).expect(0).out).unwrap();
    let folder = |index: usize| place.at(list["members"][index]["folder"].as_str().unwrap());
    // The first member's run, where the fourth's should be; and there something that is no run at all.
    fs::rename(folder(0), folder(3)).unwrap();
    let ran = place.batch(&[]).expect(2);
    assert!(ran.err.contains("belongs to a different scene") && ran.err.contains("seed"), "{}", ran.err);
    assert_eq!(place.folders("runs/press").len(), 1);
    fs::remove_file(folder(3).join("summary.json")).unwrap();
    place.batch(&[]).expect(2);
    let table = place.batch(&["--table"]).expect(2).out;
    assert!(table.contains("refused"), "{table}");
    fs::remove_dir_all(folder(3)).unwrap();
    fs::create_dir(folder(3)).unwrap();
    fs::write(folder(3).join("notes.txt"), "mine").unwrap();
    assert!(place.batch(&[]).expect(2).err.contains("not empty"));
    assert_eq!(place.folders("runs/press").len(), 1);
    fs::remove_dir_all(folder(3)).unwrap();
    fs::write(folder(3), "a file").unwrap();
    assert!(place.batch(&[]).expect(4).err.contains("folder"));
}

#[test]
fn a_sweep_that_is_changed_keeps_what_is_done() {
    let place = Place::new(SWEEP);
    place.batch(&["--quiet"]).expect(0);
    let before = place.hashes("runs/press");
    // Another seed shifts the indices; without the weaker force its members are of no sweep.
    fs::write(place.at("sweep.json"), SWEEP.replace("[-1, -2]", "[-2]").replace("[1, 2]", "[1, 2, 3]")).unwrap();
    let ran = place.batch(&[]).expect(0);
    assert!(ran.err.contains("1 of 1: 0002-"), "{}", ran.err);
    assert_eq!(ran.err.matches("is not a member of this sweep").count(), 2, "{}", ran.err);
    let after = place.hashes("runs/press");
    assert_eq!((after.len(), before.iter().all(|(name, run)| after[name] == *run)), (5, true));
    let table = place.json("runs/press/batch.json");
    assert!(table["members"][0]["folder"].as_str().unwrap().starts_with("0002-"), "{table}");
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

/// Every example of the documentation is a sweep.
#[test]
fn documented_sweeps_are_sweeps() {
    let text = include_str!("../docs/batch.md");
    let sweeps: Vec<&str> = text.split("```json\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(sweeps.len() >= 2);
    for sweep in sweeps {
        let plan = Plan::parse(sweep, "docs/batch.md", Path::new("docs")).unwrap();
        assert!(plan.members().len() > 1);
    }
}

fn relcp(arguments: &[&str]) -> Ran {
    let output = Command::cargo_bin("relcp").unwrap().args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ran { status: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
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
