//! Tests of each verb on both backends with the same vectors.

use super::{machine, near, problem, vector, with_empty_slots};
use crate::gpu::{Gpu, Precision, precisions, test_device};
use crate::lcp::cpu::Cpu;
use crate::lcp::gpu::DeviceProblem;
use crate::lcp::gpu::machine::Machine;
use crate::lcp::gpu::verbs::Device;
use crate::lcp::product::dot;
use crate::lcp::verbs::{Metric, Verbs};
use crate::lcp::{SolverKind, pair_blocks};

/// Both backends with the same vectors: `x` is not negative, `y` and `z` are arbitrary.
struct Both<'a, const D: usize> {
    cpu: Cpu<D>,
    device: Device<'a>,
    rows: usize,
}

/// Runs `check` for both precisions, on both paths, in both dimensions, for problems of several sizes.
fn everywhere(kind: SolverKind, check: impl Fn(&str, f64, &mut dyn Rig)) {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        let bound = if precision == Precision::F32 { 3e-6 } else { 1e-11 };
        for small in [Some(8), Some(32), None] {
            let mut planar = machine(gpu, precision, true, kind, small);
            let mut spatial = machine(gpu, precision, false, kind, small);
            for (rows, most) in [(1, 1), (2, 2), (5, 3), (300, 1), (700, 8)] {
                let what = format!("{} small {small:?} rows {rows}", precision.name());
                rig::<3>(gpu, precision, &mut planar, rows, most, |rig| check(&format!("{what} D 3"), bound, rig));
                rig::<6>(gpu, precision, &mut spatial, rows, most, |rig| check(&format!("{what} D 6"), bound, rig));
            }
        }
    }
}

