//! The verbs on the device against those on the CPU, each alone.

mod cone;
mod slots;

use super::DeviceProblem;
use super::kernels::Variant;
use super::layout::Slots;
use super::machine::Machine;
use super::shape::StageArguments;
use super::stage::{Stage, Work};
use super::verbs::{Device, Slot};
use crate::gpu::{Buffer, Gpu, Precision, precisions, test_device};
use crate::lcp::cluster_cg::ClusterCg;
use crate::lcp::cpu::Cpu;
use crate::lcp::drive::{Method, Point};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::product::dot;
use crate::lcp::verbs::{InClusters, Metric, Scalar, Verbs};
use crate::lcp::{Problem, SolverKind, pair_blocks};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A problem whose pairs have 1 to `most` rows, some the other way round, some nearly parallel, some zero.
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
    // What the device can hold, so that the CPU computes with the same numbers.
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

/// Both backends with the same vectors: `x` not negative, `y` and `z` any.
struct Both<'a, const D: usize> {
    cpu: Cpu<D>,
    device: Device<'a>,
    rows: usize,
}

/// One that solves by one workgroup of so many invocations, or by a dispatch a stage.
fn machine(gpu: &Gpu, precision: Precision, planar: bool, kind: SolverKind, small: Option<u32>) -> Machine {
    let mut variant = Variant::of(gpu, precision, planar, Slots::of(kind, precision));
    variant.small_workgroup = small.unwrap_or(variant.small_workgroup);
    let mut machine = Machine::new(gpu, variant).unwrap();
    machine.largest_small = if small.is_some() { u64::MAX } else { 0 };
    machine
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

/// Puts an empty slot before each pair's.
fn with_empty_slots(gpu: &Gpu, problem: &mut DeviceProblem) {
    let read = gpu.record().read(&[(&problem.block_start, 0..4 * (problem.pairs + 1))]).unwrap();
    let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
    let doubled: Vec<u32> = starts.iter().flat_map(|start| [*start; 2]).collect();
    problem.block_start = Buffer::with(gpu, "block-start", 4, bytemuck::cast_slice(&doubled)).unwrap();
    problem.pairs = doubled.len() as u64 - 1;
}

/// A verb on either backend: from three vectors and a number to a vector and a number.
trait Rig {
    fn rows(&self) -> usize;
    /// What the verb makes of these vectors: on the CPU, on the device.
    fn vector(&mut self, verb: Verb, vectors: [&[f64]; 3], number: f64) -> [Vec<f64>; 2];
    fn number(&mut self, verb: Verb, vectors: [&[f64]; 3]) -> [f64; 2];
    /// The natural residual of the pairs' small problems at `y`, with blocks whose diagonals are larger by the part
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
    /// By `number` times the first vector and the rest of them.
    Displace,
    Advance,
    Dot,
    Objective,
    Square(Metric),
    InverseSquare(Metric),
    Room,
    Residual,
}

/// The third vector is what is written to before.
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

fn compare(kind: SolverKind, vectors: &[Verb], numbers: &[Verb]) {
    everywhere(kind, |what, bound, rig| {
        let rows = rig.rows();
        let (x, y, z) = (vector(1, rows, 0.5), vector(2, rows, 0.0), vector(3, rows, 0.0));
        for verb in vectors {
            for number in [0.75_f64, -1.5] {
                // A negative step has no minimum.
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
        // A gradient that motions can bring to zero.
        let [g, _] = rig.vector(Verb::Product, [&y, &y, &y], 1.0);
        let shift = if what.starts_with("f32") { 32.0 * f64::from(f32::EPSILON) } else { 1e-6 };
        let moved = |by: &[f64]| -> Vec<f64> { x.iter().zip(by).map(|(x, by)| x + by).collect() };
        let [cpu, device] = rig.vector(Verb::Descend, [&x, &g, &x], 1.0).map(|change| moved(&change));
        let unsolved = [rig.unsolved([&x, &g, &cpu], 1.0, 1e-6), rig.unsolved([&x, &g, &device], 1.0, shift)];
        println!("{what}: left over {unsolved:?}");
        assert!(unsolved[1] < 10.0 * bound && unsolved[0] < 1e-9, "{what}: {unsolved:?}");
        // What leads to nothing negative does not change.
        let [_, same] = rig.vector(Verb::Displace, [&x, &x, &y], 0.5);
        assert_eq!(same, x.iter().map(|x| 0.5 * x).collect::<Vec<_>>(), "{what}");
        let [cpu, device] = rig.vector(Verb::Displace, [&x, &y, &x], 1.0).map(|change| moved(&change));
        let (aim, zero) = (moved(&y), vec![0.0; rows]);
        let unsolved = [rig.unsolved([&aim, &zero, &cpu], 1.0, 1e-6), rig.unsolved([&aim, &zero, &device], 1.0, shift)];
        assert!(unsolved[1] < 10.0 * bound && unsolved[0] < 1e-9, "{what} displace: {unsolved:?}");
    });
}

/// What the clusters of a problem lead to, on the CPU and on a device.
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
        // How many nearly parallel rows share a load is a matter of rounding.
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
        // A row that one step brings to nothing, or by rounding just not, bounds the next step or does not.
        let bounds = if precision == Precision::F32 { [1e-5, 1e-2] } else { [1e-11, 1e-2] };
        for size in [[1, 1], [5, 3], [300, 1], [700, 8]] {
            let bound = bounds[usize::from(size[0] > 5)];
            in_clusters::<3>(gpu, precision, size, bound);
            in_clusters::<6>(gpu, precision, size, bound);
        }
    }
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
            // A gradient that motions of the pair can bring to zero.
            let (x, mut g) = (vector(1, rows, 0.5), vec![0.0; rows]);
            cpu.product(&vector(2, rows, 0.0), &mut g);
            let [a, b, mut c] = [&x, &g, &x].map(|numbers| device.uploaded(numbers));
            device.descend(&a, &b, &mut c);
            let change = device.downloaded(&c);
            let mut exact = vec![0.0; rows];
            cpu.descend(&x, &g, &mut exact);
            // With a single pair A is its block.
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

#[test]
fn arithmetic_is_that_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    fn formula<S: Scalar>(a: S, b: S, zero: S) -> [S; 6] {
        let nan = zero / zero;
        [
            (a + b) * (a - b) / b,
            -a * 3.0.into(),
            a.min(b) + nan.min(a),
            a.max(b) + nan.max(b),
            a.if_positive(b, zero) + zero.if_positive(a, b),
            nan.if_positive(a, b) + (-a).if_positive(a, b),
        ]
    }
    for precision in precisions(gpu) {
        for small in [Some(8), Some(32), None] {
            let mut machine = machine(gpu, precision, true, SolverKind::Bbpgd, small);
            let problem = problem::<3>(1, 10, 2);
            let (device_problem, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
            let mut device = Device::new(gpu, &mut machine, &device_problem);
            let (a, b, zero) = (device.number(0.75), device.number(-2.5), device.number(0.0));
            let made = formula(a, b, zero);
            for (made, wanted) in made.into_iter().zip(formula(0.75, -2.5, 0.0)) {
                let made = device.read(made);
                assert!((made - wanted).abs() < 1e-6, "{} small {small:?}: {made}, not {wanted}", precision.name());
            }
        }
    }
}

/// Bytes that an iteration moves a row of a problem in the plane, each element of an array once a dispatch.
fn bytes_of_a_row(stages: &[StageArguments], real: f64, bodies_of_a_row: f64) -> f64 {
    stages
        .iter()
        .map(|arguments| {
            let text = arguments.shape.entry_point(|x| format!("{x}"));
            // A vector is named by its place among the parameters. Conditional copies are not made in most iterations.
            let made: String =
                text.lines().filter(|line| !line.trim_start().starts_with("if ")).collect::<Vec<_>>().join("\n");
            let named = |vector: usize| {
                let place = format!("parameters.vectors[{}][{}] >> {}u", vector / 16, vector / 4 % 4, 8 * (vector % 4));
                made.lines().any(|line| line.contains("vectors[at(((") && line.contains(&place))
            };
            let block = text.contains("minimize_block");
            let vectors = (0..arguments.vectors.len()).filter(|vector| named(*vector)).count();
            let whole: f64 = arguments
                .shape
                .variables()
                .iter()
                .map(|(name, ..)| match *name {
                    "pair" | "incidence" => 8.0,
                    "span" => 4.0,
                    "jacobian" | "gathered" => 8.0 * real,
                    "velocity" | "velocity_rest" => 4.0 * real * bodies_of_a_row,
                    _ => 0.0,
                })
                .sum();
            // The small problems also read the iterate or a step, the inverse diagonal and the coupling.
            let of_blocks = if block { 3.0 * real } else { 0.0 };
            let gathered = if arguments.shape.is_bodies() { real } else { 0.0 };
            vectors as f64 * real + whole + of_blocks + gathered
        })
        .sum()
}

/// The stages of iterations of a method, from one pass over the bodies to the next, and the constants of their tape.
fn iterations<'a, M: Method<Device<'a>>>(device: &mut Device<'a>, method: &mut M) -> (Vec<Vec<Stage>>, Vec<f64>) {
    device.prepare();
    let mut at = Point { x: device.start(), g: Slot::default() };
    let mut best = Slot::default();
    device.gradient(&at.x, &mut at.g);
    device.copy(&at.x, &mut best);
    method.begin(device, &at);
    let mut least = device.residual(&at.x, &at.g);
    for _ in 0..6 {
        method.step(device, &mut at);
        let residual = device.residual(&at.x, &at.g);
        device.copy_if_positive(least - residual, &at.x, &mut best);
        least = least.min(residual);
        device.check(residual, 1e-6);
    }
    let stages = &device.tape.stages;
    let bodies: Vec<usize> = (0..stages.len()).filter(|stage| matches!(stages[*stage].work, Work::Bodies(_))).collect();
    let spans = bodies.windows(2).map(|pair| stages[pair[0]..pair[1]].to_vec()).collect();
    (spans, device.tape.constants().to_vec())
}

#[test]
fn an_iteration_is_four_dispatches_and_six_with_clusters() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        let problem = problem::<3>(1, 300, 2);
        let (device_problem, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
        let mut machine_of_pairs = machine(gpu, precision, true, SolverKind::Auto, None);
        let mut device = Device::new(gpu, &mut machine_of_pairs, &device_problem);
        let (spans, constants) = iterations(&mut device, &mut PairBlockCg::new());
        let lengths = |spans: &[Vec<Stage>]| -> Vec<usize> { spans[2..].iter().map(Vec::len).collect() };
        println!("{}: {:?} dispatches an iteration", precision.name(), lengths(&spans));
        assert!(lengths(&spans).iter().all(|span| *span <= 4), "{}: {:?}", precision.name(), lengths(&spans));
        let arguments: Vec<_> = spans[4].iter().map(|stage| StageArguments::of(&constants, stage, &[])).collect();
        // Crowded cells have 2.8 rows a body.
        let bytes = bytes_of_a_row(&arguments, precision.bytes() as f64, 1.0 / 2.8);
        println!("{}: {bytes:.0} bytes a row and iteration", precision.name());
        assert!(bytes <= if precision == Precision::F32 { 240.0 } else { 420.0 }, "{bytes}");

        let mut machine = machine(gpu, precision, true, SolverKind::ClusterCg, None);
        let mut device = Device::new(gpu, &mut machine, &device_problem);
        let (spans, _) = iterations(&mut device, &mut ClusterCg::to(1e-6));
        println!("{}: {:?} with clusters", precision.name(), lengths(&spans));
        assert!(lengths(&spans).iter().all(|span| *span <= 6), "{}: {:?}", precision.name(), lengths(&spans));
    }
}

#[test]
fn a_batch_ends_at_the_look_that_converged() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        for small in [Some(8), Some(32), None] {
            let mut machine = machine(gpu, precision, true, SolverKind::Bbpgd, small);
            let problem = problem::<3>(1, 10, 2);
            let (device_problem, _) = DeviceProblem::upload(gpu, precision, &problem, &[]).unwrap();
            let mut device = Device::new(gpu, &mut machine, &device_problem);
            device.prepare();
            for last in [0.25, f64::NAN] {
                // Of the residuals 4, 0.25 or NaN, and 0.125 the second one ends the batch.
                // The iterates are so large that the gradient is the residual.
                let [mut x, mut g, one]: [Slot; 3] = [1e6, 1.0, 1.0].map(|x| device.uploaded(&[x; 10]));
                let mut worse = device.uploaded(&[last; 10]);
                for (nth, to) in [4.0, last, 0.125].into_iter().enumerate() {
                    let (none, to) = (device.number(0.0), device.number(if nth == 1 { 0.0 } else { to }));
                    device.combine(to, &one, none, &one, &mut g);
                    if nth == 1 {
                        device.take(&mut worse, &mut g);
                    }
                    let more = device.number(5e5);
                    device.add(more, &one, &mut x);
                    let residual = device.residual(&x, &g);
                    device.check(residual, 0.5);
                }
                let mut looks = device.take_checks();
                looks.residuals.extend(if looks.ended { Vec::new() } else { device.take_checks().residuals });
                let looks = looks.residuals;
                assert_eq!(looks.len(), 2, "{} small {small:?}: {looks:?}", precision.name());
                assert_eq!(looks[0], 4.0);
                assert!(looks[1] == last || (last.is_nan() && !looks[1].is_finite()), "{looks:?}");
                // The iterate that was looked at last is still there.
                assert_eq!(device.downloaded(&x), [2e6; 10], "{} small {small:?}", precision.name());
            }
        }
    }
}
