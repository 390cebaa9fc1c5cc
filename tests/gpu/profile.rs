//! What a profile counts and times.

use crate::device::device;
use crate::faults::own;
use relcp::gpu::{Counters, Gpu, Precision, Profile, StageUse};
use relcp::internals::gpu::{Buffer, Kernel, Recorder, Source};
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};

const COUNTS: &str = "
@group(0) @binding(0) var<storage, read_write> out: array<u32>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u && id.y == 0u { out[0] += 1u; }
}";

struct Bench {
    kernel: Kernel,
    out: Buffer,
}

impl Bench {
    fn new(gpu: &Gpu) -> Bench {
        let kernel = Kernel::new(gpu, &Source::new("counts", Precision::F32).text(COUNTS)).unwrap();
        Bench { kernel, out: Buffer::new(gpu, "out", 4, 1).unwrap() }
    }

    fn dispatch(&self, record: &mut Recorder<'_>, stage: &'static str) {
        record.stage(stage);
        record.run(&self.kernel, &[], &[&self.out], 1);
    }
}

fn stage<'a>(profile: &'a Profile, name: &str) -> &'a StageUse {
    profile.stages.iter().find(|stage| stage.stage == name).unwrap()
}

fn summed(profile: &Profile) -> Counters {
    let mut sum = Counters::default();
    profile.stages.iter().for_each(|stage| sum += stage.counters);
    sum
}

#[test]
fn every_submission_is_timed_however_many_passes_and_submissions_go_before_a_wait() {
    let Some(gpu) = own() else { return };
    if !gpu.has_timestamps() {
        return;
    }
    let bench = Bench::new(&gpu);
    gpu.start_timing();
    // More passes than one set of queries has, in one submission.
    let mut record = gpu.record();
    for _ in 0..600 {
        bench.dispatch(&mut record, "one");
        bench.dispatch(&mut record, "other one");
    }
    record.submit().unwrap();
    gpu.wait().unwrap();
    // Much is submitted before one wait; what is submitted goes to the device 32 at a time.
    for _ in 0..300 {
        let mut record = gpu.record();
        bench.dispatch(&mut record, "one");
        bench.dispatch(&mut record, "one");
        record.submit().unwrap();
    }
    let mut record = gpu.record();
    bench.dispatch(&mut record, "last");
    let read = record.read(&[(&bench.out, 0..4)]).unwrap();
    assert_eq!(read[0], 1801u32.to_le_bytes());
    // One more that nobody waits for.
    let mut record = gpu.record();
    bench.dispatch(&mut record, "last");
    record.submit().unwrap();

    let profile = Profile::of(&gpu, 1);
    let passes = ["one", "other one", "last"].map(|name| stage(&profile, name).passes);
    assert_eq!((passes, profile.untimed_passes), ([900, 600, 2], 0));
    let dispatches = ["one", "other one", "last"].map(|name| stage(&profile, name).counters.dispatches);
    assert_eq!(dispatches, [1200, 600, 2]);
    let last = stage(&profile, "last").counters;
    assert_eq!((last.submissions, last.reads, last.bytes_read), (2, 1, 4));
    assert_eq!(profile.counters, summed(&profile));
    // The 600 passes, nine times 32 recorders, the others with what is read, and the last one.
    assert_eq!((profile.counters.submissions, profile.counters.reads), (12, 1));
    assert!(profile.to_string().contains("all 1502 passes were timed"), "{profile}");
    assert!(profile.device_seconds.unwrap() > 0.0 && profile.wall_seconds > 0.0);
}

#[test]
fn bytes_are_counted_where_they_are_written_and_read() {
    let Some(gpu) = own() else { return };
    let bench = Bench::new(&gpu);
    gpu.start_timing();
    bench.out.write(&gpu, 0, &[0; 4]);
    let mut record = gpu.record();
    bench.dispatch(&mut record, "first");
    bench.dispatch(&mut record, "second");
    record.read(&[(&bench.out, 0..4)]).unwrap();
    bench.out.write(&gpu, 0, &[0; 4]);
    let profile = Profile::of(&gpu, 1);
    let written = ["first", "second", "other"].map(|name| stage(&profile, name).counters.bytes_written);
    assert_eq!(written, [4, 0, 4]);
    assert_eq!(stage(&profile, "second").counters.bytes_read, 4);
    assert_eq!(profile.counters.bytes_written, gpu.counters().bytes_written);
}

#[test]
fn the_stages_of_steps_add_up_and_a_new_profile_begins_with_nothing() {
    let Some(gpu) = own() else { return };
    let scene = Scene::load("colony", ["time.end=1"]).unwrap();
    let compute = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    let mut simulation = Simulation::builder(scene).on(&compute).build().unwrap();
    simulation.step().unwrap();
    gpu.start_timing();
    let before = gpu.counters();
    for _ in 0..5 {
        simulation.step().unwrap();
    }
    let profile = Profile::of(&gpu, 5);
    let taken = gpu.counters() - before;
    // Seconds are summed in another order.
    assert!((profile.counters.wait_seconds - taken.wait_seconds).abs() < 1e-9);
    assert_eq!(Counters { wait_seconds: 0.0, ..summed(&profile) }, Counters { wait_seconds: 0.0, ..taken });
    // A step hands work over more often than it waits; all of it is timed.
    assert!(taken.submissions > taken.reads && taken.wait_seconds > 0.0, "{taken:?}");
    assert_eq!(profile.untimed_passes, 0);
    for stage in profile.stages.iter().filter(|stage| stage.counters.dispatches > 0 && gpu.has_timestamps()) {
        assert!((1..=stage.counters.dispatches).contains(&stage.passes), "{stage:?}");
    }
    gpu.start_timing();
    let empty = Profile::of(&gpu, 0);
    assert!(empty.stages.is_empty() && empty.counters == Counters::default(), "{empty}");
}

#[test]
fn the_one_device_counts_without_a_profile() {
    let Some(gpu) = device() else { return };
    let before = gpu.counters();
    let bench = Bench::new(gpu);
    let mut record = gpu.record();
    bench.dispatch(&mut record, "one");
    record.read(&[(&bench.out, 0..4)]).unwrap();
    assert!((gpu.counters() - before).dispatches >= 1);
}
