//! Every flag has a test of what its help says. One more test checks that the list of flags is complete.

use super::place::{Place, fresh};
use super::ran::Ran;
use super::waiting::comes;
use super::{compute, threads};
use relcp::Scene;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// A flag, and what shows that it does what its help says.
type Case = (&'static str, fn(&Place));

const CASES: &[Case] = &[
    ("--largest", largest),
    ("--smallest", smallest),
    ("--of", of),
    ("--sizes", sizes_of_a_device),
    ("--minutes", minutes),
    ("--steps", steps),
    ("--warm-up", warm_up),
    ("--make-references", make_references),
    ("--random", random),
    ("--confined", confined),
    ("--pressed", pressed),
    ("--friction", friction),
    ("--keys", keys),
    ("--first", first),
    ("--chambers", chambers),
    ("--stall", stall),
    ("--lines", lines),
    ("--seed", seed),
    ("--quick", quick),
    ("--out", out),
    ("--figures", figures),
    ("--backend", compute::shows_backend),
    ("--adapter", compute::shows_adapter),
    ("--precision", compute::shows_precision),
    ("--threads", threads::shows),
    ("--json", shows_json),
    ("--quiet", shows_quiet),
    ("--log", log),
    ("--help", help),
    ("--version", version),
];

/// The flags that a help lists; of descriptions and examples nothing.
fn flags(help: &str) -> BTreeSet<String> {
    let lines = help.lines().take_while(|line| *line != "Examples:");
    let near = lines.filter(|line| line.len() - line.trim_start().len() <= 6);
    let options = near.filter(|line| line.trim_start().starts_with('-'));
    options
        .filter_map(|line| line.split([' ', ',', '[']).find(|word| word.starts_with("--")).map(str::to_owned))
        .collect()
}

#[test]
fn every_flag_has_a_case_and_every_case_a_flag() {
    let found = flags(&Place::new().lab(&["--help"]).expect(0).out);
    let cases: BTreeSet<String> = CASES.iter().map(|(flag, _)| (*flag).to_owned()).collect();
    assert_eq!(cases.len(), CASES.len(), "a flag has two cases");
    assert_eq!(found, cases);
}

#[test]
fn flags_do_what_their_help_says() {
    let place = Place::new();
    for (flag, shows) in CASES {
        println!("relcp-lab {flag}");
        shows(&place);
    }
}

/// What a study that takes moments says with more words: of so many bodies as no size has, a table without rows.
pub fn ran(place: &Place, more: &[&str]) -> Ran {
    let out = fresh();
    let words = ["throughput", "--of", "colony", "--largest", "100", "--backend", "cpu", "--out", &out];
    place.lab(&[&words[..], more].concat())
}

/// `--json`: one document, and nothing else.
fn shows_json(place: &Place) {
    let plain = ran(place, &[]);
    assert!(serde_json::from_str::<Value>(&plain.out).is_err(), "{plain:#?}");
    let json = ran(place, &["--json"]);
    assert!(serde_json::from_str::<Value>(&json.out).is_ok(), "{json:#?}");
}

/// `--quiet` prints neither progress nor a summary. It prints errors.
fn shows_quiet(place: &Place) {
    assert!(!ran(place, &[]).out.is_empty());
    let quiet = ran(place, &["--quiet"]);
    assert_eq!((&*quiet.out, &*quiet.err), ("", ""));
    let fault = ran(place, &["--quiet", "--no-such-flag"]).expect(2);
    assert!(fault.err.contains("--no-such-flag"), "{fault:#?}");
}

/// `--log`: lines of the library on standard error.
fn log(place: &Place) {
    let lines = |more: &[&str]| {
        let words = ["throughput", "--of", "colony", "--largest", "1024", "--steps", "1", "--warm-up", "0"];
        let out = fresh();
        let ran = place.lab(&[&words[..], &["--backend", "cpu", "--quiet", "--out", &out], more].concat());
        ran.err.lines().count()
    };
    assert!(lines(&[]) == 0 && lines(&["--log", "trace"]) > 0);
    ran(place, &["--log", "loud"]).expect(2);
}

fn help(place: &Place) {
    let help = place.lab(&["--help"]).expect(0).out;
    assert!(help.contains("Usage: relcp-lab") && help.contains("Options:"), "{help}");
}

fn version(place: &Place) {
    let version = format!("relcp-lab {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.lab(&["--version"]).expect(0).out.trim(), version);
}

fn study(place: &Place, words: &str) -> (Value, String) {
    let out = fresh();
    let line = format!("{words} --backend cpu --json --quiet --out {out}");
    let ran = place.lab(&line.split(' ').collect::<Vec<_>>());
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

fn largest(place: &Place) {
    assert_eq!(sizes(&throughput(place).0), [1024]);
    assert!(sizes(&study(place, "throughput --of colony --largest 1023").0).is_empty());
}

fn smallest(place: &Place) {
    assert!(sizes(&study(place, "throughput --smallest 1025 --largest 1025").0).is_empty());
}

/// A compaction has a size of 1,000 bodies, and would be there.
fn of(place: &Place) {
    assert_eq!(throughput(place).0[0]["kind"], "colony");
    assert!(sizes(&study(place, "throughput --of colony --largest 1000").0).is_empty());
    ran(place, &["--of", "rods"]).expect(2);
}

/// A study of a device that has no time for anything: what it would measure.
fn device(place: &Place, more: &str) -> Option<(Value, String)> {
    let out = fresh();
    let line = format!("device --quick --quiet --json --minutes 1e-9 --out {out} {more}");
    let ran = place.lab(&line.split_whitespace().collect::<Vec<_>>());
    if ran.status == Some(5) {
        assert!(std::env::var_os("RELCP_REQUIRE_GPU").is_none(), "a GPU is required: {ran:#?}");
        // Not captured by the test harness.
        let _ = writeln!(std::io::stderr(), "SKIP relcp-lab device: there is no adapter");
        return None;
    }
    assert_eq!(ran.status, Some(0), "{ran:#?}");
    Some((serde_json::from_str(&ran.out).unwrap(), out))
}

fn sizes_of_a_device(place: &Place) {
    ran(place, &["--sizes", "24"]).expect(2);
    place.lab(&["device", "--sizes", "0"]).expect(2);
    let Some((numbers, _)) = device(place, "--sizes 96,24 --precision f32") else { return };
    let speeds = numbers["skipped"].as_object().unwrap().keys().filter(|name| name.starts_with("speed/colony/"));
    assert_eq!(speeds.collect::<Vec<_>>(), ["speed/colony/24/f32", "speed/colony/96/f32"]);
}

/// Without time the study measures nothing and lists what it skipped. It keeps damaged results.
fn minutes(place: &Place) {
    place.lab(&["device", "--minutes", "0"]).expect(2);
    place.lab(&["device", "--backend", "cpu"]).expect(2);
    let Some((numbers, out)) = device(place, "") else { return };
    assert!(numbers["items"].as_object().unwrap().is_empty(), "{numbers}");
    assert!(numbers["skipped"]["bandwidth"].as_str().unwrap().contains("no time"), "{numbers}");
    assert!(std::fs::read_to_string(place.at(&out).join("report.md")).unwrap().contains("was left out: no time"));
    let file = place.at(&out).join("report.json");
    std::fs::write(&file, "{").unwrap();
    let err = place.lab(&["device", "--quiet", "--minutes", "1e-9", "--out", &out]).expect(4).err;
    assert!(err.contains("damaged") && err.contains("report.json"), "{err}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "{");
}

fn steps(place: &Place) {
    let (rows, page) = throughput(place);
    assert!(rows[0]["steps"] == 1 && page.contains("1 steps timed after 0"), "{page}");
    ran(place, &["--steps", "0"]).expect(2);
}

fn warm_up(place: &Place) {
    assert!(throughput(place).1.contains("timed after 0"));
    let page = ran(place, &["--warm-up", "3"]).expect(0).out;
    assert!(page.contains("5 steps timed after 3"), "{page}");
}

/// Minutes in all: the first of them is waited for.
fn make_references(place: &Place) {
    let out = fresh();
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("relcp-lab"))
        .current_dir(&place.0)
        .args(["work-precision", "--quiet", "--make-references", &out])
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

fn random(place: &Place) {
    let (rows, _) = study(place, "hard --random 3 --quick");
    assert_eq!(names(&rows).len(), 3, "{rows}");
    assert!(ran(place, &["--random", "3"]).expect(2).err.contains("relcp-lab hard"));
}

fn confined(place: &Place) {
    let (rows, _) = study(place, "hard --confined 1 --quick");
    assert!(matches!(names(&rows)[..], [name] if name.starts_with("confined-1")), "{rows}");
}

fn pressed(place: &Place) {
    let (rows, _) = study(place, "hard --pressed 2 --quick");
    assert!(matches!(names(&rows)[..], [_, name] if name.starts_with("pressed-1")), "{rows}");
}

/// What drawn scenes are, for people.
fn what(place: &Place, more: &str) -> Vec<String> {
    let (rows, _) = study(place, &format!("hard --random 2 --quick{more}"));
    let rows = rows["rows"].as_array().unwrap().clone();
    rows.iter().map(|row| row["what"].as_str().unwrap().to_owned()).collect()
}

/// The scenes say their coefficient. They are those that are drawn without it.
fn friction(place: &Place) {
    for (plain, rough) in what(place, "").iter().zip(&what(place, " --friction")) {
        assert!(rough.starts_with(plain.as_str()) && rough.contains(", friction ") && !plain.contains("friction"));
    }
    ran(place, &["--friction"]).expect(2);
    place.lab(&["hard", "--friction"]).expect(2);
}

/// The scenes say their keys. They are those that are drawn without them.
fn keys(place: &Place) {
    for (plain, keyed) in what(place, "").iter().zip(&what(place, " --keys")) {
        let more = keyed.strip_prefix(plain.as_str()).and_then(|more| more.strip_prefix(", with "));
        assert!(more.is_some_and(|more| !more.is_empty()), "{plain} | {keyed}");
    }
    place.lab(&["hard", "--keys"]).expect(2);
}

/// A scene is the same whatever is drawn before it, and the page draws it again.
fn first(place: &Place) {
    let (later, out) = study(place, "hard --random 1 --quick --first 1");
    assert_eq!(names(&later), ["random-1-1"]);
    let both = study(place, "hard --random 2 --quick").0;
    assert_eq!(later["rows"][0], both["rows"][1]);
    let page = fs::read_to_string(place.at(&out).join("drawn.md")).unwrap();
    assert!(page.contains("hard --random 1 --seed 1 --first 1 --quick`"), "{page}");
    place.lab(&["hard", "--first", "1"]).expect(2);
}

fn chambers(place: &Place) {
    let (rows, out) = study(place, "hard --chambers 2 --quick");
    assert!(rows["rows"][1]["steps"] == 20 && rows["stalls"] == false, "{rows}");
    assert!(place.at(&out).join("chambers.csv").is_file());
    ran(place, &["--chambers", "3"]).expect(2);
    place.lab(&["hard", "--chambers", "3", "--random", "3"]).expect(2);
}

fn stall(place: &Place) {
    assert_eq!(study(place, "hard --chambers 1 --stall --quick").0["stalls"], true);
    place.lab(&["hard", "--stall"]).expect(2);
}

fn lines(place: &Place) {
    let (rows, _) = study(place, "hard --lines --quick");
    assert_eq!(rows["rows"].as_array().unwrap().len(), 128);
    ran(place, &["--lines"]).expect(2);
}

fn seed(place: &Place) {
    let drawn = |seed: &str| {
        let rows = study(place, &format!("hard --random 2 --quick --seed {seed}")).0;
        assert_eq!(rows["seed"].to_string(), seed);
        rows["rows"].to_string()
    };
    assert!(drawn("4") != drawn("5"));
}

fn quick(place: &Place) {
    let sets = ["solver.dump.when=all", "solver.dump.most=1"];
    place.run(Scene::load("three-capsules", sets).unwrap(), "lcps");
    let (quick, full) = (study(place, "solvers lcps --quick").0, study(place, "solvers lcps").0);
    assert!(quick["size"] != full["size"], "{quick}");
}

fn out(place: &Place) {
    let words = ["throughput", "--largest", "1", "--backend", "cpu", "--quiet"];
    let out = fresh();
    place.lab(&[&words[..], &["--out", &out]].concat()).expect(0);
    assert!(place.at(&out).join("throughput.md").is_file() && !place.at("studies").exists());
    place.lab(&words).expect(0);
    assert!(place.at("studies/throughput.md").is_file());
}

/// How the files of each format begin.
const HEADS: [(&str, &[u8]); 3] = [("svg", b"<svg"), ("pdf", b"%PDF-"), ("png", b"\x89PNG")];

fn figures(place: &Place) {
    for (more, formats) in [(" --figures pdf,png", &["pdf", "png"][..]), ("", &["svg"])] {
        let (_, out) = study(place, &format!("jitter --quick{more}"));
        for (format, head) in HEADS {
            let files = std::fs::read_dir(place.at(&out)).unwrap().map(|file| file.unwrap().path());
            let own: Vec<_> = files.filter(|path| path.extension().is_some_and(|ending| ending == format)).collect();
            assert_eq!(own.is_empty(), !formats.contains(&format), "{format}: {own:?}");
            assert!(own.iter().all(|path| std::fs::read(path).unwrap().starts_with(head)), "{own:?}");
        }
    }
    ran(place, &["--figures", "jpeg"]).expect(2);
}
