//! The verbs of a midpoint step, one by one, against the CPU's: rows in the middle, what they start from, rows
//! tightened and appended, and where the step arrives and how fast.

use crate::device::{device, precisions};
use crate::rows::compare;
use relcp::bodies::Bodies;
use relcp::gpu::Precision;
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::step::{Keeper, Verbs};
use relcp::lcp::Problem;
use relcp::scene::{Rows, Scene, SolverKind};
use relcp::step::State;
use std::collections::HashMap;

/// What rows may differ by: in blocks of J relative to the largest entry, and in q relative to sizes and moves. The
/// multipliers of the first half are the CPU's to some epsilons (3e-7 in f32); where they push discs almost onto each
/// other, normals magnify that some hundredfold, in f64 as in f32 (1.5e-13 and 4e-5 measured).
const BOUNDS: [(Precision, f64, f64); 2] = [(Precision::F32, 8e-5, 3e-5), (Precision::F64, 3e-13, 1e-13)];

/// The same after solves, whose multipliers are as good as the residual.
const SOLVED_BOUND: f64 = 1e-11;
const RESIDUAL: f64 = 1e-13;

/// Sums of a few multipliers in 32 bits differ by less, as a part of them.
const ROUNDED_SUM: f64 = 1e-6;

const ROD: &str = r#"{"spherocylinder": {"diameter": 0.5, "length": 2}}"#;
const ELLIPSOID: &str = r#"{"ellipsoid": {"radii": [0.5, 0.8, 1.1]}}"#;
const RING: &str = r#"{"torus": {"major_radius": 0.7, "minor_radius": 0.2}}"#;
const INERTIA: &str = r#", "dynamics": {"inertial": {"density": 0.5}}"#;
const GROWTH: &str =
    r#", "growth": {"rate": 0.05, "division_length": 2.03, "division_length_noise": 0.05, "reorientation_degrees": 8}"#;
/// Without divisions, whose daughters lie in one line: in f32 it is then hardly settled where they touch.
const LENGTHENING: &str = r#", "growth": {"rate": 0.05, "division_length": 4, "rate_noise": 0.3}"#;

