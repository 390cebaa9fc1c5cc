//! Names that would lead out of a run's folder, and places that cannot be written to.

use relcp::Scene;
use relcp::batch::{BatchError, Plan};
use relcp::record::Folder;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const HOSTILE: [&str; 16] = [
    "..",
    ".",
    "...",
    "../x",
    "../../etc",
    "/etc",
    "/",
    "a/../../b",
    "a\0b",
    "..\\x",
    "\u{1}",
    "~",
    "-rf",
    "a b",
    "\u{202e}x",
    "..-",
];

fn relcp(folder: &Path, script: &str) -> Output {
    let program = assert_cmd::cargo::cargo_bin("relcp");
    Command::new("sh").current_dir(folder).args(["-c", script]).arg(program).output().unwrap()
}

#[track_caller]
fn ended(ran: &Output, status: i32, says: &str) {
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(status), "{err}");
    assert!(err.contains(says) && !err.contains("panicked"), "{err}");
}

/// A folder with the scene of two rods in it.
fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("rods.json"), include_str!("../data/rods.json")).unwrap();
    place
}

#[test]
fn names_do_not_lead_out_of_the_folder_of_runs() {
    let parent = tempfile::tempdir().unwrap();
    for name in HOSTILE.iter().copied().chain([&*"x".repeat(10_000)]) {
        let folder = Folder::create_in(parent.path(), name).unwrap();
        assert_eq!(folder.path().parent(), Some(parent.path()), "{name}");
        assert!(fs::canonicalize(folder.path()).unwrap().parent() == Some(&fs::canonicalize(&parent).unwrap()));
        let quoted = serde_json::to_string(name).unwrap();
        let text = include_str!("../data/rods.json").replacen("\"rods\"", &quoted, 1);
        let leads_out = matches!(name, "." | "..")
            || name.contains(['/', '\\'])
            || name.contains(char::is_control)
            || name.len() > 128;
        assert_eq!(Scene::parse(&text, "named.json").is_err(), leads_out, "{name}");
        let sweep = format!(r#"{{ "name": {quoted}, "scene": "colony", "seeds": [1] }}"#);
        match Plan::parse(&sweep, "sweep.json", Path::new(".")) {
            Ok(plan) => assert_eq!(plan.folder_in(Path::new("runs")).components().count(), 2, "{name}"),
            Err(error) => assert!(matches!(error, BatchError::Scene(_)) && (leads_out || name == "..."), "{name}"),
        }
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_after_a_line_ends_no_command_with_a_panic() {
    let place = place();
    for command in [
        "run rods.json --json --out run",
        "run rods.json --json",
        "scenes colony",
        "schema",
        "contacts rods.json --cutoff 9 --json",
    ] {
        let script = format!("{{ \"$0\" {command}; echo $? >status; }} | head -1");
        let ran = relcp(place.path(), &script);
        ended(&ran, 0, "");
        assert_eq!(String::from_utf8_lossy(&ran.stdout).lines().count(), 1, "{command}");
        assert_eq!(fs::read_to_string(place.path().join("status")).unwrap(), "0\n", "{command}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_is_full_is_status_4() {
    let place = place();
    for command in
        ["scenes", "scenes --json", "schema", "devices", "contacts rods.json --json", "run rods.json --json --quiet"]
    {
        ended(&relcp(place.path(), &format!("\"$0\" {command} >/dev/full")), 4, "could not write to standard output");
    }
}

/// Below a file, and where the system makes no folder for anyone.
#[cfg(target_os = "linux")]
#[test]
fn folders_that_cannot_be_made_are_status_4_with_their_path() {
    let place = place();
    fs::write(place.path().join("sweep.json"), r#"{ "name": "s", "scene": "rods.json", "seeds": [1] }"#).unwrap();
    ended(&relcp(place.path(), "\"$0\" run rods.json --out run --quiet"), 0, "");
    // Where `/sys` is not mounted it is a folder as any other.
    let sys = std::path::Path::new("/sys/kernel").exists().then_some("/sys/relcp");
    for out in ["rods.json/out", "/proc/relcp/out"].into_iter().chain(sys) {
        for command in [
            "run rods.json",
            "batch sweep.json",
            "export run --format vtk",
            "export run --format gsd",
            "measure run",
            "render run --no-movie",
        ] {
            ended(&relcp(place.path(), &format!("\"$0\" {command} --out {out}")), 4, out);
        }
    }
    ended(&relcp(place.path(), "cd /proc && \"$0\" run three-capsules"), 4, "runs");
}

/// The rows of a run are appended to its file in place: through a link to a device that is full they cannot be.
#[cfg(target_os = "linux")]
#[test]
fn rows_that_cannot_be_written_are_status_4() {
    let place = place();
    ended(&relcp(place.path(), "\"$0\" run rods.json --out run --quiet"), 0, "");
    let rows = place.path().join("run/steps.csv");
    fs::remove_file(&rows).unwrap();
    std::os::unix::fs::symlink("/dev/full", &rows).unwrap();
    ended(&relcp(place.path(), "\"$0\" run --resume --out run --quiet"), 4, "run/steps.csv");
}

/// A file system of 48 kB, where one may be mounted; elsewhere the test of a file-size limit stands alone.
#[cfg(target_os = "linux")]
#[test]
fn a_file_system_that_fills_up_is_status_4_and_leaves_no_half_file() {
    let place = place();
    fs::create_dir(place.path().join("small")).unwrap();
    let mounted = "mount -t tmpfs -o size=48k none small 2>/dev/null || exit 77; ";
    let run = "\"$0\" run rods.json --out small/run; status=$?; ls -a small/run small/run/states; exit $status";
    let ran = relcp(place.path(), &format!("exec unshare -rm sh -c '{mounted}{run}' \"$0\""));
    if matches!(ran.status.code(), Some(77 | 1 | 127)) {
        eprintln!("no file system can be mounted here: {}", String::from_utf8_lossy(&ran.stderr));
        return;
    }
    ended(&ran, 4, "small/run/");
    let left = String::from_utf8_lossy(&ran.stdout);
    assert!(!left.contains(".part") && !left.contains("summary.json"), "{left}");
}
