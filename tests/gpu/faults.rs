//! What goes wrong with a device is a typed error that says what to do, and costs no more than what was not yet
//! written.

use crate::device::device;
use relcp::Scene;
use relcp::gpu::{Choice, Gpu, GpuError, Precision, adapters};
use relcp::internals::gpu::{Buffer, Kernel, Source};
use relcp::record::{Folder, read_state};
use relcp::run::{Run, RunError};
use relcp::simulation::{Compute, Simulation};
use relcp::step::Fault;
use std::sync::Arc;
use std::time::Duration;

/// A device of a test's own, to be spoilt.
pub fn own() -> Option<Arc<Gpu>> {
    let name = device()?.name().to_owned();
    Some(Arc::new(Gpu::open(&Choice { name: Some(name), software: true, ..Choice::default() }).unwrap()))
}

#[test]
fn an_adapter_that_is_not_there_is_said_with_those_that_are() {
    let Some(gpu) = device() else { return };
    let choice = Choice { name: Some("no such adapter".into()), software: true, ..Choice::default() };
    let fault = Gpu::open(&choice).err().unwrap();
    assert!(matches!(fault, GpuError::NoAdapter { .. }));
    let text = fault.to_string();
    assert!(text.contains("no such adapter") && text.contains(gpu.name()) && text.contains("on the CPU"), "{text}");
}

#[test]
fn the_report_of_adapters_names_the_one_that_is_taken() {
    let Some(gpu) = device() else { return };
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, ..Choice::default() };
    let all = adapters(&choice);
    let taken: Vec<_> = all.iter().filter(|a| a.taken).collect();
    assert_eq!(taken.len(), 1);
    assert_eq!((taken[0].name.as_str(), taken[0].driver.as_str()), (gpu.name(), gpu.driver()));
    assert_eq!(taken[0].f64, gpu.has_f64());
    assert!(taken[0].lacks.is_empty() && taken[0].storage_buffers >= 8);
}

#[test]
fn a_device_opened_with_the_least_limits_runs_a_scene() {
    let Some(gpu) = device() else { return };
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, default_limits: true };
    let gpu = Arc::new(Gpu::open(&choice).unwrap());
    assert_eq!((gpu.bank_bytes(), gpu.most_elements(1)), (128 << 20, 256 << 20));
    let scene = Scene::built_in("three-capsules").unwrap();
    let bodies = scene.build().unwrap();
    let compute = Compute::Gpu { gpu, precision: Precision::F32 };
    let mut simulation = Simulation::builder(scene).bodies(bodies).on(&compute).build().unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
}

#[test]
fn a_buffer_beyond_the_limit_is_refused_before_it_is_made() {
    let Some(gpu) = device() else { return };
    let fault = Buffer::new(gpu, "too much", 16, 1 << 40).err().unwrap();
    let GpuError::Limit { needs, has, .. } = &fault else { panic!("{fault}") };
    assert!(*needs == 16 << 40 && *has >= 128 << 20);
    assert!(fault.to_string().contains("too much"));
    gpu.health().unwrap();
}

#[test]
fn a_wrong_kernel_is_refused_with_its_place() {
    let Some(gpu) = device() else { return };
    let source = Source::new("wrong", Precision::F32).text("fn f() -> real { return nothing; }");
    let fault = Kernel::new(gpu, &source).err().unwrap();
    let text = fault.to_string();
    assert!(matches!(fault, GpuError::Kernel { .. }) && text.contains("nothing") && text.contains("wgsl:"), "{text}");
    gpu.health().unwrap();
}

#[test]
fn a_lost_device_ends_the_run_and_keeps_its_checkpoint() {
    let Some(gpu) = own() else { return };
    let place = tempfile::tempdir().unwrap();
    let scene = Scene::load("two-ellipsoids", ["time.dt=0.05"]).unwrap();
    let bodies = scene.build().unwrap();
    let compute = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    let simulation = Simulation::builder(scene).bodies(bodies).on(&compute).build().unwrap();
    let folder = Folder::create(&place.path().join("run")).unwrap();
    let mut run = Run::start(simulation, folder.clone(), Duration::ZERO).unwrap();
    for _ in 0..5 {
        run.advance().unwrap();
    }
    run.checkpoint().unwrap();
    run.advance().unwrap();
    gpu.destroy();
    let fault = run.advance().unwrap_err();
    assert!(matches!(fault, RunError::Fault(Fault::Device(GpuError::Lost { .. }))), "{fault}");
    assert!(fault.to_string().contains("resumed from its last checkpoint"));
    drop(run);
    assert_eq!(read_state(&folder.checkpoint()).unwrap().1.step, 5);
}

#[test]
fn a_device_that_does_not_answer_is_given_up() {
    let Some(gpu) = own() else { return };
    let text = "
@group(0) @binding(0) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var state = id.x;
    for (var k = 0u; k < 60000u; k += 1u) { state = state * 1664525u + out[0] + 1013904223u; }
    out[1u + id.x % 8u] = state;
}";
    let kernel = Kernel::new(&gpu, &Source::new("long", Precision::F32).text(text)).unwrap();
    let out = Buffer::new(&gpu, "out", 4, 64).unwrap();
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&out], 1);
    record.read(&[(&out, 0..4)]).unwrap();
    gpu.set_patience(Duration::from_millis(2));
    record.run(&kernel, &[], &[&out], 20_000);
    let fault = record.read(&[(&out, 0..4)]).unwrap_err();
    assert!(matches!(fault, GpuError::Hang { .. }), "{fault}");
    assert_eq!(gpu.health().unwrap_err(), fault);
}

