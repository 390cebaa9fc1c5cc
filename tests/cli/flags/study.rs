//! Flags of `relcp study`.

use super::{Case, Place, case, comes, compute, fresh, ran, shows_json, shows_quiet, threads};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

pub const CASES: &[Case] = &[
    case("study", "--largest", largest),
    case("study", "--smallest", smallest),
    case("study", "--of", of),
    case("study", "--sizes", sizes_of_a_device),
    case("study", "--minutes", minutes),
    case("study", "--steps", steps),
    case("study", "--warm-up", warm_up),
    case("study", "--make-references", make_references),
    case("study", "--random", random),
    case("study", "--confined", confined),
    case("study", "--pressed", pressed),
    case("study", "--chambers", chambers),
    case("study", "--stall", stall),
    case("study", "--lines", lines),
    case("study", "--seed", seed),
    case("study", "--quick", quick),
    case("study", "--out", out),
    case("study", "--figures", figures),
    case("study", "--backend", compute::shows_backend),
    case("study", "--adapter", compute::shows_adapter),
    case("study", "--precision", compute::shows_precision),
    case("study", "--threads", threads::shows),
    case("study", "--json", shows_json),
    case("study", "--quiet", shows_quiet),
];

fn study(place: &Place, words: &str) -> (Value, String) {
    let out = fresh();
    let line = format!("study {words} --backend cpu --json --quiet --out {out}");
    let ran = place.relcp(&line.split(' ').collect::<Vec<_>>());
    assert!(matches!(ran.status, Some(0 | 3)), "{ran:#?}");
    (serde_json::from_str(&ran.out).unwrap(), out)
}

/// One size of throughput, measured once: the table, and the page.
fn throughput(place: &Place) -> &'static (Value, String) {
    static MEASURED: OnceLock<(Value, String)> = OnceLock::new();
    MEASURED.get_or_init(|| {
        let (rows, out) = study(place, "throughput --of colony --largest 1024 --steps 1 --warm-up 0");
        (rows, std::fs::read_to_string(place.at(&out).join("throughput.md")).unwrap())
    })
}

fn sizes(rows: &Value) -> Vec<u64> {
    rows.as_array().unwrap().iter().map(|row| row["bodies"].as_u64().unwrap()).collect()
}

fn largest(place: &Place, _: &str) {
    assert_eq!(sizes(&throughput(place).0), [1024]);
    assert!(sizes(&study(place, "throughput --of colony --largest 1023").0).is_empty());
}

fn smallest(place: &Place, _: &str) {
    assert!(sizes(&study(place, "throughput --smallest 1025 --largest 1025").0).is_empty());
}

/// A compaction has a size of 1,000 bodies, and would be there.
fn of(place: &Place, _: &str) {
    assert_eq!(throughput(place).0[0]["kind"], "colony");
    assert!(sizes(&study(place, "throughput --of colony --largest 1000").0).is_empty());
    ran(place, "study", &["--of", "rods"]).expect(2);
}

/// A study of a device that has no time for anything: what it would measure.
fn device(place: &Place, more: &str) -> Option<(Value, String)> {
    let out = fresh();
    let line = format!("study device --quick --quiet --json --minutes 1e-9 --out {out} {more}");
    let ran = place.relcp(&line.split_whitespace().collect::<Vec<_>>());
    if ran.status == Some(5) {
        println!("SKIP relcp study device: there is no adapter");
        return None;
    }
    assert_eq!(ran.status, Some(0), "{ran:#?}");
    Some((serde_json::from_str(&ran.out).unwrap(), out))
}

fn sizes_of_a_device(place: &Place, _: &str) {
    ran(place, "study", &["--sizes", "24"]).expect(2);
    place.relcp(&["study", "device", "--sizes", "0"]).expect(2);
    let Some((numbers, _)) = device(place, "--sizes 96,24 --precision f32") else { return };
    let speeds = numbers["skipped"].as_object().unwrap().keys().filter(|name| name.starts_with("speed/colony/"));
    assert_eq!(speeds.collect::<Vec<_>>(), ["speed/colony/24/f32", "speed/colony/96/f32"]);
}

