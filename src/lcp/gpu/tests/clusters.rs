//! Tests of solves with clusters on both backends.

use super::{machine, near, problem, vector, with_empty_slots};
use crate::gpu::{Gpu, Precision, precisions, test_device};
use crate::lcp::SolverKind;
use crate::lcp::cpu::Cpu;
use crate::lcp::gpu::DeviceProblem;
use crate::lcp::gpu::verbs::{Device, Slot};
use crate::lcp::verbs::{InClusters, Verbs};

/// The displacements from the clusters of a problem, on the CPU and on a device.
fn in_clusters<const D: usize>(gpu: &Gpu, precision: Precision, [rows, most]: [usize; 2], bound: f64) {
    let mut problem = problem::<D>(rows as u64, rows, most);
    let wall = problem.bodies as u32 - 1;
    for (pair, blocks) in problem.pair.iter_mut().zip(&mut problem.jacobian) {
        if pair[0] == wall {
            pair.reverse();
            blocks.reverse();
        }
        // A side without a block has no mobility on the CPU.
        if *blocks == [[0.0; D]; 2] {
            *blocks = [[0.25; D]; 2];
        }
        if pair[1] == wall {
            blocks[1] = [0.0; D];
        }
    }
    let (mut device_problem, order) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
    with_empty_slots(gpu, &mut device_problem);
    // The last body is a surface without mobility.
    device_problem.bodies -= 1;
    let mut cpu = Cpu::<D>::for_parallel_rows();
    cpu.rebuild(&problem);
    assert_eq!(cpu.order(), order);
    let mut machine = machine(gpu, precision, D == 3, SolverKind::ClusterCg, None);
    let mut device = Device::new(gpu, &mut machine, &device_problem);
    device.prepare();
    let (x, mut g, kept) = (vector(1, rows, 0.5), vec![0.0; rows], vector(3, rows, 0.0));
    cpu.product(&vector(2, rows, 0.0), &mut g);
    let what = format!("{} D {D} {rows} rows", precision.name());
    let [a, b] = [&x, &g].map(|numbers| device.uploaded(numbers));
    for (condition, tolerance) in [(0.5, 1e-6), (-1.0, 1e-6), (0.5, 1e9)] {
        let (mut out, mut c, instead) = (Vec::new(), Slot::default(), device.uploaded(&kept));
        cpu.descend_in_clusters(condition, [&x, &g], tolerance, &kept, &mut out);
        let number = device.number(condition);
        device.descend_in_clusters(number, [&a, &b], tolerance, &instead, &mut c);
        let made = device.downloaded(&c);
        assert_eq!(condition < 0.0, made == kept, "{what}");
        let [exact, descent] = [&out, &made].map(|out| cpu.dot(&g, out));
        assert!((exact - descent).abs() <= 1e-3 * exact.abs(), "{what}: {descent:e}, not {exact:e}");
        // How many nearly parallel rows share a load depends on rounding.
        if most > 3 {
            continue;
        }
        let off = out.iter().zip(&made).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        println!("{what} {condition} {tolerance}: {off:.1e}");
        near(&out, &made, bound).unwrap_or_else(|e| panic!("{what} {condition} {tolerance}: {e}"));
    }
}

#[test]
fn clusters_lead_to_what_they_do_on_the_cpu() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        // Whether a row that one step brings near zero limits the next step depends on rounding.
        let bounds = if precision == Precision::F32 { [1e-5, 1e-2] } else { [1e-11, 1e-2] };
        for size in [[1, 1], [5, 3], [300, 1], [700, 8]] {
            let bound = bounds[usize::from(size[0] > 5)];
            in_clusters::<3>(gpu, precision, size, bound);
            in_clusters::<6>(gpu, precision, size, bound);
        }
    }
}
