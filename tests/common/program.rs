//! The program from outside.

use assert_cmd::Command;
use std::path::Path;

/// Runs the program in a folder: what it writes to the two streams, where its exit status is the expected one.
#[track_caller]
pub fn relcp(folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    let output = Command::cargo_bin("relcp").unwrap().current_dir(folder).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {out}{err}");
    (out, err)
}
