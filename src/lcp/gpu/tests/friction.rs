//! Tests of problems with friction: each verb on both backends, and whole solves against the law and the CPU.

use super::{near, with_empty_slots};
use crate::gpu::{Gpu, Precision, precisions, test_device};
use crate::lcp::drive::{Method, Point};
use crate::lcp::friction::packed::PackedContacts;
use crate::lcp::friction::tests::law::{check_law, cloud};
use crate::lcp::friction::{Cone, Frictional};
use crate::lcp::gpu::friction::Following;
use crate::lcp::gpu::layout::{Slots, Variant};
use crate::lcp::gpu::machine::Machine;
use crate::lcp::gpu::number::Number;
use crate::lcp::gpu::stage::{Stage, Work};
use crate::lcp::gpu::verbs::{Device, Slot};
use crate::lcp::gpu::{DeviceProblem, FrictionSolver};
use crate::lcp::verbs::{Scalar, Verbs};
use crate::lcp::{Outcome, Problem, Settings, Solver, SolverKind, Status, velocity};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::Instant;

/// Contacts of discs of radius 1 at random in the plane, some pairs with two.
fn discs(seed: u64, count: u32, compliance: f64) -> Problem<3> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let side = 1.9 * f64::from(count).sqrt();
    let place: Vec<[f64; 2]> = (0..count).map(|_| [0; 2].map(|_| side * rng.random::<f64>())).collect();
    let moves: Vec<[f64; 3]> = (0..count).map(|_| [0; 3].map(|_| 0.02 * (rng.random::<f64>() - 0.5))).collect();
    let mut problem = Problem { bodies: count as usize, ..Problem::default() };
    for a in 0..count {
        for b in a + 1..count {
            let apart: [f64; 2] = [0, 1].map(|k| place[b as usize][k] - place[a as usize][k]);
            let distance = apart[0].hypot(apart[1]);
            if distance > 2.02 {
                continue;
            }
            for contact in 0..rng.random_range(1..=3) {
                let turn = if contact == 0 { 0.0 } else { 0.4 * (rng.random::<f64>() - 0.5) };
                let angle = apart[1].atan2(apart[0]) + turn;
                let (n, mu) = ([angle.cos(), angle.sin()], rng.random::<f64>());
                for (row, d) in [n, [-n[1], n[0]]].into_iter().enumerate() {
                    let lever = if row == 0 { turn } else { 1.0 };
                    // With half the mass times the square of the radius as the moment of inertia.
                    let turned = -lever * 2.0_f64.sqrt();
                    let blocks = [[-d[0], -d[1], turned], [d[0], d[1], turned]];
                    let moved = |side: usize, body: u32| {
                        let [x, y, z] = moves[body as usize];
                        blocks[side][0] * x + blocks[side][1] * y - lever * z
                    };
                    let gap = if row == 0 { (distance - 2.0).max(-1e-3) } else { 0.0 };
                    problem.pair.push(if contact == 2 { [b, a] } else { [a, b] });
                    problem.jacobian.push(if contact == 2 { [blocks[1], blocks[0]] } else { blocks });
                    problem.q.push(gap + moved(0, a) + moved(1, b));
                    problem.cones.push(if row == 0 { Cone::Friction(mu) } else { Cone::Tangent });
                    problem.compliance.push(if row == 0 { 0.0 } else { compliance });
                }
            }
        }
    }
    problem
}

/// Spheres at random (`cloud`), every third contact twice, the second time a little turned.
fn spheres(seed: u64, count: u32, compliance: f64) -> Problem<6> {
    let mut problem = cloud(seed, count, |rng| rng.random::<f64>(), compliance);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for first in (0..problem.q.len()).step_by(9) {
        for row in first..first + 3 {
            let mut blocks = problem.jacobian[row];
            blocks.as_flattened_mut().iter_mut().for_each(|x| *x *= 1.0 + 0.1 * (rng.random::<f64>() - 0.5));
            problem.jacobian.push(blocks);
            problem.pair.push(problem.pair[row]);
            problem.q.push(problem.q[row]);
            problem.cones.push(problem.cones[row]);
            problem.compliance.push(problem.compliance[row]);
        }
    }
    problem
}

