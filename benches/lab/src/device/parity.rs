//! Comparison of a device's results with those of the CPU: separations of all families of pairs, the rows of a step,
//! solves, whole steps. The bounds are in the tables "Differences from the CPU, results" and "by stage" in
//! docs/notes/gpu.md; tests check them on a device. Here fewer cases are drawn, so that a minute is
//! enough.

use crate::StudyError;
use crate::solvers::built_in;
use crate::throughput::{Kind, start};
use glam::{DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::bodies::Bodies;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::lcp::gpu::{DeviceProblem, Solver};
use relcp::internals::step::Verbs;
use relcp::lcp::{Problem, Settings, Stored};
use relcp::scene::{Scene, SolverKind};
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;
use relcp::simulation::{Compute, Simulation};
use relcp::step::State;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The seed of pairs and poses.
const SEED: u64 = 7;

/// Number of pairs per two kinds of shapes.
const PAIRS: usize = 200;

/// The distance between pairs, so that different pairs do not touch.
const SPACING: f64 = 20.0;

/// The largest ratio of two sizes of a shape.
const ASPECT: f64 = 3.0;

/// The range of separations, in thicknesses.
const SEPARATIONS: std::ops::Range<f64> = -0.2..0.5;

/// Steps of a scene, and the number of bodies in scenes that are parts of dense states.
const STEPS: usize = 20;
const DENSE: usize = 300;

/// The largest number of iterations of a solve.
const MOST_ITERATIONS: u64 = 20_000;

/// Replaces a value that is not a number.
const NOT_A_NUMBER: f64 = f64::MAX;

/// A largest difference and its bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    pub what: String,
    pub precision: String,
    /// Pairs, rows, or bodies compared.
    pub compared: usize,
    pub largest: f64,
    pub bound: f64,
    pub held: bool,
}

impl Check {
    fn new(what: String, precision: Precision, compared: usize, largest: f64, [f32, f64]: [f64; 2]) -> Check {
        let bound = match precision {
            Precision::F32 => f32,
            Precision::F64 => f64,
        };
        let largest = if largest.is_finite() { largest } else { NOT_A_NUMBER };
        Check { what, precision: precision.name().into(), compared, largest, bound, held: largest <= bound }
    }
}

/// Returns the larger of two values. A NaN is larger than every number.
fn larger(a: f64, b: f64) -> f64 {
    if b.is_nan() || b > a { b } else { a }
}

/// Parses a scene that this file writes.
fn parsed(text: &str) -> Result<Scene, StudyError> {
    Ok(Scene::parse(text, "the study of a device")?)
}

fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

fn shape(kind: usize, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || ASPECT.powf(random.random_range(0.0..1.0));
    match kind {
        0 => Shape::Sphere { radius: 0.5 * ratio() },
        1 => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        2 => Shape::Ellipsoid { radii: [0.5 * ratio(), 0.5, 0.5 * ratio()] },
        _ => Shape::Torus { major_radius: 0.5 + ratio(), minor_radius: 0.5 },
    }
}

/// Draws pairs near contact, each far from the others.
fn pairs(kinds: [usize; 2], random: &mut ChaCha8Rng) -> Bodies {
    let mut bodies = Bodies::default();
    let side = (PAIRS as f64).cbrt().ceil() as usize;
    for place in 0..PAIRS {
        let at = [place % side, place / side % side, place / side / side].map(|k| SPACING * k as f64);
        let [shape_a, shape_b] = kinds.map(|kind| shape(kind, random));
        let a = Placed { shape: shape_a, position: DVec3::from_array(at), orientation: turn(random) };
        let away = turn(random) * DVec3::Z;
        let mut distance = shape_a.bounding_radius() + shape_b.bounding_radius();
        let orientation = turn(random);
        let b = |distance: f64| Placed { shape: shape_b, position: a.position + distance * away, orientation };
        let wanted = random.random_range(SEPARATIONS);
        // Along a fixed line, a separation decreases no faster than the distance.
        if let Some(found) = separation(&a, &b(distance), None) {
            distance -= (found.separation - wanted).max(0.0);
        }
        bodies.push(a, 0);
        bodies.push(b(distance), 0);
    }
    bodies
}

/// Compares separations, and points along the normal, of pairs of all kinds and of bodies at walls.
pub fn separations(gpu: &Arc<Gpu>, precision: Precision) -> Result<Vec<Check>, StudyError> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut checks = Vec::new();
    for kinds in (0..4).flat_map(|a| (a..4).map(move |b| [a, b])) {
        let bodies = pairs(kinds, &mut random);
        checks.push(of_pairs(gpu, precision, &bodies)?);
    }
    checks.push(of_walls(gpu, precision, &mut random)?);
    Ok(checks)
}