fn rig<const D: usize>(
    gpu: &Gpu,
    precision: Precision,
    machine: &mut Machine,
    rows: usize,
    most: usize,
    check: impl Fn(&mut dyn Rig),
) {
    let problem = problem::<D>(rows as u64, rows, most);
    let mut order = Vec::new();
    pair_blocks::order(&problem.pair, &mut order);
    let (mut device_problem, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
    with_empty_slots(gpu, &mut device_problem);
    let mut cpu = Cpu::for_parallel_rows();
    cpu.rebuild(&problem);
    cpu.find_majorant();
    let mut device = Device::new(gpu, machine, &device_problem);
    device.prepare();
    check(&mut Both { cpu, device, rows });
}

/// A verb on either backend, from three vectors and a number to a vector and a number.
trait Rig {
    fn rows(&self) -> usize;
    /// The result of the verb for these vectors: on the CPU, and on the device.
    fn vector(&mut self, verb: Verb, vectors: [&[f64]; 3], number: f64) -> [Vec<f64>; 2];
    fn number(&mut self, verb: Verb, vectors: [&[f64]; 3]) -> [f64; 2];
    /// The natural residual of the pairs' small problems at `y`. The diagonals of the blocks are larger by the fraction
    /// `shift`.
    fn unsolved(&self, vectors: [&[f64]; 3], step: f64, shift: f64) -> f64;
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Verb {
    Clear,
    Copy,
    CopyIf,
    Take,
    Combine,
    Add,
    Product,
    Gradient,
    Proximal(Metric),
    Descend,
    /// With the sum of the vectors as `w`, the first one multiplied by `number`.
    Displace,
    Advance,
    Dot,
    Objective,
    Square(Metric),
    InverseSquare(Metric),
    Room,
    Residual,
}

/// The third vector has been written before.
fn make<V: Verbs>(verbs: &mut V, verb: Verb, [x, y, out]: [&mut V::Vector; 3], number: V::Scalar) {
    match verb {
        Verb::Clear => verbs.clear(out),
        Verb::Copy => verbs.copy(x, out),
        Verb::CopyIf => verbs.copy_if_positive(number, x, out),
        Verb::Take => verbs.take(x, out),
        Verb::Combine => verbs.combine(number, x, number * number, y, out),
        Verb::Add => verbs.add(number, x, out),
        Verb::Product => verbs.product(x, out),
        Verb::Gradient => verbs.gradient(x, out),
        Verb::Proximal(metric) => verbs.proximal(metric, x, number, y, out),
        Verb::Descend => verbs.descend(x, y, out),
        Verb::Displace => {
            let mut room = V::Vector::default();
            verbs.clear(&mut room);
            verbs.displace(x, [(number, y), (number, x), (-number, x)], out, &mut room);
        }
        Verb::Advance => {
            verbs.copy(x, out);
            verbs.advance(number, y, out, x);
        }
        _ => unreachable!(),
    }
}

fn reduce<V: Verbs>(verbs: &mut V, verb: Verb, x: &V::Vector, y: &V::Vector) -> V::Scalar {
    match verb {
        Verb::Dot => verbs.dot(x, y),
        Verb::Objective => verbs.twice_objective(x, y),
        Verb::Square(metric) => verbs.square(metric, y),
        Verb::InverseSquare(metric) => verbs.inverse_square(metric, y),
        Verb::Room => verbs.ratio_test(x, y),
        Verb::Residual => verbs.residual(x, y),
        _ => unreachable!(),
    }
}

impl<const D: usize> Rig for Both<'_, D> {
    fn rows(&self) -> usize {
        self.rows
    }

    fn vector(&mut self, verb: Verb, vectors: [&[f64]; 3], number: f64) -> [Vec<f64>; 2] {
        let [mut x, mut y, mut out] = vectors.map(<[f64]>::to_vec);
        make(&mut self.cpu, verb, [&mut x, &mut y, &mut out], number);
        let [mut a, mut b, mut c] = vectors.map(|numbers| self.device.uploaded(numbers));
        let number = self.device.number(number);
        make(&mut self.device, verb, [&mut a, &mut b, &mut c], number);
        [out, self.device.downloaded(&c)]
    }

    fn number(&mut self, verb: Verb, [x, y, _]: [&[f64]; 3]) -> [f64; 2] {
        let on_cpu = reduce(&mut self.cpu, verb, &x.to_vec(), &y.to_vec());
        let [a, b] = [x, y].map(|numbers| self.device.uploaded(numbers));
        let number = reduce(&mut self.device, verb, &a, &b);
        [on_cpu, self.device.read(number)]
    }

    fn unsolved(&self, [x, g, y]: [&[f64]; 3], step: f64, shift: f64) -> f64 {
        let rows = self.cpu.rows();
        let mut worst: f64 = 0.0;
        for i in 0..y.len() {
            let of_pair =
                (0..y.len()).filter(|j| pair_blocks::sorted(rows.pair[*j]) == pair_blocks::sorted(rows.pair[i]));
            if rows.inverse[i] == 0.0 {
                worst = worst.max((y[i] - x[i].max(0.0)).abs());
                continue;
            }
            let diagonal = 1.0 / rows.inverse[i];
            let mut rise = step * g[i] + shift * diagonal * (y[i] - x[i]);
            for j in of_pair {
                let [mut first, mut second] = rows.jacobian[j];
                if rows.pair[i] != rows.pair[j] {
                    std::mem::swap(&mut first, &mut second);
                }
                rise += (dot(&rows.jacobian[i][0], &first) + dot(&rows.jacobian[i][1], &second)) * (y[j] - x[j]);
            }
            worst = worst.max(rise.min(diagonal * y[i]).abs()).max(-y[i]);
        }
        worst
    }
}

fn compare(kind: SolverKind, vectors: &[Verb], numbers: &[Verb]) {
    everywhere(kind, |what, bound, rig| {
        let rows = rig.rows();
        let (x, y, z) = (vector(1, rows, 0.5), vector(2, rows, 0.0), vector(3, rows, 0.0));
        for verb in vectors {
            for number in [0.75_f64, -1.5] {
                // A projected step with a negative length has no minimum.
                let number = if matches!(verb, Verb::Proximal(_)) { number.abs() } else { number };
                let [cpu, device] = rig.vector(*verb, [&x, &y, &z], number);
                near(&cpu, &device, bound).unwrap_or_else(|e| panic!("{what} {verb:?} {number}: {e}"));
            }
        }
        for verb in numbers {
            let [cpu, device] = rig.number(*verb, [&x, &y, &z]);
            let bound = bound * (rows as f64).sqrt().max(4.0);
            near(&[cpu.min(1e30)], &[device.min(1e30)], bound).unwrap_or_else(|e| panic!("{what} {verb:?}: {e}"));
        }
    });
}

#[test]
fn verbs_on_rows_are_those_of_the_cpu() {
    let diagonal = Metric::Diagonal;
    let vectors = [
        Verb::Clear,
        Verb::Copy,
        Verb::CopyIf,
        Verb::Take,
        Verb::Combine,
        Verb::Add,
        Verb::Product,
        Verb::Gradient,
        Verb::Proximal(diagonal),
        Verb::Advance,
    ];
    let numbers =
        [Verb::Dot, Verb::Objective, Verb::Square(diagonal), Verb::InverseSquare(diagonal), Verb::Room, Verb::Residual];
    compare(SolverKind::Bbpgd, &vectors, &numbers);
}

#[test]
fn the_majorant_is_that_of_the_cpu() {
    let metric = Metric::Majorant;
    let numbers = [Verb::Square(metric), Verb::InverseSquare(metric)];
    compare(SolverKind::ProjectedJacobi, &[Verb::Proximal(metric)], &numbers);
}

#[test]
fn small_problems_of_pairs_are_solved() {
    everywhere(SolverKind::Auto, |what, bound, rig| {
        let rows = rig.rows();
        let (x, y) = (vector(1, rows, 0.5), vector(2, rows, 0.0));
        // A gradient that motions of the bodies can reduce to zero.
        let [g, _] = rig.vector(Verb::Product, [&y, &y, &y], 1.0);
        let shift = if what.starts_with("f32") { 32.0 * f64::from(f32::EPSILON) } else { 1e-6 };
        let moved = |by: &[f64]| -> Vec<f64> { x.iter().zip(by).map(|(x, by)| x + by).collect() };
        let [cpu, device] = rig.vector(Verb::Descend, [&x, &g, &x], 1.0).map(|change| moved(&change));
        let unsolved = [rig.unsolved([&x, &g, &cpu], 1.0, 1e-6), rig.unsolved([&x, &g, &device], 1.0, shift)];
        println!("{what}: left over {unsolved:?}");
        assert!(unsolved[1] < 10.0 * bound && unsolved[0] < 1e-9, "{what}: {unsolved:?}");
        // If the displacement makes no multiplier negative, it does not change.
        let [_, same] = rig.vector(Verb::Displace, [&x, &x, &y], 0.5);
        assert_eq!(same, x.iter().map(|x| 0.5 * x).collect::<Vec<_>>(), "{what}");
        let [cpu, device] = rig.vector(Verb::Displace, [&x, &y, &x], 1.0).map(|change| moved(&change));
        let (aim, zero) = (moved(&y), vec![0.0; rows]);
        let unsolved = [rig.unsolved([&aim, &zero, &cpu], 1.0, 1e-6), rig.unsolved([&aim, &zero, &device], 1.0, shift)];
        assert!(unsolved[1] < 10.0 * bound && unsolved[0] < 1e-9, "{what} displace: {unsolved:?}");
    });
}

#[test]
fn steps_of_pairs_with_many_rows_descend() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        for (small, rows) in [(Some(8), 9), (Some(8), 30), (Some(32), 30), (None, 9), (None, 12), (None, 30)] {
            let mut machine = machine(gpu, precision, true, SolverKind::Auto, small);
            let mut problem = problem::<3>(5, rows, 1);
            problem.pair.iter_mut().for_each(|pair| *pair = [0, 1]);
            let (device_problem, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
            let mut cpu = Cpu::<3>::for_parallel_rows();
            cpu.rebuild(&problem);
            let mut device = Device::new(gpu, &mut machine, &device_problem);
            device.prepare();
            // A gradient that motions of the pair can reduce to zero.
            let (x, mut g) = (vector(1, rows, 0.5), vec![0.0; rows]);
            cpu.product(&vector(2, rows, 0.0), &mut g);
            let [a, b, mut c] = [&x, &g, &x].map(|numbers| device.uploaded(numbers));
            device.descend(&a, &b, &mut c);
            let change = device.downloaded(&c);
            let mut exact = vec![0.0; rows];
            cpu.descend(&x, &g, &mut exact);
            // With a single pair, A is its block.
            let mut model = |step: &Vec<f64>| {
                let mut bend = vec![0.0; rows];
                cpu.product(step, &mut bend);
                cpu.dot(step, &g) + 0.5 * cpu.dot(step, &bend)
            };
            let (exact, made) = (model(&exact), model(&change));
            println!("{} small {small:?} rows {rows}: {made:.3e} of {exact:.3e}", precision.name());
            assert!(x.iter().zip(&change).all(|(x, change)| x + change >= 0.0 && change.is_finite()));
            assert!(made < 0.05 * exact, "{} small {small:?} rows {rows}: {made}, exact {exact}", precision.name());
        }
    }
}