/// Rounds the numbers to those of the device.
fn rounded<const D: usize>(mut problem: Problem<D>) -> Problem<D> {
    let Problem { q, jacobian, compliance, cones, .. } = &mut problem;
    let numbers = q.iter_mut().chain(jacobian.as_flattened_mut().as_flattened_mut()).chain(compliance);
    numbers.for_each(|x| *x = f64::from(*x as f32));
    for cone in cones {
        if let Cone::Friction(mu) = cone {
            *mu = f64::from(*mu as f32);
        }
    }
    problem
}

/// The rows of contacts, and the problem on the device with the contact of each of its rows.
struct Uploaded {
    problem: DeviceProblem,
    contacts: PackedContacts,
    /// The normal row of each contact on the device.
    rows: Vec<usize>,
}

fn upload<const D: usize>(gpu: &Gpu, precision: Precision, problem: &Problem<D>, gamma: &[f64]) -> Uploaded {
    let normals: Vec<usize> = (0..problem.q.len()).filter(|row| problem.cones[*row] != Cone::Tangent).collect();
    let alone = Problem {
        bodies: problem.bodies,
        pair: normals.iter().map(|row| problem.pair[*row]).collect(),
        jacobian: normals.iter().map(|row| problem.jacobian[*row]).collect(),
        q: normals.iter().map(|row| problem.q[*row]).collect(),
        ..Problem::default()
    };
    let (mut uploaded, order) = DeviceProblem::upload(gpu, precision, &alone, &[]).unwrap();
    with_empty_slots(gpu, &mut uploaded);
    let rows: Vec<usize> = order.into_iter().map(|contact| normals[contact as usize]).collect();
    let mut contacts = PackedContacts::default();
    rows.iter().for_each(|row| contacts.push(problem, gamma, *row));
    Uploaded { problem: uploaded, contacts, rows }
}

/// Both backends. Vectors are in the order of the problem's rows.
struct Both<'a, const D: usize> {
    cpu: Frictional<D>,
    device: Device<'a>,
    /// The place of each row on the CPU, and of each of its numbers on the device.
    on_cpu: Vec<usize>,
    on_device: Vec<usize>,
    elements: usize,
}

impl<const D: usize> Both<'_, D> {
    fn to_cpu(&self, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; x.len()];
        self.on_cpu.iter().zip(x).for_each(|(place, x)| all[*place] = *x);
        all
    }

    fn upload(&mut self, x: &[f64]) -> Slot {
        let mut all = vec![0.0; 4 * self.elements];
        self.on_device.iter().zip(x).for_each(|(place, x)| all[*place] = *x);
        self.device.uploaded(&all)
    }

    fn from(&self, on_cpu: &[f64], on_device: &[f64]) -> [Vec<f64>; 2] {
        let of = |places: &[usize], numbers: &[f64]| places.iter().map(|place| numbers[*place]).collect();
        [of(&self.on_cpu, on_cpu), of(&self.on_device, on_device)]
    }

    /// A verb on both, from two vectors and what the third one is before.
    fn vector(&mut self, inputs: [&[f64]; 3], verb: Made) -> [Vec<f64>; 2] {
        let mut on_cpu = inputs.map(|x| self.to_cpu(x));
        let mut on_device = inputs.map(|x| self.upload(x));
        let Both { cpu, device, .. } = self;
        match verb {
            Made::Follow(due, times) => {
                let ([x, _, g], [a, _, b]) = (&mut on_cpu, &mut on_device);
                for _ in 0..times {
                    cpu.gradient(x, g);
                    if due > 0.0 {
                        cpu.follow(g);
                    }
                    device.gradient(a, b);
                    let due = device.number(due);
                    device.follow(due, b);
                }
            }
            _ => {
                make(cpu, verb, &mut on_cpu);
                make(device, verb, &mut on_device);
            }
        }
        let found = self.device.downloaded(&on_device[2]);
        self.from(&on_cpu[2], &found)
    }

    /// A number on both.
    fn number(&mut self, inputs: [&[f64]; 2], verb: Reduced) -> [f64; 2] {
        let [x, y] = inputs.map(|x| self.to_cpu(x));
        let on_cpu = match verb {
            Reduced::Dot => self.cpu.dot(&x, &y),
            Reduced::Room => self.cpu.ratio_test(&x, &y),
            Reduced::Residual(nth) => {
                let law = self.cpu.residual(&x, &y);
                [law, self.cpu.measured().cones, self.cpu.measured().change][nth]
            }
        };
        let [x, y] = inputs.map(|x| self.upload(x));
        let number = match verb {
            Reduced::Dot => self.device.dot(&x, &y),
            Reduced::Room => self.device.ratio_test(&x, &y),
            Reduced::Residual(nth) => {
                let law = self.device.residual(&x, &y);
                let (_, measured) = self.device.measured().unwrap();
                [law, measured.cones, measured.change][nth]
            }
        };
        [on_cpu, self.device.read(number)]
    }
}