#[test]
fn much_work_is_handed_over_in_parts() {
    let Some(gpu) = own() else { return };
    let text = "
@group(0) @binding(0) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u && id.y == 0u { out[0] += 1u; }
}";
    let kernel = Kernel::new(&gpu, &Source::new("counts", Precision::F32).text(text)).unwrap();
    let out = Buffer::new(&gpu, "out", 4, 1).unwrap();
    out.write(&gpu, 0, &[0; 4]);
    let before = gpu.counters();
    let mut record = gpu.record();
    for _ in 0..100 {
        record.run(&kernel, &[], &[&out], 1_000_000);
    }
    let read = record.read(&[(&out, 0..4)]).unwrap();
    assert_eq!(read[0], 100u32.to_le_bytes());
    let after = gpu.counters();
    assert_eq!(after.dispatches - before.dispatches, 100);
    let submissions = after.submissions - before.submissions;
    assert!((5..=8).contains(&submissions), "{submissions}");

    // Few invocations with many rows each are much work too.
    let mut record = gpu.record();
    for _ in 0..10 {
        record.weigh(10_000_000);
        record.run(&kernel, &[], &[&out], 1);
    }
    record.read(&[(&out, 0..4)]).unwrap();
    let submissions = gpu.counters().submissions - after.submissions;
    assert!((5..=6).contains(&submissions), "{submissions}");
}

/// Threads that share a device record at once, more of them than one buffer has room for parameters.
#[test]
fn each_of_many_recorders_at_once_has_its_own_parameters() {
    let Some(gpu) = own() else { return };
    let text = "
struct Parameters { digit: u32, a: u32, b: u32, c: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u { out[0] = 3u * out[0] + parameters.digit; }
}";
    let kernel = Kernel::new(&gpu, &Source::new("digits", Precision::F32).text(text)).unwrap();
    let out = Buffer::new(&gpu, "out", 4, 1).unwrap();
    for _ in 0..2 {
        out.write(&gpu, 0, &[0; 4]);
        let mut recorders: Vec<_> = (0..20).map(|_| gpu.record()).collect();
        let digit = |nth: usize| (nth % 3) as u32;
        for (nth, record) in recorders.iter_mut().enumerate() {
            let parameters = [digit(nth), 0, 0, 0];
            record.run(&kernel, bytemuck::bytes_of(&parameters), &[&out], 1);
        }
        recorders.iter_mut().for_each(|record| record.submit().unwrap());
        let read = gpu.record().read(&[(&out, 0..4)]).unwrap();
        let expected = (0..20).fold(0_u32, |sum, nth| sum.wrapping_mul(3).wrapping_add(digit(nth)));
        assert_eq!(read[0], expected.to_le_bytes());
    }
}

#[test]
fn buffers_that_do_not_fit_a_kernel_are_refused_by_name() {
    let text = "
struct Parameters { count: u32, a: u32, b: u32, c: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> sums: array<u32, 100000>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) { sums[id.x] = parameters.count + u32(places[id.x].x); }";
    // What each refusal names.
    let cases: [(&[&str], usize, &[&str]); 5] = [
        (&["places", "sums"], 16, &[]),
        (&["places"], 16, &["variable sums"]),
        (&["places", "sums", "sums"], 16, &["no variable"]),
        (&["places", "sums"], 12, &["16 bytes", "12"]),
        (&["sums", "sums"], 16, &["array places", "16 bytes", "\"numbers\"", "elements of 4"]),
    ];
    for (names, bytes, told) in cases {
        let Some(gpu) = own() else { return };
        let kernel = Kernel::new(&gpu, &Source::new("sums of places", Precision::F32).text(text)).unwrap();
        let places = Buffer::new(&gpu, "points", 16, 128).unwrap();
        let sums = Buffer::new(&gpu, "numbers", 4, 100_000).unwrap();
        let bound: Vec<_> = names.iter().map(|name| if *name == "sums" { &sums } else { &places }).collect();
        let mut record = gpu.record();
        record.run(&kernel, &[0; 16][..bytes], &bound, 1);
        let done = record.submit();
        assert_eq!(done.is_ok(), told.is_empty(), "{names:?} {done:?}");
        let text = done.err().map(|fault| fault.to_string()).unwrap_or_default();
        assert!(told.iter().all(|part| text.contains(part)), "{text}");
        assert!(told.is_empty() || text.contains("the kernel sums of places was refused"), "{text}");
    }
    let Some(gpu) = own() else { return };
    let kernel = Kernel::new(&gpu, &Source::new("sums of places", Precision::F32).text(text)).unwrap();
    let places = Buffer::new(&gpu, "points", 16, 128).unwrap();
    let few = Buffer::new(&gpu, "few numbers", 4, 64).unwrap();
    let mut record = gpu.record();
    record.run(&kernel, &[0; 16], &[&places, &few], 1);
    let text = record.submit().unwrap_err().to_string();
    assert!(text.contains("variable sums takes 400000 bytes") && text.contains("\"few numbers\""), "{text}");
}
