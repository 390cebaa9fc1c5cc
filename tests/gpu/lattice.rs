//! The lattice's arithmetic on the device against exact sums.

use crate::device::{device, precisions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Lattice, Source};

const STEPS: u32 = 1000;

/// Moves points by a step many times over, and tells how far each is from its first place.
const MOVE: &str = "
@group(0) @binding(0) var<storage, read> steps: array<vec4r>;
@group(0) @binding(1) var<storage, read_write> cells: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read_write> remainders: array<vec4r>;
@group(0) @binding(3) var<storage, read_write> moved: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= arrayLength(&steps) { return; }
    var at = LatticePoint(cells[i].xyz, remainders[i].xyz);
    let from_ = at;
    for (var k = 0u; k < STEPS; k += 1u) { at = lattice_add(at.cell, at.remainder, steps[i].xyz); }
    cells[i] = vec4<i32>(at.cell, 0);
    remainders[i] = vec4r(at.remainder, 0.0);
    moved[i] = vec4r(lattice_difference(from_.cell, from_.remainder, at.cell, at.remainder), 0.0);
}
";

fn check(gpu: &Gpu, precision: Precision, lattice: Lattice) {
    let source = Source::new("move", precision).integer("STEPS", STEPS);
    let kernel = Kernel::new(gpu, &lattice.define(source).text(MOVE)).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let n = 256;
    let pitch = lattice.pitch();
    // From far below a float's last place at these coordinates to many pitches. As floats hold them.
    let steps: Vec<f64> = (0..4 * n)
        .map(|_| (rng.random::<f64>() - 0.5) * pitch * 10f64.powf(-5.0 + 8.0 * rng.random::<f64>()))
        .map(|step| f64::from(step as f32))
        .collect();
    let starts: Vec<f64> = (0..4 * n).map(|_| (rng.random::<f64>() - 0.5) * 6e5 * pitch).collect();
    let split: Vec<(i32, f64)> = starts.iter().map(|x| lattice.split(*x).unwrap()).collect();
    let cells: Vec<i32> = split.iter().map(|s| s.0).collect();
    let step_buffer = Buffer::reals(gpu, "steps", precision, 4, steps.iter().copied()).unwrap();
    let cell_buffer = Buffer::with(gpu, "cells", 16, bytemuck::cast_slice(&cells)).unwrap();
    let remainder_buffer = Buffer::reals(gpu, "remainders", precision, 4, split.iter().map(|s| s.1)).unwrap();
    let moved_buffer = Buffer::new(gpu, "moved", 4 * precision.bytes(), n as u64).unwrap();
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&step_buffer, &cell_buffer, &remainder_buffer, &moved_buffer], n as u64);
    let reals = (4 * n * precision.bytes()) as u64;
    let ranges = [(&cell_buffer, 0..16 * n as u64), (&remainder_buffer, 0..reals), (&moved_buffer, 0..reals)];
    let read = record.read(&ranges).unwrap();
    let cells: Vec<i32> = bytemuck::pod_collect_to_vec(&read[0]);
    let (remainders, moved) = (precision.decode(&read[1]), precision.decode(&read[2]));
    for k in (0..4 * n).filter(|k| k % 4 < 3) {
        let total = f64::from(STEPS) * steps[k];
        // Each addition rounds the remainder, or a step of many pitches.
        let rounding = f64::from(STEPS) * precision.epsilon() * (pitch + steps[k].abs()) + 1e-9 * pitch;
        let error = lattice.join(cells[k], remainders[k]) - starts[k] - total;
        assert!(error.abs() <= rounding, "{precision:?}: step {:e}, error {error:e}", steps[k]);
        assert!(remainders[k].abs() <= pitch / 2.0 * (1.0 + precision.epsilon()));
        assert!((moved[k] - total).abs() <= rounding + 2.0 * precision.epsilon() * total.abs(), "{precision:?}");
    }
}

#[test]
fn steps_add_up_far_from_the_origin() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        for thickness in [1.0, 3e-4] {
            check(gpu, precision, Lattice::for_thickness(thickness).unwrap());
        }
    }
}