#[derive(Clone, Copy, Debug)]
enum Reduced {
    Dot,
    Room,
    /// The law's, that with corrections held, and what corrections are off.
    Residual(usize),
}

#[derive(Clone, Copy, Debug)]
enum Made {
    Product,
    Gradient,
    Descend,
    Displace(f64),
    Advance(f64),
    /// The gradient, whose corrections follow if the number is positive, so many times.
    Follow(f64, usize),
}

fn make<V: Verbs>(verbs: &mut V, verb: Made, [x, y, out]: &mut [V::Vector; 3]) {
    match verb {
        Made::Product => verbs.product(x, out),
        Made::Gradient | Made::Follow(..) => verbs.gradient(x, out),
        Made::Descend => verbs.descend(x, y, out),
        Made::Displace(a) => {
            let (a, mut room) = (verbs.number(a), V::Vector::default());
            verbs.clear(&mut room);
            verbs.displace(x, [(a, y), (a, x), (-a, x)], out, &mut room);
        }
        Made::Advance(a) => {
            let a = verbs.number(a);
            verbs.copy(x, out);
            verbs.advance(a, y, out, x);
        }
    }
}

/// Compares the verbs on a problem. `x` are multipliers, `y` is arbitrary.
fn compare<const D: usize>(gpu: &Gpu, precision: Precision, what: &str, problem: &Problem<D>) {
    let bound = if precision == Precision::F32 { 1e-5 } else { 1e-11 };
    // Blocks are regularized by more in f32.
    let of_blocks = if precision == Precision::F32 { 3e-3 } else { 1e-8 };
    let variant = Variant::of(gpu, precision, D == 3, Slots::of_friction());
    let mut machine = Machine::new(gpu, variant).unwrap();
    let Uploaded { problem: uploaded, contacts, rows } = upload(gpu, precision, problem, &[]);
    machine.write_contacts(gpu, &contacts).unwrap();
    let mut cpu = Frictional::<D>::default();
    cpu.rebuild(problem);
    let numbered: Vec<f64> = (0..problem.q.len()).map(|place| place as f64).collect();
    let mut on_cpu = vec![0.0; numbered.len()];
    cpu.export(&numbered, &mut on_cpu);
    let mut on_device = vec![0; numbered.len()];
    for (element, row) in rows.iter().enumerate() {
        (0..if D == 3 { 2 } else { 3 }).for_each(|at| on_device[row + at] = 4 * element + at);
    }
    let mut device = Device::new(gpu, &mut machine, &uploaded);
    device.prepare();
    let on_cpu = on_cpu.into_iter().map(|place| place as usize).collect();
    let mut both = Both { cpu, device, on_cpu, on_device, elements: rows.len() };
    let random = |seed: u64| super::vector(seed, problem.q.len(), 0.0);
    let (mut x, y) = (Vec::new(), random(2));
    both.cpu.import(&random(1), &mut x);
    let mut start = vec![0.0; y.len()];
    both.cpu.export(&x, &mut start);
    let start: Vec<f64> = start.into_iter().map(|x| f64::from(x as f32)).collect();
    // The room of multipliers that rounding moved out of their cone is zero or not.
    let widened = |(x, cone): (&f64, &Cone)| if matches!(cone, Cone::Friction(_)) { 1.25 * x } else { *x };
    let inner: Vec<f64> = start.iter().zip(&problem.cones).map(widened).collect();
    let vectors = [
        Made::Product,
        Made::Gradient,
        Made::Advance(0.75),
        Made::Advance(-1.5),
        Made::Descend,
        Made::Displace(0.75),
        Made::Follow(0.0, 1),
        Made::Follow(1.0, 4),
    ];
    let numbers = [Reduced::Dot, Reduced::Room, Reduced::Residual(0), Reduced::Residual(1), Reduced::Residual(2)];
    for verb in vectors {
        let [cpu, device] = both.vector([&start, &y, &y], verb);
        let bound = if matches!(verb, Made::Descend | Made::Displace(_)) { of_blocks } else { bound };
        near(&cpu, &device, bound).unwrap_or_else(|e| panic!("{what} {verb:?}: {e}"));
    }
    for verb in numbers {
        let [cpu, device] = both.number([&inner, &y], verb);
        near(&[cpu], &[device], bound * (y.len() as f64).sqrt()).unwrap_or_else(|e| panic!("{what} {verb:?}: {e}"));
    }
}

