//! Rows by branches, verb by verb, against the CPU's: which branches of which pairs get a row, ahead of the step's
//! start in the plane, what they start from, and how violations move them or add to them.

use crate::device::{device, precisions};
use crate::rows::compare;
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::step::Verbs;
use relcp::scene::{self, Body, Scene, SolverKind};
use relcp::simulation::Simulation;
use relcp::step::State;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// What rows may differ by: in blocks of J relative to the largest entry, and in q relative to sizes and moves; and
/// what multipliers may differ by, relative to the largest.
const BOUNDS: [(Precision, (f64, f64), f64); 2] =
    [(Precision::F32, (3e-5, 1e-5), 1e-4), (Precision::F64, (1e-12, 1e-12), 1e-11)];

const STEPS: usize = 2;

/// From which overlap on pairs violate: far over the differences, so that the same do.
const VIOLATING: f64 = 1e-3;

const ROD: &str = r#"{"spherocylinder": {"diameter": 0.5, "length": 2}}"#;
const RING: &str = r#"{"torus": {"major_radius": 0.4, "minor_radius": 0.25}}"#;
const LARGE_RING: &str = r#"{"torus": {"major_radius": 0.5, "minor_radius": 0.3}}"#;
const EGG: &str = r#"{"ellipsoid": {"radii": [0.3, 0.5, 0.9]}}"#;
const LONG: &str = r#"{"spherocylinder": {"diameter": 0.5, "length": 4}}"#;

/// Bodies that are drawn together; a solve has one iteration, so that multipliers are the CPU's to rounding and bodies
/// overlap.
fn crowd(name: &str, shapes: &[&str], dt: f64, fraction: f64, more: &str) -> Scene {
    let group = |shape: &&str| {
        let fraction = fraction / shapes.len() as f64;
        format!(r#"{{"isotropic": {{"count": 40, "shape": {shape}, "volume_fraction": {fraction}}}}}"#)
    };
    let groups: Vec<String> = shapes.iter().map(group).collect();
    let text = format!(
        r#"{{"name": "{name}", "seed": 4, "time": {{"dt": {dt}, "end": 100 {more}, "solver": {{"kind": "pair_block_cg", "max_iterations": 1}},
        "forces": [{{"radial_inward": {{}}}}], "generate": [{}]}}"#,
        groups.join(", ")
    );
    Scene::parse(&text, name).unwrap()
}

/// The same in the plane: bodies on a grid, turned at random, drawn together or, in walls, apart.
fn flat(name: &str, shapes: &[&str], dt: f64, more: &str) -> Scene {
    let body = |i: usize| {
        let turn = DQuat::from_rotation_z((7.3 * i as f64).sin() * 2.0) * DQuat::from_rotation_x(FRAC_PI_2);
        let [x, y] = [(i % 8) as f64 * 1.5 - 5.3, (i / 8) as f64 * 2.1 - 4.1];
        let DQuat { x: qx, y: qy, z: qz, w: qw } = turn;
        let shape = shapes[i % shapes.len()];
        format!(r#"{{"shape": {shape}, "position": [{x}, {y}, 0], "orientation": [{qw}, {qx}, {qy}, {qz}]}}"#)
    };
    let bodies: Vec<String> = (0..40).map(body).collect();
    let way = if more.contains("walls") { "radial_outward" } else { "radial_inward" };
    let text = format!(
        r#"{{"name": "{name}", "seed": 4, "planar": true, "time": {{"dt": {dt}, "end": 100 {more}, "solver": {{"kind": "pair_block_cg", "max_iterations": 1}},
        "forces": [{{"{way}": {{}}}}], "bodies": [{}]}}"#,
        bodies.join(", ")
    );
    Scene::parse(&text, name).unwrap()
}

/// Bodies in a cell of space, half of which move.
fn in_periods(name: &str) -> Scene {
    let text = format!(
        r#"{{"name": "{name}", "seed": 4, "time": {{"dt": 0.6, "end": 100}}, "periodic": {{"lengths": [7, 7, 7]}},
        "solver": {{"kind": "pair_block_cg", "max_iterations": 1}}, "forces": [{{"uniform": {{"force": [2, 1, 0.5], "group": "up"}}}}],
        "generate": [{{"isotropic": {{"count": 45, "shape": {ROD}, "volume_fraction": 0.0478, "group": "up"}}}},
                     {{"isotropic": {{"count": 45, "shape": {ROD}, "volume_fraction": 0.0478}}}}]}}"#
    );
    Scene::parse(&text, name).unwrap()
}

