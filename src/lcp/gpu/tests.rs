//! Tests of the verbs on the device against those on the CPU, one by one.

mod clusters;
mod cone;
mod friction;
mod kernels;
mod slots;
mod stages;
mod verbs;

use super::DeviceProblem;
use super::layout::{Slots, Variant};
use super::machine::Machine;
use crate::gpu::{Buffer, Gpu, Precision};
use crate::lcp::{Problem, SolverKind, pair_blocks};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A problem whose pairs have 1 to `most` rows, some with swapped bodies, some nearly parallel, some zero.
fn problem<const D: usize>(seed: u64, rows: usize, most: usize) -> Problem<D> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let bodies = 3 + rows / 3;
    let mut problem = Problem { bodies, ..Problem::default() };
    while problem.q.len() < rows {
        let a = rng.random_range(0..bodies as u32 - 1);
        let pair = [a, rng.random_range(a + 1..bodies as u32)];
        if problem.pair.iter().any(|other| pair_blocks::sorted(*other) == pair) {
            continue;
        }
        for row in 0..rng.random_range(1..=most).min(rows - problem.q.len()) {
            let mut blocks = [[0.0; D]; 2];
            match problem.jacobian.last() {
                Some(last) if row > 0 && rng.random_range(0..3) == 0 => blocks = *last,
                _ => blocks.as_flattened_mut().iter_mut().for_each(|x| *x = rng.random::<f64>() - 0.5),
            }
            blocks.as_flattened_mut().iter_mut().for_each(|x| *x += 1e-2 * (rng.random::<f64>() - 0.5));
            if rng.random_range(0..12) == 0 {
                blocks = [[0.0; D]; 2];
            }
            let turned = row % 3 == 2;
            problem.pair.push(if turned { [pair[1], pair[0]] } else { pair });
            problem.jacobian.push(if turned { [blocks[1], blocks[0]] } else { blocks });
            problem.q.push(rng.random::<f64>() - 0.5);
        }
    }
    // Rounded to numbers of the device, so that the CPU computes with the same numbers.
    problem
        .q
        .iter_mut()
        .chain(problem.jacobian.as_flattened_mut().as_flattened_mut())
        .for_each(|x| *x = f64::from(*x as f32));
    problem
}

fn vector(seed: u64, rows: usize, shift: f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..rows).map(|_| f64::from((rng.random::<f64>() - 0.5 + shift) as f32)).collect()
}

/// A machine that solves by one workgroup of this many invocations, or by one dispatch per stage.
fn machine(gpu: &Gpu, precision: Precision, planar: bool, kind: SolverKind, small: Option<u32>) -> Machine {
    let mut variant = Variant::of(gpu, precision, planar, Slots::of(kind, precision));
    variant.small_workgroup = small.unwrap_or(variant.small_workgroup);
    let mut machine = Machine::new(gpu, variant).unwrap();
    machine.largest_small = if small.is_some() { u64::MAX } else { 0 };
    machine
}

/// Inserts an empty slot before each pair's slot.
fn with_empty_slots(gpu: &Gpu, problem: &mut DeviceProblem) {
    let read = gpu.record().read(&[(&problem.block_start, 0..4 * (problem.pairs + 1))]).unwrap();
    let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
    let doubled: Vec<u32> = starts.iter().flat_map(|start| [*start; 2]).collect();
    problem.block_start = Buffer::with(gpu, "block-start", 4, bytemuck::cast_slice(&doubled)).unwrap();
    problem.pairs = doubled.len() as u64 - 1;
}

fn near(a: &[f64], b: &[f64], bound: f64) -> Result<(), String> {
    let size = a.iter().fold(1e-3, |size: f64, x| size.max(x.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        let close = (a - b).abs() <= bound * size;
        if !close {
            return Err(format!("row {i}: {a:e}, on the device {b:e}"));
        }
    }
    if a.len() == b.len() { Ok(()) } else { Err(format!("{} rows, on the device {}", a.len(), b.len())) }
}