#[test]
fn verbs_on_contacts_are_those_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        for (count, compliance) in [(4, 0.0), (60, 0.0), (150, 1e-2)] {
            let what = format!("{} {count}", precision.name());
            compare(gpu, precision, &format!("{what} discs"), &rounded(discs(1, count, compliance)));
            compare(gpu, precision, &format!("{what} spheres"), &rounded(spheres(2, count, compliance)));
        }
    }
}

/// A solve on the device from these multipliers, which become those found.
fn solved<const D: usize>(
    gpu: &Gpu,
    precision: Precision,
    problem: &Problem<D>,
    settings: Settings,
    gamma: &mut Vec<f64>,
) -> Outcome {
    let mut solver = FrictionSolver::new(gpu, precision, D == 3, settings).unwrap();
    gamma.resize(problem.q.len(), 0.0);
    let Uploaded { problem: uploaded, contacts, rows } = upload(gpu, precision, problem, gamma);
    let (outcome, found) = solver.solve(gpu, &uploaded, &contacts).unwrap();
    for (numbers, row) in found.chunks(4).zip(rows) {
        PackedContacts::take(numbers, problem, gamma, row);
    }
    outcome
}

/// A tolerance that a precision reaches.
fn tolerance_of(precision: Precision) -> f64 {
    if precision == Precision::F32 { 1e-6 } else { 1e-9 }
}

/// Solves on the device and checks the law, as far as it was solved. Returns the multipliers, and whether it was.
fn check_solve<const D: usize>(gpu: &Gpu, precision: Precision, what: &str, problem: &Problem<D>) -> (Vec<f64>, bool) {
    let tolerance = tolerance_of(precision);
    let settings = Settings { tolerance, max_iterations: 20_000 };
    let mut gamma = Vec::new();
    let outcome = solved(gpu, precision, problem, settings, &mut gamma);
    println!("{what}: {:?}, {} iterations, residual {:.1e}", outcome.status, outcome.iterations, outcome.residual);
    // The same bits come twice, and a start at the solution takes few iterations.
    let mut again = Vec::new();
    let second = solved(gpu, precision, problem, settings, &mut again);
    assert_eq!((second, &again), (outcome, &gamma), "{what}");
    let is_solved = outcome.status == Status::Solved;
    if is_solved {
        let settings = Settings { tolerance: 10.0 * tolerance, ..settings };
        let after = solved(gpu, precision, problem, settings, &mut again);
        assert!(after.iterations <= 20, "{what}: {after:?}");
    }
    // Rounded multipliers may be out of their cone by a rounding.
    let mut cpu = Frictional::<D>::default();
    cpu.rebuild(problem);
    let mut x = Vec::new();
    cpu.import(&gamma, &mut x);
    cpu.export(&x, &mut gamma);
    assert_eq!(is_solved, outcome.residual <= tolerance, "{what}: {outcome:?}");
    check_law(problem, &gamma, 2.0 * outcome.residual.max(tolerance));
    (gamma, is_solved)
}