fn parse(name: &str, text: &str) -> Scene {
    Scene::parse(&format!(r#"{{"name": "{name}", "seed": 4, {text}}}"#), name).unwrap()
}

/// Bodies that are drawn together.
fn crowd(name: &str, shape: &str, dt: f64, more: &str) -> Scene {
    let text = format!(
        r#""time": {{"dt": {dt}, "end": 100, "stepping": "midpoint"}}, "forces": [{{"radial_inward": {{}}}}],
        "generate": [{{"isotropic": {{"count": 40, "shape": {shape}, "volume_fraction": 0.15}}}}] {more}"#
    );
    parse(name, &text)
}

/// Bodies that are driven apart, into walls.
fn outward(name: &str, shape: &str, dt: f64, more: &str) -> Scene {
    let text = format!(
        r#""time": {{"dt": {dt}, "end": 100, "stepping": "midpoint"}}, "forces": [{{"radial_outward": {{}}}}],
        "walls": [{{"half_space": {{"normal": [1, 2, -1], "offset": -20}}}}, {{"sphere": {{"center": [0.3, 0, 0], "radius": 7}}}}],
        "generate": [{{"isotropic": {{"count": 40, "shape": {shape}, "volume_fraction": 0.05}}}}] {more}"#
    );
    parse(name, &text)
}

/// Cells in a cell of space, some of which divide at once.
fn in_periods(name: &str, more: &str) -> Scene {
    let text = format!(
        r#""time": {{"dt": 1, "end": 100, "stepping": "midpoint"}}, "periodic": {{"lengths": [10, 10, 10]}},
        "forces": [{{"uniform": {{"force": [2, 1, 0.5], "group": "up"}}}}],
        "generate": [{{"isotropic": {{"count": 45, "shape": {ROD}, "volume_fraction": 0.0164, "group": "up"}}}},
                     {{"isotropic": {{"count": 45, "shape": {ROD}, "volume_fraction": 0.0164}}}}] {more}"#
    );
    parse(name, &text)
}

fn scenes() -> Vec<Scene> {
    let planar = format!(r#"{INERTIA}, "planar": true"#);
    vec![
        crowd("rods", ROD, 1.5, ""),
        crowd("ellipsoids with inertia", ELLIPSOID, 1.5, INERTIA),
        crowd("growing cells with inertia", ROD, 0.8, &format!("{INERTIA}{GROWTH}")),
        crowd("discs with inertia", r#"{"sphere": {"radius": 0.5}}"#, 2.5, &planar),
        outward("rings in a ball", RING, 3.0, ""),
        outward("growing cells with inertia in a ball", ROD, 1.0, &format!("{INERTIA}{LENGTHENING}")),
        in_periods("growing cells in periodic space", GROWTH),
    ]
}

/// Both backends at the start of a step.
struct Pair<const D: usize> {
    what: String,
    ours: Device,
    theirs: Cpu<D>,
    /// What is solved to; else every solve is of one iteration.
    residual: Option<f64>,
    bounds: (f64, f64),
}

impl<const D: usize> Pair<D> {
    fn both(&mut self, verb: impl Fn(&mut dyn Verbs)) {
        verb(&mut self.ours);
        verb(&mut self.theirs);
    }

    fn solve(&mut self) {
        let residual = self.residual;
        self.both(|backend| {
            let outcome = backend.solve(residual.unwrap_or(1e-9)).unwrap();
            assert!(residual.map_or(outcome.iterations == 1, |residual| outcome.residual <= residual), "{outcome:?}");
        });
    }

    fn compare(&self, which: &str) {
        assert!(compare(&format!("{}, {which}", self.what), &self.ours, &self.theirs, self.bounds));
    }

    /// The sums of the device's multipliers by pair of bodies.
    fn multipliers(&self) -> HashMap<[u32; 2], f64> {
        let (Problem { pair, .. }, gamma) = self.ours.lcp::<D>().unwrap();
        let mut sums = HashMap::new();
        for (pair, gamma) in pair.into_iter().zip(gamma) {
            *sums.entry(pair).or_insert(0.0) += gamma;
        }
        sums
    }

    /// The step's middle, and that its rows start from what those of the first half ended with.
    fn middle(&mut self) {
        self.both(|backend| backend.begin().unwrap());
        self.both(|backend| backend.append_near().unwrap());
        self.compare("first half");
        self.solve();
        let ended = self.multipliers();
        self.both(|backend| backend.middle().unwrap());
        self.both(|backend| backend.append_near().unwrap());
        self.compare("in the middle");
        let begun = self.multipliers();
        assert_eq!(self.ours.searches(), 2, "a list of the middle's own");
        // What branches without a row ended with is added to others.
        let apart = |(pair, gamma): (&[u32; 2], &f64)| (gamma - ended.get(pair).copied().unwrap_or(0.0)).abs();
        assert!(begun.iter().all(|row| apart(row) <= ROUNDED_SUM * row.1));
        assert!(begun.values().filter(|gamma| **gamma > 0.0).count() >= 1);
    }

    /// Offsets that moved, and rows that were appended, in one recursion by `tighten_violations`.
    fn tighten(&mut self, violating: f64) -> [usize; 2] {
        let (here, there) = (self.ours.trial(violating).unwrap(), self.theirs.trial(violating).unwrap());
        let off = (here.worst - there.worst).abs();
        println!("{}: worst overlap {:.6}, off by {off:.1e}, {} violations", self.what, there.worst, there.violations);
        assert!(off < (4.0 * self.bounds.1).max(1e-7 * there.worst), "{}: {off:e}", self.what);
        assert_eq!((here.violations, here.wall), (there.violations, there.wall), "{}", self.what);
        let before = (self.ours.lcp::<D>().unwrap().0, self.theirs.lcp().0.clone());
        self.both(|backend| backend.tighten_violations().unwrap());
        self.compare("tightened");
        let after = (self.ours.lcp::<D>().unwrap().0, self.theirs.lcp().0.clone());
        let [ours, theirs] = [moved(&before.0, &after.0), moved(&before.1, &after.1)];
        assert_eq!(ours, theirs, "{}", self.what);
        // Each violating pair has its turn, rods with each branch that does.
        assert!(ours[0] + ours[1] >= there.violations, "{}", self.what);
        ours
    }

    /// Where the step ends and how fast.
    fn accept(&mut self) {
        self.both(|backend| assert!(backend.accept().is_ok()));
        let (a, b) = (&self.ours.state().unwrap().bodies, &self.theirs.state().unwrap().bodies);
        assert_eq!(a.lineage, b.lineage);
        let [places, turns, speeds] = apart(a, b);
        println!(
            "{}: positions off by {places:.1e}, orientations by {turns:.1e}, velocities by {speeds:.1e}",
            self.what
        );
        let bound = 2.0 * self.bounds.1;
        assert!(places < bound && turns < bound && speeds < bound, "{}: {places:e} {turns:e} {speeds:e}", self.what);
        let length =
            |i: usize| a.shape[i].growing_length().map(|l| (l / b.shape[i].growing_length().unwrap() - 1.0).abs());
        assert!((0..a.len()).filter_map(length).all(|off| off < 1e-6), "{}", self.what);
    }
}

/// How many rows have another offset than before, and how many rows are new. Nothing else of a row has changed; new
/// rows of a body at a surface may stand between its old ones.
fn moved<const D: usize>(before: &Problem<D>, after: &Problem<D>) -> [usize; 2] {
    let by_pair = |problem: &Problem<D>| {
        let mut rows: HashMap<[u32; 2], Vec<_>> = HashMap::new();
        for (row, pair) in problem.pair.iter().enumerate() {
            rows.entry(*pair).or_default().push((problem.jacobian[row], problem.q[row]));
        }
        rows
    };
    let now = by_pair(after);
    let mut moved = 0;
    for (pair, old) in by_pair(before) {
        let mut rest = now[&pair].iter();
        for (block, before) in &old {
            let (_, after) = rest.find(|(same, _)| same == block).unwrap();
            assert!(after <= before);
            moved += usize::from(after < before);
        }
    }
    [moved, after.q.len() - before.q.len()]
}

/// How far positions, orientations and velocities are apart, the first and the last relative to one and their size.
fn apart(a: &Bodies, b: &Bodies) -> [f64; 3] {
    let worst = |of: &dyn Fn(usize) -> f64| (0..a.len()).map(of).fold(0.0, f64::max);
    [
        worst(&|i| (a.position[i] - b.position[i]).length() / (2.0 + b.position[i].length())),
        worst(&|i| {
            let (p, q) = (a.orientation[i], b.orientation[i]);
            (p - q).length().min((p + q).length())
        }),
        worst(&|i| {
            let linear = (a.velocity[i] - b.velocity[i]).length() / (1.0 + b.velocity[i].length());
            linear
                .max((a.angular_velocity[i] - b.angular_velocity[i]).length() / (1.0 + b.angular_velocity[i].length()))
        }),
    ]
}

/// One step; without a `residual` its solves are of one iteration, whose multipliers are the CPU's to rounding, and its
/// trials so far off that pairs have their turn with every kind of row. A solve that changes nothing leaves offsets
/// exact, and which of them a second recursion finds so is up to rounding: there is one. Returns how many offsets moved
/// and how many rows were appended.
fn check<const D: usize>(
    scene: &Scene,
    (precision, blocks, lengths): (Precision, f64, f64),
    residual: Option<f64>,
) -> [usize; 2] {
    let mut counts = [0; 2];
    let Some(gpu) = device() else { return counts };
    let mut scene = scene.clone();
    scene.solver.kind = SolverKind::PairBlockCg;
    if residual.is_none() {
        scene.solver.max_iterations = Some(1);
    }
    let state = || State { next_id: 1000, bodies: scene.build().unwrap(), ..State::default() };
    let mut pair = Pair {
        what: format!("{} {:?} {precision:?}", scene.name, scene.contact.rows),
        ours: Device::new(gpu.clone(), precision, &scene.model(), state()).unwrap(),
        theirs: Cpu::<D>::new(&scene.model(), state()).unwrap(),
        residual,
        bounds: (blocks, lengths),
    };
    pair.middle();
    pair.solve();
    let violating = scene.contact.overlap_tolerance;
    for _ in 0..if residual.is_some() { 2 } else { 1 } {
        let [tightened, appended] = pair.tighten(violating);
        counts = [counts[0] + tightened, counts[1] + appended];
        pair.solve();
    }
    pair.both(|backend| assert!(backend.trial(violating).is_ok()));
    pair.accept();
    counts
}

/// The scenes in every precision that there is a bound for.
fn check_all(scenes: &[Scene], bounds: &[(Precision, f64, f64)], residual: Option<f64>, least: [usize; 2]) {
    let Some(gpu) = device() else { return };
    if !bounds.iter().any(|bound| precisions(gpu).contains(&bound.0)) {
        println!("SKIP: {} has none of the precisions that there is a bound for", gpu.name());
        return;
    }
    let mut counts = [0; 2];
    let with_rows = |rows: Rows| scenes.iter().map(move |scene| (scene, rows));
    for (scene, rows) in with_rows(Rows::Paper).chain(with_rows(Rows::Auto)) {
        let mut scene = scene.clone();
        scene.contact.rows = rows;
        for bounds in bounds.iter().filter(|bound| precisions(gpu).contains(&bound.0)) {
            let [tightened, appended] = if scene.planar {
                check::<PLANAR>(&scene, *bounds, residual)
            } else {
                check::<SPATIAL>(&scene, *bounds, residual)
            };
            println!("{}: {tightened} offsets moved, {appended} rows appended", scene.name);
            counts = [counts[0] + tightened, counts[1] + appended];
        }
    }
    assert!(counts[0] >= least[0] && counts[1] >= least[1], "{counts:?}");
}

#[test]
fn rows_of_the_middle_are_the_cpus_and_tightened_alike() {
    check_all(&scenes(), &BOUNDS, None, [15, 60]);
}

#[test]
fn solved_steps_are_the_cpus_verb_by_verb() {
    // Contact in space, with inertia and with cells that divide.
    check_all(&scenes()[..3], &[(Precision::F64, SOLVED_BOUND, SOLVED_BOUND)], Some(RESIDUAL), [50, 3]);
}
