//! Tests of the stages of an iteration: their number, bytes and arithmetic, and the end of a batch.

use super::{machine, problem};
use crate::gpu::{Precision, precisions, test_device};
use crate::lcp::SolverKind;
use crate::lcp::cluster_cg::ClusterCg;
use crate::lcp::drive::{Method, Point};
use crate::lcp::gpu::DeviceProblem;
use crate::lcp::gpu::elements::Elements;
use crate::lcp::gpu::shape::StageArguments;
use crate::lcp::gpu::stage::{Stage, Work};
use crate::lcp::gpu::verbs::{Device, Slot};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::verbs::{Scalar, Verbs};

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

/// Bytes that an iteration moves per row of a planar problem, with each element of an array counted once per dispatch.
fn bytes_of_a_row(stages: &[StageArguments], real: f64, bodies_of_a_row: f64) -> f64 {
    stages
        .iter()
        .map(|arguments| {
            let text = arguments.shape.entry_point(Elements::Rows, |x| format!("{x}"));
            // Vectors are named by their index among the parameters. Conditional copies are not executed in most
            // iterations.
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
                .variables(Elements::Rows)
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
        // Crowded cells have 2.8 rows per body.
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
                // Of the residuals 4, 0.25 or NaN, and 0.125, the second one ends the batch. The iterates are so large
                // that the gradient is the residual.
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
                // The iterate of the last check is unchanged.
                assert_eq!(device.downloaded(&x), [2e6; 10], "{} small {small:?}", precision.name());
            }
        }
    }
}