#[test]
fn solves_obey_the_exact_law() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        let mut solved = 0;
        for (seed, compliance) in [(1, 0.0), (2, 1e-3), (3, 1e-2)] {
            let what = format!("{} {seed}", precision.name());
            let (discs, spheres) = (rounded(discs(seed, 80, compliance)), rounded(spheres(seed, 60, compliance)));
            solved += usize::from(check_solve(gpu, precision, &format!("{what} discs"), &discs).1);
            solved += usize::from(check_solve(gpu, precision, &format!("{what} spheres"), &spheres).1);
        }
        // Rigid contacts are hard, also for the CPU: it takes 3,358 iterations for the discs without compliance.
        assert!(solved >= 4, "{}: {solved} of 6", precision.name());
    }
}

#[test]
fn velocities_are_those_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    for (seed, compliance) in [(1, 0.0), (2, 0.0), (3, 1e-3), (4, 1e-4)] {
        // The solvers of the CPU agree on these (`lcp::friction::tests::law`).
        let problem = rounded(cloud(seed, 60, |rng| rng.random_range(0.2..1.0), compliance));
        let mut exact = Vec::new();
        let settings = Settings { tolerance: 1e-10, max_iterations: 20_000 };
        Solver::new(SolverKind::PairBlockCg, settings).solve(&problem, &mut exact);
        for precision in precisions(gpu) {
            let (gamma, is_solved) = check_solve(gpu, precision, &format!("{} {seed}", precision.name()), &problem);
            assert!(is_solved, "{} {seed}", precision.name());
            let [a, b] = [velocity(&problem, &gamma), velocity(&problem, &exact)];
            let off =
                a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()));
            println!("{} {seed}: velocities differ by {off:.1e}", precision.name());
            assert!(off < 1e3 * tolerance_of(precision), "{seed}: {off:e}");
        }
    }
}

#[test]
fn an_iteration_on_contacts_is_five_dispatches() {
    let Some(gpu) = test_device() else { return };
    let problem = rounded(spheres(1, 60, 0.0));
    for precision in precisions(gpu) {
        let mut machine = Machine::new(gpu, Variant::of(gpu, precision, false, Slots::of_friction())).unwrap();
        let Uploaded { problem: uploaded, contacts, .. } = upload(gpu, precision, &problem, &[]);
        machine.write_contacts(gpu, &contacts).unwrap();
        let mut device = Device::new(gpu, &mut machine, &uploaded);
        device.prepare();
        let mut at = Point { x: device.start(), g: Slot::default() };
        let (mut method, mut best) = (Following::new(), Slot::default());
        device.gradient(&at.x, &mut at.g);
        method.begin(&mut device, &at);
        let mut least = device.residual(&at.x, &at.g);
        for _ in 0..8 {
            method.step(&mut device, &mut at);
            let residual = device.residual(&at.x, &at.g);
            device.copy_if_positive(least - residual, &at.x, &mut best);
            least = least.min(residual);
            device.check(residual, 1e-6);
        }
        let is_bodies = |stage: &Stage| matches!(stage.work, Work::Bodies(_));
        let stages = &device.tape.stages;
        let bodies: Vec<usize> = (0..stages.len()).filter(|stage| is_bodies(&stages[*stage])).collect();
        let spans: Vec<usize> = bodies[2..].windows(2).map(|pair| pair[1] - pair[0]).collect();
        println!("{}: {spans:?} dispatches an iteration", precision.name());
        assert!(spans.iter().all(|span| *span <= 5), "{spans:?}");
    }
}

