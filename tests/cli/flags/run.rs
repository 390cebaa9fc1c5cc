//! Flags of `relcp run`, and those of every command.

use super::{Case, EVERY, Place, case, compute, fresh, json, ran, shows_json, shows_quiet, threads};

pub const CASES: &[Case] = &[
    case(EVERY, "--help", help),
    case(EVERY, "--version", version),
    case(EVERY, "--log", log),
    case("run", "--out", out),
    case("run", "--set", set),
    case("run", "--resume", resume),
    case("run", "--until", until),
    case("run", "--from", from),
    case("run", "--checkpoint-every", checkpoint_every),
    case("run", "--max-wall", max_wall),
    case("run", "--view", view),
    case("run", "--live", live),
    case("run", "--port", port),
    case("run", "--profile", profile),
    case("run", "--backend", compute::shows_backend),
    case("run", "--adapter", compute::shows_adapter),
    case("run", "--precision", compute::shows_precision),
    case("run", "--threads", threads::shows),
    case("run", "--json", shows_json),
    case("run", "--quiet", shows_quiet),
];

fn help(place: &Place, _: &str) {
    for arguments in [&["--help"][..], &["run", "--help"], &["render", "--help"]] {
        let help = place.relcp(arguments).expect(0).out;
        assert!(help.contains("Usage: relcp") && help.contains("Options:"), "{help}");
    }
}

fn version(place: &Place, _: &str) {
    assert_eq!(place.relcp(&["--version"]).expect(0).out.trim(), format!("relcp {}", env!("CARGO_PKG_VERSION")));
}

fn log(place: &Place, _: &str) {
    let levels = |level: &str| {
        let err = ran(place, "run", &["--quiet", "--log", level]).expect(0).err;
        ["INFO", "DEBUG", "TRACE"].map(|level| err.contains(level))
    };
    assert_eq!(levels("error"), [false; 3]);
    assert_eq!(levels("warn"), [false; 3]);
    assert_eq!(levels("info"), [true, false, false]);
    assert_eq!(levels("debug"), [true, true, false]);
    assert_eq!(levels("trace"), [true; 3]);
}

fn out(place: &Place, _: &str) {
    let out = fresh();
    let run = ["run", "rods.json", "--set", "time.end=0.02", "--quiet"];
    place.relcp(&[&run[..], &["--out", &out]].concat()).expect(0);
    assert!(place.at(&out).join("summary.json").is_file() && !place.at("runs").exists());
    // A folder that is not empty is refused; without the option the run has a place of its own.
    place.relcp(&[&run[..], &["--out", &out]].concat()).expect(2);
    place.relcp(&run).expect(0);
    place.relcp(&run).expect(0);
    assert!(place.at("runs/rods/summary.json").is_file() && place.at("runs/rods-2/summary.json").is_file());
}

fn set(place: &Place, _: &str) {
    let sets = ["--set", "time.dt=0.01", "--set", "bodies.0.position=[0,0,9]"];
    assert_eq!(json(place, "run", &sets)["steps"], 10);
    assert_eq!(json(place, "run", &[])["steps"], 5);
}

fn resume(place: &Place, _: &str) {
    let out = fresh();
    let run = ["run", "rods.json", "--set", "time.end=0.1", "--quiet", "--out", &out];
    place.relcp(&[&run[..], &["--max-wall", "0"]].concat()).expect(130);
    place.relcp(&["run", "--resume", "--quiet", "--out", &out]).expect(0);
    let resumed = place.json(&format!("{out}/summary.json"));
    assert_eq!(resumed["state_hash"], json(place, "run", &[])["state_hash"]);
}

fn until(place: &Place, _: &str) {
    let out = fresh();
    place.relcp(&["run", "rods.json", "--set", "time.end=0.1", "--quiet", "--out", &out]).expect(0);
    let on = |more: &[&str]| place.relcp(&[&["run", "--resume", "--quiet", "--out", &out], more].concat());
    on(&["--until", "0.2"]).expect(0);
    let extended = place.json(&format!("{out}/summary.json"));
    let whole = json(place, "run", &["--set", "time.end=0.2"]);
    assert_eq!((&extended["state_hash"], &extended["steps"]), (&whole["state_hash"], &whole["steps"]));
    assert_eq!(place.json(&format!("{out}/scene.json"))["time"]["end"], 0.2);
    // It is the run's own end now.
    on(&[]).expect(0);
    assert!(on(&["--until", "0.15"]).expect(2).err.contains("later"));
    place.relcp(&["run", "rods.json", "--until", "1"]).expect(2);
}

