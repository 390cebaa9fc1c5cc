//! What a step did, as Python has it.

use crate::step;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// What one step did. Lengths are in the scene's unit, wall times in seconds.
#[pyclass(frozen, get_all, module = "relcp")]
pub(super) struct StepReport {
    /// Its number, from 1.
    step: u64,
    /// Time after it.
    time: f64,
    /// Bodies after it.
    bodies: usize,
    /// Rows of its last LCP.
    constraints: usize,
    /// Recursions after its first solve.
    recursions: u32,
    /// LCP iterations, over all its solves.
    iterations: u64,
    /// Applications of the LCP's matrix, over all its solves.
    products: u64,
    /// Solves that the safeguard of the solver `auto` went on with.
    fallbacks: u32,
    /// Largest residual that one of its solves ended with, a length.
    residual: f64,
    /// Solves that did not reach the solver's tolerance.
    unconverged: u32,
    /// Solves whose rows contradict each other, or nearly do, solved with the least overlap.
    relaxed: u32,
    /// What its velocities times `dt` may be off by, a length.
    velocity_residual: f64,
    /// Into how many pieces it was cut: 1 where it was taken at once.
    pieces: u32,
    /// Cells that had to wait, as there was no room for them.
    waiting: usize,
    /// `solved`, or how the last of its solves that did not converge ended.
    status: &'static str,
    /// Largest overlap of smooth surfaces in the trial of its first solve, a length.
    first_violation: f64,
    /// Largest true overlap of smooth surfaces, with each other or with walls, in the accepted configuration, a length.
    max_overlap: f64,
    /// The pair of bodies that overlaps by `max_overlap`, where one does.
    worst_pair: Option<(usize, usize)>,
    /// The body and the wall that overlap by it, where they do.
    worst_wall: Option<(usize, usize)>,
    /// Pairs of bodies that went through each other on the step's way.
    passed: usize,
    /// The first of them, where there is one.
    passed_pair: Option<(usize, usize)>,
    /// Largest overlap between sub-spheres, where the method makes its rows from them.
    proxy_overlap: Option<f64>,
    /// The farthest that contact moved a body's centre from its free motion, a length.
    largest_move: f64,
    /// The largest separation of a contact that pushes, a length.
    largest_push_gap: f64,
    /// The energy that contact added, where bodies have inertia.
    contact_energy: f64,
    /// The largest angle by which contact turned a body of revolution about its own axis.
    axial_spin: f64,
    /// Rows that were made anew as they pushed apart what no longer touched.
    loosened: u32,
    /// Wall time of the step, seconds.
    wall_seconds: f64,
    /// Wall time of finding candidate pairs, seconds.
    broad_phase_seconds: f64,
    /// Wall time of separations, rows, violations, seconds.
    narrow_phase_seconds: f64,
    /// Wall time of the LCPs, seconds.
    solve_seconds: f64,
    /// Wall time of forces, mobilities, trial configurations, seconds.
    integrate_seconds: f64,
    /// Wall time of growth and division, seconds.
    growth_seconds: f64,
}

impl StepReport {
    pub(super) fn new(report: &step::StepReport, wall: Duration) -> Self {
        let phases = &report.phases;
        StepReport {
            step: report.step,
            time: report.time,
            bodies: report.bodies,
            constraints: report.constraints,
            recursions: report.recursions,
            iterations: report.iterations,
            products: report.products,
            fallbacks: report.fallbacks,
            residual: report.residual,
            unconverged: report.unconverged,
            relaxed: report.relaxed,
            velocity_residual: report.velocity_residual,
            pieces: report.pieces,
            waiting: report.waiting,
            status: report.status.name(),
            first_violation: report.first_violation,
            max_overlap: report.max_overlap,
            worst_pair: report.worst_pair.map(<(usize, usize)>::from),
            worst_wall: report.worst_wall.map(<(usize, usize)>::from),
            passed: report.passed.map_or(0, |passed| passed.pairs),
            passed_pair: report.passed.map(|passed| <(usize, usize)>::from(passed.pair)),
            proxy_overlap: report.proxy_overlap,
            largest_move: report.largest_move,
            largest_push_gap: report.largest_push_gap,
            contact_energy: report.contact_energy,
            axial_spin: report.axial_spin,
            loosened: report.loosened,
            wall_seconds: wall.as_secs_f64(),
            broad_phase_seconds: phases.broad_phase.as_secs_f64(),
            narrow_phase_seconds: phases.narrow_phase.as_secs_f64(),
            solve_seconds: phases.solve.as_secs_f64(),
            integrate_seconds: phases.integrate.as_secs_f64(),
            growth_seconds: phases.growth.as_secs_f64(),
        }
    }
}

#[pymethods]
impl StepReport {
    /// The report as a dict, with the attributes as keys.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("step", self.step)?;
        dict.set_item("time", self.time)?;
        dict.set_item("bodies", self.bodies)?;
        dict.set_item("constraints", self.constraints)?;
        dict.set_item("recursions", self.recursions)?;
        dict.set_item("iterations", self.iterations)?;
        dict.set_item("products", self.products)?;
        dict.set_item("fallbacks", self.fallbacks)?;
        dict.set_item("residual", self.residual)?;
        dict.set_item("unconverged", self.unconverged)?;
        dict.set_item("relaxed", self.relaxed)?;
        dict.set_item("velocity_residual", self.velocity_residual)?;
        dict.set_item("pieces", self.pieces)?;
        dict.set_item("waiting", self.waiting)?;
        dict.set_item("status", self.status)?;
        dict.set_item("first_violation", self.first_violation)?;
        dict.set_item("max_overlap", self.max_overlap)?;
        dict.set_item("worst_pair", self.worst_pair)?;
        dict.set_item("worst_wall", self.worst_wall)?;
        dict.set_item("passed", self.passed)?;
        dict.set_item("passed_pair", self.passed_pair)?;
        dict.set_item("proxy_overlap", self.proxy_overlap)?;
        dict.set_item("largest_move", self.largest_move)?;
        dict.set_item("largest_push_gap", self.largest_push_gap)?;
        dict.set_item("contact_energy", self.contact_energy)?;
        dict.set_item("axial_spin", self.axial_spin)?;
        dict.set_item("loosened", self.loosened)?;
        dict.set_item("wall_seconds", self.wall_seconds)?;
        dict.set_item("broad_phase_seconds", self.broad_phase_seconds)?;
        dict.set_item("narrow_phase_seconds", self.narrow_phase_seconds)?;
        dict.set_item("solve_seconds", self.solve_seconds)?;
        dict.set_item("integrate_seconds", self.integrate_seconds)?;
        dict.set_item("growth_seconds", self.growth_seconds)?;
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        format!(
            "StepReport(step={}, time={}, bodies={}, constraints={}, recursions={}, iterations={}, residual={:.3e}, max_overlap={:.3e}, status={:?})",
            self.step,
            self.time,
            self.bodies,
            self.constraints,
            self.recursions,
            self.iterations,
            self.residual,
            self.max_overlap,
            self.status
        )
    }
}
