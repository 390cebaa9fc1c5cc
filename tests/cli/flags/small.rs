//! Flags of `scenes`, `check`, `contacts`, `export`, `devices` and `schema`.

use super::{Case, Place, case, compute, fresh, json, ran, shows_json, shows_quiet, threads};
use serde_json::Value;

pub const CASES: &[Case] = &[
    case("scenes", "--json", shows_json),
    case("check", "--set", set),
    case("check", "--json", shows_json),
    case("check", "--quiet", shows_quiet),
    case("contacts", "--cutoff", cutoff),
    case("contacts", "--backend", compute::shows_backend),
    case("contacts", "--adapter", compute::shows_adapter),
    case("contacts", "--precision", compute::shows_precision),
    case("contacts", "--threads", threads::shows),
    case("contacts", "--json", shows_json),
    case("contacts", "--quiet", shows_quiet),
    case("export", "--format", format),
    case("export", "--out", out),
    case("export", "--last", last),
    case("export", "--cutoff", cutoff_of_vtk),
    case("export", "--threads", threads::shows),
    case("export", "--json", shows_json),
    case("export", "--quiet", shows_quiet),
    case("devices", "--adapter", adapter),
    case("devices", "--json", shows_json),
    case("devices", "--quiet", shows_quiet),
    case("schema", "--sweep", sweep),
    case("schema", "--markdown", markdown),
];

fn set(place: &Place, _: &str) {
    assert_eq!(json(place, "check", &["--set", "time.end=2.4"])["steps"], 120);
    assert_eq!(json(place, "check", &[])["steps"], 60);
    assert!(ran(place, "check", &["--set", "time.dt=-1"]).expect(2).err.contains("time.dt"));
}

/// The rods start at a distance of 0.2.
fn cutoff(place: &Place, _: &str) {
    let pairs = |cutoff: &str| {
        let out = place.relcp(&["contacts", "rods.json", "--json", "--cutoff", cutoff]).expect(0).out;
        serde_json::from_str::<Value>(&out).unwrap()["contacts"].as_array().unwrap().len()
    };
    assert_eq!((pairs("0.19"), pairs("0.21")), (0, 1));
}

fn export(place: &Place, words: &[&str]) -> Value {
    let out = place.relcp(&[&["export", "run", "--json"], words].concat()).expect(0).out;
    serde_json::from_str(&out).unwrap()
}

fn format(place: &Place, _: &str) {
    let formats = [("gsd", "run.gsd"), ("lammps", "run.lammpstrj"), ("vtk", "bodies.pvd"), ("xyz", "run.xyz")];
    for (format, file) in formats {
        let printed = export(place, &["--format", format, "--out", &fresh()]);
        let files = printed["files"].to_string();
        assert!(printed["format"] == format && files.contains(file), "{printed}");
    }
    place.relcp(&["export", "run", "--format", "pdf"]).expect(2);
    place.relcp(&["export", "run"]).expect(2);
}

fn out(place: &Place, _: &str) {
    let out = fresh();
    assert_eq!(export(place, &["--format", "xyz", "--out", &out])["folder"], *out);
    assert!(place.at(&out).is_dir() && !place.at("run/xyz").exists());
    assert_eq!(export(place, &["--format", "xyz"])["folder"], "run/xyz");
    place.relcp(&["export", "rods.json", "--format", "xyz", "--quiet"]).expect(0);
    assert!(place.at("rods-xyz").is_dir());
}

fn last(place: &Place, _: &str) {
    assert_eq!(json(place, "export", &["--last"])["states"], 1);
    assert_eq!(json(place, "export", &[])["states"], 13);
}

fn cutoff_of_vtk(place: &Place, _: &str) {
    let bytes = |cutoff: &str| {
        let printed = export(place, &["--format", "vtk", "--cutoff", cutoff, "--out", &fresh()]);
        printed["bytes"].as_u64().unwrap()
    };
    assert!(bytes("0.0001") < bytes("5"));
    ran(place, "export", &["--cutoff", "1"]).expect(2);
}

fn adapter(place: &Place, _: &str) {
    let none = place.relcp(&["devices", "--adapter", "no-such", "--json"]).expect(5).out;
    let adapters = |text: &str| serde_json::from_str::<Value>(text).unwrap()["adapters"].as_array().unwrap().clone();
    assert!(adapters(&none).iter().all(|adapter| adapter["taken"] == false), "{none}");
    let all = adapters(&place.relcp(&["devices", "--json"]).out);
    // Each is taken where its own name is asked for, if it can be used at all.
    for adapter in all.iter().filter(|adapter| adapter["lacks"].as_array().unwrap().is_empty()) {
        let name = adapter["name"].as_str().unwrap();
        let found = adapters(&place.relcp(&["devices", "--adapter", name, "--json"]).expect(0).out);
        assert!(found.iter().any(|found| found["name"] == name && found["taken"] == true), "{found:?}");
    }
    if all.is_empty() {
        println!("SKIP the choice of an adapter: there is none");
    }
}

fn sweep(place: &Place, _: &str) {
    let has = |words: &[&str], key: &str| {
        let schema: Value = serde_json::from_str(&place.relcp(words).expect(0).out).unwrap();
        schema["properties"][key].is_object()
    };
    assert!(has(&["schema", "--sweep"], "grid") && !has(&["schema"], "grid") && has(&["schema"], "bodies"));
}

fn markdown(place: &Place, _: &str) {
    let page = place.relcp(&["schema", "--markdown"]).expect(0).out;
    assert!(page.starts_with("# The keys of a scene") && page.contains("| **`dt`** |"), "{page}");
    place.relcp(&["schema", "--markdown", "--sweep"]).expect(2);
}
