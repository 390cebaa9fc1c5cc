//! Flags of `relcp measure`.

use super::{Case, Place, case, fresh, json, ran, shows_json, shows_quiet, threads};
use serde_json::Value;

pub const CASES: &[Case] = &[
    case("measure", "--only", only),
    case("measure", "--last", last),
    case("measure", "--out", out),
    case("measure", "--figures", figures),
    case("measure", "--bin", bin),
    case("measure", "--neighbourhood", neighbourhood),
    case("measure", "--domain-angle", domain_angle),
    case("measure", "--cutoff", cutoff),
    case("measure", "--seed", seed),
    case("measure", "--threads", threads::shows),
    case("measure", "--json", shows_json),
    case("measure", "--quiet", shows_quiet),
];

/// A value of the last state.
fn value(place: &Place, name: &str, more: &[&str]) -> Value {
    json(place, "measure", &[&["--last"], more].concat())["states"][0]["values"][name].clone()
}

fn only(place: &Place, _: &str) {
    let names = |more: &[&str]| -> Vec<Value> {
        let printed = json(place, "measure", more);
        printed["measures"].as_array().unwrap().iter().map(|measure| measure["name"].clone()).collect()
    };
    assert_eq!(names(&["--only", "nematic,radius"]), ["nematic", "radius"]);
    assert_eq!(names(&["--only", "nematic", "--only", "radius"]), ["nematic", "radius"]);
    // Those that the help names, and no others.
    let help = place.relcp(&["measure", "--help"]).expect(0).out.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, list) = help.split_once("by commas or by repeating the option: ").unwrap();
    let list: Vec<&str> = list.split(' ').take(names(&[]).len()).map(|name| name.trim_matches(',')).collect();
    assert_eq!(names(&[]), list);
    ran(place, "measure", &["--only", "weight"]).expect(2);
}

fn last(place: &Place, _: &str) {
    let steps = |more: &[&str]| {
        let printed = json(place, "measure", more);
        let states = printed["states"].as_array().unwrap();
        (states.len(), states.last().unwrap()["step"].clone())
    };
    assert_eq!((steps(&["--last"]), steps(&[])), ((1, 60.into()), (13, 60.into())));
}

fn out(place: &Place, _: &str) {
    let out = fresh();
    place.relcp(&["measure", "run", "--quiet", "--out", &out]).expect(0);
    assert!(place.at(&out).join("measures.csv").is_file() && !place.at("run/measures").exists());
    place.relcp(&["measure", "run", "--quiet"]).expect(0);
    place.relcp(&["measure", "rods.json", "--quiet"]).expect(0);
    assert!(place.at("run/measures/measures.csv").is_file() && place.at("rods-measures").is_dir());
}

/// The first bytes of a file of each format.
pub const HEADS: [(&str, &[u8]); 3] = [("svg", b"<svg "), ("pdf", b"%PDF-"), ("png", b"\x89PNG")];

/// Checks that a folder has figures in these formats, each what its name says, and in no other.
pub fn check_figures(folder: &std::path::Path, formats: &[&str]) {
    for (format, head) in HEADS {
        let files = std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
        let own: Vec<_> = files.filter(|path| path.extension().is_some_and(|ending| ending == format)).collect();
        assert_eq!(own.is_empty(), !formats.contains(&format), "{format}: {own:?}");
        assert!(own.iter().all(|path| std::fs::read(path).unwrap().starts_with(head)), "{own:?}");
    }
}

fn figures(place: &Place, _: &str) {
    for formats in ["svg,pdf,png", "pdf"] {
        let out = fresh();
        place.relcp(&["measure", "run", "--quiet", "--out", &out, "--figures", formats]).expect(0);
        check_figures(&place.at(&out), &formats.split(',').collect::<Vec<_>>());
    }
    ran(place, "measure", &["--figures", "jpeg"]).expect(2);
}

fn bin(place: &Place, _: &str) {
    assert_eq!(value(place, "correlation_bin", &["--bin", "0.25"]), 0.25);
    // The rods are 1 thick.
    assert_eq!(value(place, "correlation_bin", &[]), 1.0);
    ran(place, "measure", &["--bin", "0"]).expect(2);
}

fn neighbourhood(place: &Place, _: &str) {
    assert_eq!(value(place, "nematic_local_neighbours", &["--neighbourhood", "0.1"]), 0.0);
    assert_eq!(value(place, "nematic_local_neighbours", &["--neighbourhood", "9"]), 1.0);
    // The rods are 3 long.
    assert_eq!(value(place, "nematic_local_radius", &[]), 3.0);
}

/// The rods cross.
fn domain_angle(place: &Place, _: &str) {
    assert_eq!(value(place, "domain_largest", &["--domain-angle", "1"]), 1.0);
    assert_eq!(value(place, "domain_largest", &["--domain-angle", "91"]), 2.0);
}

fn cutoff(place: &Place, _: &str) {
    // The last state's separation is below a millionth, that of the first 0.2.
    let first = |cutoff: &str| {
        json(place, "measure", &["--cutoff", cutoff])["states"][0]["values"]["touching_per_body"].clone()
    };
    assert_eq!((first("0.19"), first("0.21")), (0.0.into(), 1.0.into()));
}

/// Small states are not sampled: the seed is kept, and does not matter.
fn seed(place: &Place, _: &str) {
    let (one, two) = (json(place, "measure", &["--seed", "7"]), json(place, "measure", &[]));
    assert_eq!((&one["settings"]["seed"], &two["settings"]["seed"]), (&7.into(), &1.into()));
    assert_eq!(one["states"], two["states"]);
}
