//! A folder for each member: what is done is kept, what is missing is run.

use super::{Place, SWEEP, states};
use serde_json::{Value, json};
use std::fs;

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
