//! `--backend`, `--adapter` and `--precision`: what computes, as a study's document says.

use super::flags::ran;
use super::place::{Place, fresh};
use relcp::gpu::{Choice, Gpu};
use serde_json::Value;
use std::sync::{LazyLock, OnceLock};

/// The adapter that `--backend gpu` takes, and whether it has f64.
static ADAPTER: LazyLock<Option<(String, bool)>> = LazyLock::new(|| {
    let gpu = Gpu::open(&Choice { software: true, ..Choice::default() }).ok()?;
    Some((gpu.name().to_owned(), gpu.has_f64()))
});

/// What a study says of what computed it.
fn said(place: &Place, more: &str) -> String {
    let out = fresh();
    let line = format!("hard --random 1 --quick --out {out} --json {more}");
    let printed = place.lab(&line.split_whitespace().collect::<Vec<_>>()).expect(0).out;
    serde_json::from_str::<Value>(&printed).unwrap()["computed_by"].to_string()
}

/// What it says on a device that is named, in the precision that is not the default where the device has it.
fn on_device(place: &Place) -> Option<(&'static str, &'static str, &'static str)> {
    static SAID: OnceLock<String> = OnceLock::new();
    let Some((name, f64)) = &*ADAPTER else {
        println!("SKIP relcp-lab on a device: there is no adapter");
        return None;
    };
    let precision = if *f64 { "f64" } else { "f32" };
    let part = name.split_whitespace().next().unwrap();
    let words = SAID.get_or_init(|| said(place, &format!("--backend gpu --adapter {part} --precision {precision}")));
    Some((words, name, precision))
}

pub fn shows_backend(place: &Place) {
    assert!(said(place, "--backend cpu").contains("CPU"));
    if let Some((said, name, _)) = on_device(place) {
        assert!(said.contains(name), "{said}");
    }
}

pub fn shows_adapter(place: &Place) {
    let (out, gpu) = (fresh(), ["--backend", "gpu", "--adapter", "no-such"]);
    let words = ["throughput", "--of", "colony", "--largest", "100", "--out", &out];
    let err = place.lab(&[&words[..], &gpu].concat()).expect(5).err;
    assert!(err.contains("no usable adapter named no-such"), "{err}");
    ran(place, &["--adapter", "any"]).expect(2);
    if let Some((said, name, _)) = on_device(place) {
        assert!(said.contains(name), "{said}");
    }
}

pub fn shows_precision(place: &Place) {
    ran(place, &["--precision", "f16"]).expect(2);
    let err = ran(place, &["--precision", "f32"]).expect(2).err;
    assert!(err.contains("the CPU computes in f64"), "{err}");
    assert!(said(place, "--backend cpu --precision f64").contains("f64"));
    if let Some((said, _, precision)) = on_device(place) {
        assert!(said.contains(precision), "{said}");
    }
}
