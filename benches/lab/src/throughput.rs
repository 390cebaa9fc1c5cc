//! Throughput: the cost of a step as a function of the number of bodies, on the CPU and on a device.
//!
//! The states are copies of a stored colony of 1,024 cells, of a stored jammed compaction of 1,000 ellipsoids and of
//! 1,000 rods packed into a ball, side by side. The copies are independent, so the number of solver iterations does not
//! grow with their number here.

use super::paper::packing;
use super::{StudyError, copy_bandwidth, tiled};
use relcp::bodies::Bodies;
use relcp::gpu::{Counters, Gpu};
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::Phases;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::time::{Duration, Instant};

/// The kind of scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Growing cells in the plane.
    Colony,
    /// Jammed ellipsoids.
    Compaction,
    /// Rods packed into a ball.
    Packing,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Colony, Kind::Compaction, Kind::Packing];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Colony => "colony",
            Kind::Compaction => "compaction",
            Kind::Packing => "packing",
        }
    }

    fn scene(self) -> Result<Scene, StudyError> {
        const TIME: [&str; 2] = ["time.end=1", "time.dt=0.001"];
        Ok(match self {
            Kind::Colony => Scene::load("colony-full", TIME)?,
            Kind::Compaction => Scene::load("compaction", TIME)?,
            Kind::Packing => {
                let mut scene = packing::scene(1, 1e-3)?;
                scene.time.end = 1.0;
                scene
            }
        })
    }

    /// The packed rods are those of `assets/lcps/packing.json`, 1,000 of them, at t = 15.
    fn state(self) -> &'static [u8] {
        match self {
            Kind::Colony => include_bytes!("../../../assets/states/colony-1024.npz"),
            Kind::Compaction => include_bytes!("../../../assets/states/compaction-1000.npz"),
            Kind::Packing => include_bytes!("../../../assets/states/packing-1000.npz"),
        }
    }

    /// Returns the measured sizes, up to a largest one.
    pub fn sizes(self, largest: usize) -> Vec<usize> {
        let all: Vec<usize> = match self {
            Kind::Colony => (10..=20).map(|k| 1 << k).collect(),
            Kind::Compaction | Kind::Packing => (3..=6).map(|k| 10usize.pow(k)).collect(),
        };
        all.into_iter().filter(|n| *n <= largest).collect()
    }
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The kind of scene.
    pub kind: Kind,
    /// Bodies.
    pub bodies: usize,
    /// The device, or the CPU and its threads.
    pub computed_by: String,
    /// Rows of the last LCP.
    pub constraints: usize,
    /// Timed steps.
    pub steps: usize,
    /// Milliseconds per step.
    pub step_ms: f64,
    /// The stages of a step: broad phase, narrow phase, solve, integrate, growth; milliseconds.
    pub stages_ms: [f64; 5],
    /// Recursions per step.
    pub recursions: f64,
    /// Iterations of the solver per step.
    pub iterations: f64,
    /// Products with A per step.
    pub products: f64,
    /// Microseconds per iteration of the solver.
    pub iteration_us: f64,
    /// Constraints per second of the narrow phase. Separations of the start and of the trials both count.
    pub pairs_per_second: f64,
    /// Bytes that a product must move, divided by the bytes that the device copies in the time of an iteration; zero on
    /// the CPU.
    pub bandwidth_floor: f64,
    /// Dispatches per step; zero on the CPU, like the next two.
    pub dispatches: f64,
    /// Submissions per step.
    pub submissions: f64,
    /// Read-backs per step.
    pub reads: f64,
    /// Largest overlap of all steps.
    pub max_overlap: f64,
    /// Largest residual of all solves, as reported by the solver.
    pub worst_residual: f64,
    /// Solves that did not converge.
    pub unconverged: u32,
}

/// Bytes per row that one product must move in 32-bit numbers: both blocks of J twice (once by body, once by row), the
/// row index for each body, its bodies, both velocities, the multiplier, twice, and the result.
fn product_bytes(constraints: usize, planar: bool, number: usize) -> f64 {
    let block = if planar { 4 * number } else { 8 * number };
    constraints as f64 * (4 * block + 2 * block + 2 * 4 + 8 + 4 * number) as f64
}

/// Returns the scene of a kind, and `bodies` initial bodies.
pub(super) fn start(kind: Kind, bodies: usize) -> Result<(Scene, Bodies), StudyError> {
    Ok((kind.scene()?, tiled(kind.state(), bodies)?))
}