fn of_pairs(gpu: &Arc<Gpu>, precision: Precision, bodies: &Bodies) -> Result<Check, StudyError> {
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let cutoff = 2.0 * SEPARATIONS.end;
    let ours: BTreeMap<_, _> =
        compute.contacts(bodies, cutoff)?.into_iter().map(|contact| (contact.bodies, contact)).collect();
    let theirs = relcp::step::contacts(bodies, cutoff);
    let mut largest = 0.0;
    for expected in &theirs {
        let [a, b] = expected.bodies;
        let apart = bodies.position[b] - bodies.position[a];
        let size = bodies.shape[a].bounding_radius() + bodies.shape[b].bounding_radius() + apart.length();
        let Some(found) = ours.get(&expected.bodies) else {
            // A separation at the cutoff may be missing.
            largest = larger(largest, (expected.separation - cutoff).abs() / size);
            continue;
        };
        let along = (apart + found.levers[1] - found.levers[0]).dot(found.normal);
        largest = larger(largest, (found.separation - expected.separation).abs() / size);
        largest = larger(largest, (along - found.separation).abs() / size);
    }
    let what = format!("separations and points: {}, {}", bodies.shape[0].name(), bodies.shape[1].name());
    Ok(Check::new(what, precision, theirs.len(), largest, [2e-6, 1e-11]))
}

