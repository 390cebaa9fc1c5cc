//! `--backend`, `--adapter` and `--precision`: what computes, as a command's document says.

use super::{Place, fresh};
use serde_json::Value;
use std::collections::HashMap;
use std::sync::{LazyLock, Mutex};

/// The adapter that `--backend gpu` takes, and whether it has f64.
static ADAPTER: LazyLock<Option<(String, bool)>> = LazyLock::new(|| {
    let printed = Place::new().relcp(&["devices", "--json"]).out;
    let found: Value = serde_json::from_str(&printed).unwrap();
    let taken = found["adapters"].as_array().unwrap().iter().find(|adapter| adapter["taken"] == true)?;
    Some((taken["name"].as_str().unwrap().to_owned(), taken["f64"] == true))
});

/// What a command says of what computed it: as its document has them, the adapter or the CPU, and the precision.
fn said(place: &Place, command: &str, more: &str) -> String {
    let out = fresh();
    let line = match command {
        "run" => format!("run three-capsules --set time.end=0.001 --set time.dt=0.001 --out {out}"),
        "batch" => {
            let sweep = r#"{"name": "one", "scene": "three-capsules", "set": {"time.end": 0.001, "time.dt": 0.001}}"#;
            std::fs::write(place.at("one.json"), sweep).unwrap();
            format!("batch one.json --out {out}")
        }
        "render" => format!("render run --last --size 64x36 --no-movie --out {out}"),
        "contacts" => "contacts run --cutoff 1".into(),
        other => other.into(),
    };
    let line = format!("{line} --json {more}");
    let printed = place.relcp(&line.split_whitespace().collect::<Vec<_>>()).expect(0).out;
    let document: Value = serde_json::from_str(&printed).unwrap();
    match command {
        "run" | "contacts" => format!("{} {} {}", document["backend"], document["adapter"], document["precision"]),
        "batch" => {
            let folder = document["members"][0]["folder"].as_str().unwrap();
            let summary = place.json(&format!("{out}/{folder}/summary.json"));
            format!("{} {} {}", summary["backend"], summary["adapter"], summary["precision"])
        }
        _ => document["adapter"].to_string(),
    }
}

/// What a command says on a device that is named, in the precision that is not the default where the device has it;
/// asked once for each command.
fn on_device(place: &Place, command: &str) -> Option<(String, String, &'static str)> {
    static SAID: Mutex<Option<HashMap<String, String>>> = Mutex::new(None);
    let Some((name, f64)) = &*ADAPTER else {
        println!("SKIP relcp {command} on a device: there is no adapter");
        return None;
    };
    let precision = if *f64 { "f64" } else { "f32" };
    let part = name.split_whitespace().next().unwrap();
    let more = match command {
        "render" => format!("--backend gpu --adapter {part}"),
        _ => format!("--backend gpu --adapter {part} --precision {precision}"),
    };
    let mut said_so_far = SAID.lock().unwrap();
    let known = said_so_far.get_or_insert_default();
    let words = known.entry(command.to_owned()).or_insert_with(|| said(place, command, &more));
    Some((words.clone(), name.clone(), precision))
}

pub fn shows_backend(place: &Place, command: &str) {
    let cpu = said(place, command, "--backend cpu");
    assert!(cpu.to_lowercase().contains("cpu") || command == "render" && cpu == "null", "{cpu}");
    if let Some((said, name, _)) = on_device(place, command) {
        assert!(said.contains(&name), "{said}");
    }
}

pub fn shows_adapter(place: &Place, command: &str) {
    let words = super::tiny(place, command, &fresh());
    let words: Vec<&str> = words.iter().map(|word| if word == "cpu" { "gpu" } else { word }).collect();
    let err = place.relcp(&[&words[..], &["--adapter", "no-such"]].concat()).expect(5).err;
    assert!(err.contains("no usable adapter named no-such"), "{err}");
    super::ran(place, command, &["--adapter", "any"]).expect(2);
    if let Some((said, name, _)) = on_device(place, command) {
        assert!(said.contains(&name), "{said}");
    }
}

pub fn shows_precision(place: &Place, command: &str) {
    super::ran(place, command, &["--precision", "f16"]).expect(2);
    let err = super::ran(place, command, &["--precision", "f32"]).expect(2).err;
    assert!(err.contains("the CPU computes in f64"), "{err}");
    assert!(said(place, command, "--backend cpu --precision f64").contains("f64"));
    if let Some((said, _, precision)) = on_device(place, command) {
        assert!(said.contains(precision), "{said}");
    }
}