/// Without time nothing is measured and all is told; the results stay where they are damaged.
fn minutes(place: &Place, _: &str) {
    place.relcp(&["study", "device", "--minutes", "0"]).expect(2);
    place.relcp(&["study", "device", "--backend", "cpu"]).expect(2);
    let Some((numbers, out)) = device(place, "") else { return };
    assert!(numbers["items"].as_object().unwrap().is_empty(), "{numbers}");
    assert!(numbers["skipped"]["bandwidth"].as_str().unwrap().contains("no time"), "{numbers}");
    assert!(std::fs::read_to_string(place.at(&out).join("report.md")).unwrap().contains("was left out: no time"));
    let file = place.at(&out).join("report.json");
    std::fs::write(&file, "{").unwrap();
    let err = place.relcp(&["study", "device", "--quiet", "--minutes", "1e-9", "--out", &out]).expect(4).err;
    assert!(err.contains("damaged") && err.contains("report.json"), "{err}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "{");
}

fn steps(place: &Place, _: &str) {
    let (rows, page) = throughput(place);
    assert!(rows[0]["steps"] == 1 && page.contains("1 steps timed after 0"), "{page}");
    ran(place, "study", &["--steps", "0"]).expect(2);
}

fn warm_up(place: &Place, _: &str) {
    assert!(throughput(place).1.contains("timed after 0"));
    let page = ran(place, "study", &["--warm-up", "3"]).expect(0).out;
    assert!(page.contains("5 steps timed after 3"), "{page}");
}

/// Minutes in all: the first of them is waited for.
fn make_references(place: &Place, _: &str) {
    let out = fresh();
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("relcp"))
        .current_dir(&place.0)
        .args(["study", "work-precision", "--quiet", "--make-references", &out])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let made = || {
        place.at(&out).read_dir().is_ok_and(|mut files| {
            files
                .any(|file| file.is_ok_and(|file| file.path().extension().is_some_and(|extension| extension == "json")))
        })
    };
    let made = comes(made);
    child.kill().unwrap();
    child.wait().unwrap();
    // In place of the study.
    assert!(made && !place.at("studies").exists());
}

fn names(rows: &Value) -> Vec<&str> {
    rows["rows"].as_array().unwrap().iter().map(|row| row["name"].as_str().unwrap()).collect()
}

fn random(place: &Place, _: &str) {
    let (rows, _) = study(place, "hard --random 3 --quick");
    assert_eq!(names(&rows).len(), 3, "{rows}");
    assert!(ran(place, "study", &["--random", "3"]).expect(2).err.contains("relcp study hard"));
}

fn confined(place: &Place, _: &str) {
    let (rows, _) = study(place, "hard --confined 1 --quick");
    assert!(matches!(names(&rows)[..], [name] if name.starts_with("confined-1")), "{rows}");
}

fn pressed(place: &Place, _: &str) {
    let (rows, _) = study(place, "hard --pressed 2 --quick");
    assert!(matches!(names(&rows)[..], [_, name] if name.starts_with("pressed-1")), "{rows}");
}

fn chambers(place: &Place, _: &str) {
    let (rows, out) = study(place, "hard --chambers 2 --quick");
    assert!(rows["rows"][1]["steps"] == 20 && rows["stalls"] == false, "{rows}");
    assert!(place.at(&out).join("chambers.csv").is_file());
    ran(place, "study", &["--chambers", "3"]).expect(2);
    place.relcp(&["study", "hard", "--chambers", "3", "--random", "3"]).expect(2);
}

fn stall(place: &Place, _: &str) {
    assert_eq!(study(place, "hard --chambers 1 --stall --quick").0["stalls"], true);
    place.relcp(&["study", "hard", "--stall"]).expect(2);
}

fn lines(place: &Place, _: &str) {
    let (rows, _) = study(place, "hard --lines --quick");
    assert_eq!(rows["rows"].as_array().unwrap().len(), 128);
    ran(place, "study", &["--lines"]).expect(2);
}

fn seed(place: &Place, _: &str) {
    let drawn = |seed: &str| {
        let rows = study(place, &format!("hard --random 2 --quick --seed {seed}")).0;
        assert_eq!(rows["seed"].to_string(), seed);
        rows["rows"].to_string()
    };
    assert!(drawn("4") != drawn("5"));
}

fn quick(place: &Place, _: &str) {
    let run = "run three-capsules --backend cpu --quiet --set solver.dump.when=all --set solver.dump.most=1 --out lcps";
    place.relcp(&run.split(' ').collect::<Vec<_>>()).expect(0);
    let (quick, full) = (study(place, "solvers lcps --quick").0, study(place, "solvers lcps").0);
    assert!(quick["size"] != full["size"], "{quick}");
}

fn out(place: &Place, _: &str) {
    let words = ["study", "throughput", "--largest", "1", "--backend", "cpu", "--quiet"];
    let out = fresh();
    place.relcp(&[&words[..], &["--out", &out]].concat()).expect(0);
    assert!(place.at(&out).join("throughput.md").is_file() && !place.at("studies").exists());
    place.relcp(&words).expect(0);
    assert!(place.at("studies/throughput.md").is_file());
}

fn figures(place: &Place, _: &str) {
    let (_, out) = study(place, "jitter --quick --figures pdf,png");
    super::measure::check_figures(&place.at(&out), &["pdf", "png"]);
    let (_, out) = study(place, "jitter --quick");
    super::measure::check_figures(&place.at(&out), &["svg"]);
    ran(place, "study", &["--figures", "jpeg"]).expect(2);
}