const WALLED: &str = r#"{"name": "walls", "time": {"dt": 0.1, "end": 1},
    "walls": [{"box": {"minimum": [-9, -9, -9], "maximum": [9, 9, 9]}}, {"sphere": {"center": [0, 0, 0], "radius": 12}},
        {"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 10, "length": 18}},
        {"half_space": {"normal": [0, 1, 1], "offset": -8}}],
    "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}]}"#;

fn of_walls(gpu: &Arc<Gpu>, precision: Precision, random: &mut ChaCha8Rng) -> Result<Check, StudyError> {
    let walls = parsed(WALLED)?.walls();
    let mut bodies = Bodies::default();
    for place in 0..PAIRS {
        let position = 7.0 * DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        bodies.push(Placed { shape: shape(place % 4, random), position, orientation: turn(random) }, 0);
    }
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let (ours, theirs) = (compute.wall_contacts(&bodies, &walls, 4.0)?, walls.contacts(&bodies, 4.0));
    let mut largest = if ours.len() == theirs.len() { 0.0 } else { NOT_A_NUMBER };
    for (found, expected) in ours.iter().zip(&theirs) {
        let size = 2.0 * bodies.shape[expected.body].bounding_radius();
        largest = larger(largest, (found.separation - expected.separation).abs() / size);
        largest = larger(largest, (found.lever - expected.lever).dot(expected.normal).abs() / size);
    }
    Ok(Check::new("separations and points: walls of all kinds".into(), precision, theirs.len(), largest, [2e-6, 1e-11]))
}

/// Compares the rows at the start of a step: blocks of J, and offsets.
pub fn rows(gpu: &Arc<Gpu>, precision: Precision) -> Result<Vec<Check>, StudyError> {
    let shapes = [
        ("rods", r#"{"spherocylinder": {"diameter": 0.5, "length": 2}}"#, ""),
        ("ellipsoids", r#"{"ellipsoid": {"radii": [0.5, 0.8, 1.1]}}"#, ""),
        (
            "rods with inertia",
            r#"{"spherocylinder": {"diameter": 0.6, "length": 1.5}}"#,
            r#", "dynamics": {"inertial": {"density": 12}}"#,
        ),
        ("discs", r#"{"sphere": {"radius": 0.5}}"#, r#", "planar": true"#),
    ];
    let mut checks = Vec::new();
    for (name, shape, more) in shapes {
        // A pair has one row, so rows are compared by pair.
        let text = format!(
            r#"{{"name": "rows", "seed": 4, "time": {{"dt": 1.5, "end": 15}}, "contact": {{"rows": "paper"}}, "forces": [{{"radial_inward": {{}}}}],
            "generate": [{{"isotropic": {{"count": 60, "shape": {shape}, "volume_fraction": 0.15}}}}] {more}}}"#
        );
        let scene = parsed(&text)?;
        checks.extend(match scene.planar {
            true => of_rows::<PLANAR>(gpu, precision, &scene, name)?,
            false => of_rows::<SPATIAL>(gpu, precision, &scene, name)?,
        });
    }
    Ok(checks)
}

type Row<const D: usize> = ([[f64; D]; 2], f64);

/// Returns the rows by pair, the smaller body first.
fn by_pair<const D: usize>(problem: &Problem<D>) -> BTreeMap<[u32; 2], Row<D>> {
    let row = |((pair, blocks), q): ((&[u32; 2], &[[f64; D]; 2]), &f64)| match *pair {
        [a, b] if a > b => ([b, a], ([blocks[1], blocks[0]], *q)),
        pair => (pair, (*blocks, *q)),
    };
    problem.pair.iter().zip(&problem.jacobian).zip(&problem.q).map(row).collect()
}

fn of_rows<const D: usize>(
    gpu: &Arc<Gpu>,
    precision: Precision,
    scene: &Scene,
    name: &str,
) -> Result<[Check; 2], StudyError> {
    let bodies = scene.build()?;
    let state = || State::new(bodies.clone());
    let model = scene.model();
    let mut device = Device::new(gpu.clone(), precision, &model, state())?;
    let mut cpu = Cpu::<D>::new(&model, state()).map_err(relcp::step::Fault::from)?;
    device.begin()?;
    cpu.begin()?;
    device.append_near()?;
    cpu.append_near()?;
    let (ours, theirs) = (by_pair(&device.lcp::<D>()?.0), by_pair(cpu.lcp().0));
    let entries = |row: &Row<D>| row.0.as_flattened().to_vec();
    let of_largest = theirs.values().flat_map(&entries).fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let size = theirs.values().fold(2.0, |most: f64, row| most.max(row.1.abs()));
    let [mut blocks, mut offsets] = [if ours.len() == theirs.len() { 0.0 } else { NOT_A_NUMBER }; 2];
    for (pair, expected) in &theirs {
        let Some(found) = ours.get(pair) else {
            blocks = NOT_A_NUMBER;
            continue;
        };
        for (x, y) in entries(found).into_iter().zip(entries(expected)) {
            blocks = larger(blocks, (x - y).abs() / of_largest);
        }
        offsets = larger(offsets, (found.1 - expected.1).abs() / size);
    }
    let check = |what: &str, largest, bounds| {
        Check::new(format!("rows of {name}: {what}"), precision, theirs.len(), largest, bounds)
    };
    Ok([check("blocks of J", blocks, [3e-5, 1e-13]), check("q", offsets, [5e-7, 1e-13])])
}

/// Solves stored LCPs on the device and computes their residuals again in 64-bit arithmetic.
pub fn solves(gpu: &Arc<Gpu>, precision: Precision) -> Result<Vec<Check>, StudyError> {
    let tolerance = match precision {
        Precision::F32 => 1e-5,
        Precision::F64 => 1e-8,
    };
    let solved = |lcp: &Stored| match lcp.unknowns {
        PLANAR => of_solve::<PLANAR>(gpu, precision, lcp, tolerance),
        _ => of_solve::<SPATIAL>(gpu, precision, lcp, tolerance),
    };
    let check = |named: &crate::solvers::Named| {
        let what = format!("residual of a solve: {}", named.name);
        // The solver's own tolerance, and a tenth more for the order of sums.
        Ok(Check::new(what, precision, named.lcp.q.len(), solved(&named.lcp)?, [1.1e-5, 1.1e-8]))
    };
    built_in()?.iter().filter(|named| named.name.ends_with("first")).map(check).collect()
}

fn of_solve<const D: usize>(gpu: &Gpu, precision: Precision, lcp: &Stored, tolerance: f64) -> Result<f64, StudyError> {
    let Some(problem) = lcp.problem::<D>() else { return Ok(NOT_A_NUMBER) };
    let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
    let mut solver = Solver::new(gpu, precision, D == PLANAR, SolverKind::Auto, settings)?;
    let (mut device, order) = DeviceProblem::upload(gpu, precision, &problem, &lcp.start)?;
    solver.solve(gpu, &mut device)?;
    Ok(lcp.residual(&device.download_gamma(gpu, precision, &order)?))
}

/// Compares a few steps of small scenes: the final positions of bodies and their overlaps.
pub fn steps(gpu: &Arc<Gpu>, precision: Precision) -> Result<Vec<Check>, StudyError> {
    let built_in = |name: &str| -> Result<_, StudyError> {
        let scene = Scene::built_in(name)?;
        let bodies = scene.build()?;
        Ok((name.to_owned(), scene, bodies))
    };
    let mut cases = vec![
        (built_in("two-ellipsoids")?, [1e-4, 1e-7]),
        (built_in("three-capsules")?, [1e-3, 1e-6]),
        (built_in("chainmail")?, [1e-3, 1e-6]),
    ];
    for kind in Kind::ALL {
        let (scene, bodies) = start(kind, DENSE)?;
        cases.push(((format!("a dense {}", kind.name()), scene, bodies), [1e-3, 1e-6]));
    }
    let mut checks = Vec::new();
    for ((name, scene, bodies), bounds) in cases {
        let run = |compute: &Compute| -> Result<(Vec<DVec3>, f64), StudyError> {
            let mut simulation = Simulation::builder(scene.clone()).bodies(bodies.clone()).on(compute).build()?;
            let mut overlap = 0.0;
            for _ in 0..STEPS {
                overlap = larger(overlap, simulation.step()?.max_overlap);
            }
            Ok((simulation.state()?.bodies.position.clone(), overlap))
        };
        let (ours, overlap) = run(&Compute::Gpu { gpu: gpu.clone(), precision })?;
        let (theirs, _) = run(&Compute::Cpu)?;
        let apart = ours.iter().zip(&theirs).fold(0.0, |most, (x, y)| larger(most, (*x - *y).length()));
        let apart = if ours.len() == theirs.len() { apart } else { NOT_A_NUMBER };
        let check = |what: &str, largest, bounds| {
            Check::new(format!("{STEPS} steps of {name}: {what}"), precision, ours.len(), largest, bounds)
        };
        checks.extend([check("positions", apart, bounds), check("overlap", overlap, [1e-5; 2])]);
    }
    Ok(checks)
}