/// A sheet of linked rings that is drawn out until pairs touch in two places.
fn taut(name: &str) -> Scene {
    let sheet = ["generate.0.chainmail.columns=4", "generate.0.chainmail.rows=4", "time.dt=0.01", "time.end=1.3"];
    let mut scene = Scene::load("chainmail", sheet).unwrap();
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    let bodies = &simulation.state().unwrap().bodies;
    let body = |i: usize| {
        let DQuat { x, y, z, w } = bodies.orientation[i];
        let mut body = Body::new(bodies.shape[i], bodies.position[i].to_array());
        body.orientation = Some([w, x, y, z]);
        body
    };
    scene.bodies = (0..bodies.len()).map(body).collect();
    scene.generate.clear();
    scene.name = name.into();
    (scene.time.dt, scene.time.end) = (0.02, 100.0);
    (scene.solver.kind, scene.solver.max_iterations) = (SolverKind::PairBlockCg, Some(1));
    scene
}

fn scenes() -> Vec<Scene> {
    let inertia = r#"}, "dynamics": {"inertial": {"density": 2}}"#;
    let disc = r#"}, "walls": [{"sphere": {"center": [0, 0, 0], "radius": 7.7}}]"#;
    let growth = r#"}, "growth": {"rate": 0.05, "division_length": 2.03, "division_length_noise": 0.05, "reorientation_degrees": 8}"#;
    let sphere = r#"{"sphere": {"radius": 0.5}}"#;
    let midpoint = r#", "stepping": "midpoint""#;
    vec![
        crowd("rods", &[ROD], 0.6, 0.2, "}"),
        crowd("rods of two lengths with inertia", &[ROD, LONG], 0.35, 0.2, inertia),
        in_periods("rods in periodic space"),
        taut("taut chainmail"),
        crowd("rings of two sizes", &[RING, LARGE_RING], 0.8, 0.14, "}"),
        crowd("rings by midpoint", &[RING, LARGE_RING], 1.6, 0.14, &format!("{midpoint}}}")),
        crowd("rings and rods", &[RING, LONG], 0.8, 0.14, "}"),
        crowd("rings and ellipsoids", &[LARGE_RING, EGG], 0.8, 0.2, "}"),
        crowd("rods by midpoint", &[ROD], 1.2, 0.2, &format!("{midpoint}}}")),
        crowd("growing cells by midpoint", &[ROD], 0.8, 0.2, &format!("{midpoint}{growth}")),
        flat("rods in the plane", &[ROD], 0.4, "}"),
        flat("rods and discs in the plane", &[ROD, sphere], 0.4, "}"),
        flat("discs in the plane", &[r#"{"sphere": {"radius": 0.74}}"#], 0.8, "}"),
        flat("rods with inertia in the plane", &[ROD], 0.6, inertia),
        flat("rods in a disc", &[ROD], 0.4, disc),
        flat("cells in the plane", &[ROD], 0.4, growth),
        flat("cells in the plane by midpoint", &[ROD], 0.8, &format!("{midpoint}{growth}")),
    ]
}

struct Both<const D: usize> {
    what: String,
    ours: Device,
    theirs: Cpu<D>,
    bounds: (f64, f64),
    gamma: f64,
}

impl<const D: usize> Both<D> {
    fn verb(&mut self, verb: impl Fn(&mut dyn Verbs)) {
        verb(&mut self.ours);
        verb(&mut self.theirs);
    }

    fn compare(&self, which: &str) -> bool {
        compare(&format!("{}, {which}", self.what), &self.ours, &self.theirs, self.bounds)
    }

    /// The multipliers that rows start from; the rows are known to be alike. Returns how many push.
    fn compare_multipliers(&self) -> usize {
        let ((ours, a), (theirs, b)) = (self.ours.lcp::<D>().unwrap(), self.theirs.lcp());
        let ordered = |pairs: &[[u32; 2]], gamma: &[f64]| {
            let mut rows: Vec<([u32; 2], f64)> = pairs.iter().copied().zip(gamma.iter().copied()).collect();
            rows.sort_by_key(|row| row.0);
            // Places at surfaces stand in an order of their own.
            rows.retain(|row| (row.0[1] as usize) < ours.bodies);
            rows
        };
        let (a, b) = (ordered(&ours.pair, &a), ordered(&theirs.pair, b));
        let largest = b.iter().fold(0.0, |m: f64, row| m.max(row.1));
        let off = a.iter().zip(&b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max);
        assert!(off <= self.gamma * largest, "{}: multipliers off by {off:e} of {largest:e}", self.what);
        b.iter().filter(|row| row.1 > 0.0).count()
    }

    fn solve(&mut self) {
        self.verb(|backend| assert_eq!(backend.solve(1e-12).unwrap().iterations, 1));
    }

    fn trial(&mut self, violating: f64) -> usize {
        let (here, there) = (self.ours.trial(violating).unwrap(), self.theirs.trial(violating).unwrap());
        assert_eq!((here.violations, here.wall), (there.violations, there.wall), "{}", self.what);
        here.violations
    }

    /// One step with a recursion of each kind; how many multipliers first rows started from, and how many violations
    /// there were; nothing where a tie ended the comparison.
    fn step(&mut self, midpoint: bool, violating: f64) -> Option<[usize; 2]> {
        self.verb(|backend| backend.begin().unwrap());
        self.verb(|backend| backend.append_near().unwrap());
        if !self.compare("first rows") {
            return None;
        }
        let started = self.compare_multipliers();
        self.solve();
        if midpoint {
            self.verb(|backend| backend.middle().unwrap());
            self.verb(|backend| backend.append_near().unwrap());
            if !self.compare("in the middle") {
                return None;
            }
            self.compare_multipliers();
            self.solve();
        }
        let violations = self.trial(violating);
        self.verb(|backend| backend.tighten_violations().unwrap());
        if !self.compare("tightened") {
            return None;
        }
        self.solve();
        self.trial(violating);
        self.verb(|backend| backend.append_violations(true).unwrap());
        if !self.compare("appended") {
            return None;
        }
        self.solve();
        self.trial(violating);
        self.verb(|backend| assert!(backend.accept().is_ok()));
        Some([started, violations])
    }
}

/// A scene's bodies, with velocities in the plane that lead to no deep overlap in the first step.
fn moving(scene: &Scene) -> Bodies {
    let mut bodies = scene.build().unwrap();
    if scene.planar {
        for i in 0..bodies.len() {
            let [u, v, w] = [1.7, 2.3, 3.1].map(|k| 0.2 * (k * i as f64).sin());
            (bodies.velocity[i], bodies.angular_velocity[i]) = (DVec3::new(u, v, 0.0), DVec3::new(0.0, 0.0, w));
        }
    }
    bodies
}

/// How many multipliers first rows started from; counts comparisons that no tie ended.
fn check<const D: usize>(gpu: &Arc<Gpu>, scene: &Scene, whole: &mut usize) -> usize {
    let mut started = 0;
    let state = || State { next_id: 1000, bodies: moving(scene), ..State::default() };
    for (precision, bounds, gamma) in BOUNDS.into_iter().filter(|b| precisions(gpu).contains(&b.0)) {
        let mut both = Both {
            what: format!("{} {precision:?}", scene.name),
            ours: Device::new(gpu.clone(), precision, &scene.model(), state()).unwrap(),
            theirs: Cpu::<D>::new(&scene.model(), state()).unwrap(),
            bounds,
            gamma,
        };
        let midpoint = scene.time.stepping == scene::Stepping::Midpoint;
        let mut counts = [0; 2];
        let mut steps = 0;
        while steps < STEPS
            && let Some([pushing, violations]) = both.step(midpoint, VIOLATING)
        {
            counts = [counts[0] + pushing, counts[1] + violations];
            steps += 1;
        }
        println!("{}: {counts:?} multipliers and violations in {steps} steps", both.what);
        assert!(counts[1] > 3 || steps < STEPS, "{}: {counts:?}", both.what);
        started += counts[0];
        *whole += usize::from(steps == STEPS);
    }
    started
}

#[test]
fn rows_by_branches_are_the_cpus() {
    // Says SKIP where there is no device, and fails where one is required.
    let Some(gpu) = device() else { return };
    let (scenes, mut whole) = (scenes(), 0);
    let mut check = |scene: &Scene| match scene.planar {
        true => check::<PLANAR>(gpu, scene, &mut whole),
        false => check::<SPATIAL>(gpu, scene, &mut whole),
    };
    let started: usize = scenes.iter().map(&mut check).sum();
    assert!(started > 100, "{started}");
    // Ties are rare: one of twelve scenes in f32 on an NVIDIA H200.
    assert!(whole + 2 >= scenes.len() * precisions(gpu).len(), "{whole}");
}
