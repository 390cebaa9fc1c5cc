//! `--threads` of every command: how many threads the program has while it waits for a file.

use super::{Place, fresh};
use crate::waiting::settled;
use std::process::{Command, Stdio};

/// Words of a command that waits for what it reads: for the standard input, or for a pipe of this name.
fn waiting(command: &str, pipe: &str) -> String {
    match command {
        "run" => format!("run - --backend cpu --out {}", fresh()),
        "batch" => format!("batch {pipe}"),
        "export" => "export - --format xyz".into(),
        "render" => "render - --backend cpu".into(),
        other => format!("{other} -"),
    }
}

fn threads(place: &Place, command: &str, number: usize) -> usize {
    let pipe = fresh();
    assert!(Command::new("mkfifo").arg(place.at(&pipe)).status().unwrap().success());
    let mut child = Command::new(assert_cmd::cargo::cargo_bin("relcp"))
        .current_dir(&place.0)
        .args(waiting(command, &pipe).split(' '))
        .args(["--threads", &number.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let found = settled(&child, number + 1);
    child.kill().unwrap();
    child.wait().unwrap();
    found
}

pub fn shows(place: &Place, command: &str) {
    for bad in ["0", "1025", "x"] {
        super::ran(place, command, &["--threads", bad]).expect(2);
    }
    if !cfg!(target_os = "linux") {
        println!("SKIP the number of threads: this system does not tell it in /proc");
        return;
    }
    assert_eq!(threads(place, command, 5) - threads(place, command, 2), 3);
}
