//! The real readers, by `tests/readers/check_export.py`.

use crate::scenes::{colony, every_shape, many_rods};
use relcp::export::{Format, Snapshot, States, export};
use relcp::record::write_state;
use relcp::relcp::State;
use std::path::{Path, PathBuf};
use std::process::Command;

fn script() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/check_export.py")
}

/// Exports a run or a state in both formats, and has the readers compare them with it.
fn compare(python: &str, run: &Path) {
    let states = States::open(run.to_str().unwrap()).unwrap();
    let out = tempfile::tempdir().unwrap();
    let gsd = export(&states, Format::Gsd, out.path(), &mut |_, _| true).unwrap().files.remove(0);
    export(&states, Format::Vtk { cutoff: None }, out.path(), &mut |_, _| true).unwrap();
    let mut command = Command::new(python);
    let output = command.arg(script()).arg(run).arg("--gsd").arg(gsd).arg("--vtk").arg(out.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{}", output.status);
    assert!(said.contains("ok   gsd: ") && said.contains("ok   vtk: "));
}

#[test]
fn the_real_readers_draw_the_exact_shapes() {
    let Ok(python) = std::env::var("RELCP_PYTHON") else {
        println!("SKIP the real readers: RELCP_PYTHON does not name a Python with gsd and vtk");
        return;
    };
    let place = tempfile::tempdir().unwrap();
    for (name, Snapshot { step, time, bodies, .. }) in [("shapes", every_shape()), ("rods", many_rods(2000))] {
        let path = place.path().join(format!("{name}.npz"));
        write_state(&path, &State { step, next_id: 0, bodies, warm: Vec::new() }, "x", time, None).unwrap();
        compare(&python, &path);
    }
    compare(&python, colony(place.path()).path());
}