/// Seconds of solves on the device and on the CPU (`--ignored --nocapture`).
#[test]
#[ignore = "timings"]
fn times_of_solves() {
    let Some(gpu) = test_device() else { return };
    let settings = Settings { tolerance: 1e-7, max_iterations: 200 };
    for count in [60, 300, 1_500, 6_000] {
        let problem = rounded(cloud(1, count, |_| 0.5, 1e-3));
        let begun = Instant::now();
        let on_cpu = Solver::new(SolverKind::PairBlockCg, settings).solve(&problem, &mut Vec::new());
        let each = |time: Instant, outcome: &Outcome| 1e6 * time.elapsed().as_secs_f64() / outcome.iterations as f64;
        let mut line = format!("{} contacts: CPU {:.0} us an iteration", problem.q.len() / 3, each(begun, &on_cpu));
        for precision in precisions(gpu) {
            let Uploaded { problem: uploaded, contacts, .. } = upload(gpu, precision, &problem, &[]);
            let mut solver = FrictionSolver::new(gpu, precision, false, settings).unwrap();
            solver.solve(gpu, &uploaded, &contacts).unwrap();
            let begun = Instant::now();
            let (outcome, _) = solver.solve(gpu, &uploaded, &contacts).unwrap();
            line += &format!(", {} {:.0} us", precision.name(), each(begun, &outcome));
        }
        println!("{line}");
    }
}

#[test]
fn numbers_that_are_not_finite_end_a_solve() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        for (row, number) in [(0, f64::NAN), (0, f64::INFINITY), (4, f64::NAN), (5, f64::NEG_INFINITY)] {
            let mut problem = rounded(spheres(1, 20, 0.0));
            problem.q[row] = number;
            let settings = Settings { tolerance: 1e-6, max_iterations: 1_000 };
            let outcome = solved(gpu, precision, &problem, settings, &mut Vec::new());
            assert_eq!(outcome.status, Status::NotFinite, "{} {row} {number}: {outcome:?}", precision.name());
        }
    }
}

#[test]
fn without_friction_tangents_count_nothing() {
    let Some(gpu) = test_device() else { return };
    let mut problem = rounded(spheres(4, 40, 0.0));
    problem.cones.iter_mut().for_each(|cone| {
        if let Cone::Friction(mu) = cone {
            *mu = 0.0;
        }
    });
    for precision in precisions(gpu) {
        let tolerance = if precision == Precision::F32 { 1e-6 } else { 1e-10 };
        let settings = Settings { tolerance, max_iterations: 20_000 };
        let mut gamma = vec![1.0; problem.q.len()];
        let outcome = solved(gpu, precision, &problem, settings, &mut gamma);
        assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
        assert!(gamma.iter().zip(&problem.cones).all(|(gamma, cone)| *cone != Cone::Tangent || *gamma == 0.0));
        check_law(&problem, &gamma, 2.0 * tolerance);
    }
}

/// A number of the tolerance can be read.
#[test]
fn the_tolerance_is_known_to_the_host() {
    let Some(gpu) = test_device() else { return };
    let problem = rounded(spheres(1, 20, 0.0));
    let variant = Variant::of(gpu, Precision::F32, false, Slots::of_friction());
    let mut machine = Machine::new(gpu, variant).unwrap();
    machine.tolerance = 0.25;
    let Uploaded { problem: uploaded, contacts, .. } = upload(gpu, Precision::F32, &problem, &[]);
    machine.write_contacts(gpu, &contacts).unwrap();
    let mut device = Device::new(gpu, &mut machine, &uploaded);
    let twice = Number::Tolerance + Number::Tolerance;
    assert_eq!([device.read(Number::Tolerance), device.read(twice)], [0.25, 0.5]);
}
