//! The real readers, by `tests/readers/check_export.py`.

use crate::scenes::{colony, every_shape, large, many_rods};
use crate::superellipsoids;
use relcp::export::{Format, export};
use relcp::record::{Snapshot, States, write_state};
use relcp::step::State;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

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

/// Exports 131,072 rods, each of its own length, and says how long it takes; the readers are asked where there are any.
#[test]
#[ignore = "a measurement: build it optimized"]
fn a_large_state() {
    let place = tempfile::tempdir().unwrap();
    let Snapshot { step, time, bodies, .. } = large(131_072);
    let path = place.path().join("rods.npz");
    write_state(&path, &State { step, next_id: 0, bodies, warm: Vec::new(), ..State::default() }, "x", time, None)
        .unwrap();
    let states = States::open(path.to_str().unwrap()).unwrap();
    let begun = Instant::now();
    states.read(0).unwrap();
    println!("read in {:.2} s", begun.elapsed().as_secs_f64());
    for format in [Format::Gsd, Format::Vtk { cutoff: None }] {
        let out = place.path().join("out");
        let begun = Instant::now();
        let done = export(&states, format, &out, &mut |_, _| true).unwrap();
        println!("{format:?}: {:.2} s, {} bytes", begun.elapsed().as_secs_f64(), done.bytes);
    }
    if let Ok(kept) = std::env::var("RELCP_KEEP") {
        export(&states, Format::Gsd, Path::new(&kept), &mut |_, _| true).unwrap();
        export(&states, Format::Vtk { cutoff: None }, Path::new(&kept), &mut |_, _| true).unwrap();
    }
    if let Ok(python) = std::env::var("RELCP_PYTHON") {
        compare(&python, &path);
    }
}

#[test]
fn the_real_readers_draw_the_exact_shapes() {
    let Ok(python) = std::env::var("RELCP_PYTHON") else {
        println!("SKIP the real readers: RELCP_PYTHON does not name a Python with gsd and vtk");
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let snapshots = [("shapes", every_shape()), ("rods", many_rods(2000)), ("dice", superellipsoids::snapshot())];
    for (name, Snapshot { step, time, bodies, .. }) in snapshots {
        let path = place.path().join(format!("{name}.npz"));
        write_state(&path, &State { step, next_id: 0, bodies, warm: Vec::new(), ..State::default() }, "x", time, None)
            .unwrap();
        compare(&python, &path);
    }
    compare(&python, colony(place.path()).path());
}
