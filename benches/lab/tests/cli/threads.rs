//! `--threads`: how many threads the program has while it waits for a file.

use super::flags::ran;
use super::place::{Place, fresh};
use super::waiting::settled;
use std::process::{Command, Stdio};

fn threads(place: &Place, number: usize) -> usize {
    let (pipe, out) = (fresh(), fresh());
    assert!(Command::new("mkfifo").arg(place.at(&pipe)).status().unwrap().success());
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("relcp-lab"))
        .current_dir(&place.0)
        .args(["solvers", &pipe, "--backend", "cpu", "--out", &out, "--threads", &number.to_string()])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let found = settled(&child, number + 1);
    child.kill().unwrap();
    child.wait().unwrap();
    found
}

pub fn shows(place: &Place) {
    for bad in ["0", "1025", "x"] {
        ran(place, &["--threads", bad]).expect(2);
    }
    if !cfg!(target_os = "linux") {
        println!("SKIP the number of threads: this system does not tell it in /proc");
        return;
    }
    assert_eq!(threads(place, 5) - threads(place, 2), 3);
}