/// Times `steps` steps of `bodies` bodies of a kind, after `warm_up` other steps, which compile pipelines and store
/// multipliers.
pub fn measure(kind: Kind, bodies: usize, steps: [usize; 2], compute: &Compute) -> Result<Row, StudyError> {
    let bandwidth = match compute {
        Compute::Gpu { gpu, .. } => Some(copy_bandwidth(gpu)?),
        _ => None,
    };
    measure_with(kind, bodies, steps, compute, bandwidth)
}

/// The same, with the copy bandwidth of the device if it is known.
pub(super) fn measure_with(
    kind: Kind,
    bodies: usize,
    [warm_up, steps]: [usize; 2],
    compute: &Compute,
    bandwidth: Option<f64>,
) -> Result<Row, StudyError> {
    let (scene, start) = start(kind, bodies)?;
    let planar = scene.planar;
    let mut simulation = Simulation::builder(scene).bodies(start).on(compute).build()?;
    for _ in 0..warm_up {
        simulation.step()?;
    }
    let before = simulation.device().map(Gpu::counters).unwrap_or_default();
    let (mut phases, mut recursions, mut products, mut iterations) = (Phases::default(), 0, 0, 0);
    let (mut max_overlap, mut worst_residual, mut unconverged) = (0.0f64, 0.0f64, 0);
    let (mut constraints, mut pairs) = (0, 0usize);
    let begun = Instant::now();
    for _ in 0..steps {
        let report = simulation.step()?;
        phases.broad_phase += report.phases.broad_phase;
        phases.narrow_phase += report.phases.narrow_phase;
        phases.solve += report.phases.solve;
        phases.integrate += report.phases.integrate;
        phases.growth += report.phases.growth;
        recursions += report.recursions;
        products += report.products;
        iterations += report.iterations;
        constraints = report.constraints;
        pairs += constraints * (2 + report.recursions as usize);
        max_overlap = max_overlap.max(report.max_overlap);
        worst_residual = worst_residual.max(report.residual);
        unconverged += report.unconverged;
    }
    let wall = begun.elapsed();
    let after = simulation.device().map(Gpu::counters).unwrap_or_default();
    let a_step = |x: f64| x / steps.max(1) as f64;
    let ms = |d: Duration| a_step(1e3 * d.as_secs_f64());
    let iteration = phases.solve.as_secs_f64() / (iterations.max(1)) as f64;
    let bandwidth_floor = bandwidth.map_or(0.0, |bandwidth| {
        let bytes = product_bytes(constraints, planar, simulation.precision().bytes());
        iteration * bandwidth / bytes.max(1.0)
    });
    let counted = |of: fn(&Counters) -> u64| a_step((of(&after) - of(&before)) as f64);
    Ok(Row {
        kind,
        bodies: simulation.bodies(),
        computed_by: match simulation.device() {
            Some(gpu) => format!("{} {}", gpu.name(), simulation.precision().name()),
            None => format!("CPU f64, {} threads", rayon::current_num_threads()),
        },
        constraints,
        steps,
        step_ms: ms(wall),
        stages_ms: [phases.broad_phase, phases.narrow_phase, phases.solve, phases.integrate, phases.growth].map(ms),
        recursions: a_step(f64::from(recursions)),
        iterations: a_step(iterations as f64),
        products: a_step(products as f64),
        iteration_us: 1e6 * iteration,
        pairs_per_second: pairs as f64 / phases.narrow_phase.as_secs_f64().max(1e-9),
        bandwidth_floor,
        dispatches: counted(|c| c.dispatches),
        submissions: counted(|c| c.submissions),
        reads: counted(|c| c.reads),
        max_overlap,
        worst_residual,
        unconverged,
    })
}

/// Returns the rows as a Markdown table.
pub fn table(rows: &[Row]) -> String {
    let mut out = String::from(
        "| what | bodies | computed by | rows | ms a step | broad / narrow / solve / integrate / growth, ms | recursions | products | us an iteration | x copy floor | pairs/s | dispatches | submissions | read-backs | worst overlap | worst residual | unconverged |\n| --- | ---: | --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    for row in rows {
        let stages: Vec<String> = row.stages_ms.iter().map(|ms| format!("{ms:.2}")).collect();
        let _ = writeln!(
            out,
            "| {:?} | {} | {} | {} | {:.2} | {} | {:.2} | {:.0} | {:.1} | {:.1} | {:.2e} | {:.0} | {:.1} | {:.1} | {:.2e} | {:.2e} | {} |",
            row.kind,
            row.bodies,
            row.computed_by,
            row.constraints,
            row.step_ms,
            stages.join(" / "),
            row.recursions,
            row.products,
            row.iteration_us,
            row.bandwidth_floor,
            row.pairs_per_second,
            row.dispatches,
            row.submissions,
            row.reads,
            row.max_overlap,
            row.worst_residual,
            row.unconverged
        );
    }
    out
}