/// The last state, or that of a time; with changed keys.
fn from(place: &Place, _: &str) {
    let (first, out) = (fresh(), fresh());
    place.relcp(&["run", "rods.json", "--set", "time.end=0.1", "--quiet", "--out", &first]).expect(0);
    let whole = json(place, "run", &["--set", "time.end=0.2"]);
    let on = |more: &[&str]| place.relcp(&[&["run", "--quiet"], more].concat());
    on(&["--from", &first, "--set", "time.end=0.2", "--out", &out]).expect(0);
    assert_eq!(place.json(&format!("{out}/summary.json"))["state_hash"], whole["state_hash"]);
    let parent = place.json(&format!("{out}/from.json"));
    assert_eq!((&parent["run"], &parent["changed"]), (&first.as_str().into(), &serde_json::json!(["time.end"])));
    // The scene may be named; of a time before the first state there is none.
    let start = format!("{first}@0");
    on(&["rods.json", "--from", &start, "--set", "time.end=0.05", "--out", &fresh()]).expect(0);
    let (early, odd) = (format!("{first}@-1"), format!("{first}@soon"));
    assert!(on(&["--from", &early]).expect(2).err.contains("first state is at time 0"));
    assert!(on(&["--from", &odd]).expect(2).err.contains("not a finite number"));
    let planar = on(&["--from", &first, "--set", "planar=true", "--out", &fresh()]);
    assert!(planar.expect(2).err.contains("planar"));
    on(&["--from", &first, "--resume"]).expect(2);
}

fn checkpoint_every(place: &Place, _: &str) {
    let checkpoints = |more: &[&str]| {
        let err = ran(place, "run", &[more, &["--log", "info"]].concat()).expect(0).err;
        err.lines().filter(|line| line.contains("checkpoint into")).count()
    };
    let (rare, often) = (checkpoints(&[]), checkpoints(&["--checkpoint-every", "0"]));
    // A run has one as it begins and as it ends, and so one after each of its five steps.
    assert!(rare <= 3 && often >= rare + 4, "{rare} {often}");
    ran(place, "run", &["--checkpoint-every", "soon"]).expect(2);
}

fn max_wall(place: &Place, _: &str) {
    let stopped = ran(place, "run", &["--max-wall", "0"]).expect(130);
    assert!(stopped.err.contains("continue with: relcp run --resume"), "{stopped:#?}");
    ran(place, "run", &["--max-wall", "600"]).expect(0);
}

/// The run waits for its page, so that no step is taken.
fn live(place: &Place, command: &str) {
    let waits = ran(place, command, &["--live", "--max-wall", "0.2", "--json"]).expect(130);
    let summary: serde_json::Value = serde_json::from_str(&waits.out).unwrap();
    assert!(summary["steps"] == 0 && waits.err.contains("http://127.0.0.1:"), "{}", waits.err);
}

fn port(place: &Place, command: &str) {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port().to_string();
    let waits = ran(place, command, &["--live", "--port", &free, "--max-wall", "0.2", "--quiet"]).expect(130);
    assert!(waits.err.contains(&format!("http://127.0.0.1:{free}/")), "{}", waits.err);
    for bad in ["0", "65536", "eighty"] {
        ran(place, command, &["--live", "--port", bad]).expect(2);
    }
}

fn view(place: &Place, _: &str) {
    let printed = json(place, "run", &["--view"]);
    assert!(place.at(printed["view"].as_str().unwrap()).is_file());
    assert!(json(place, "run", &[]).get("view").is_none());
}

fn profile(place: &Place, _: &str) {
    let out = ran(place, "run", &["--profile"]).expect(0).out;
    assert!(out.contains("narrow phase ") && out.contains("of memory"), "{out}");
    assert!(!ran(place, "run", &[]).expect(0).out.contains("of memory"));
}
