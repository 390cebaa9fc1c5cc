//! What a step did, as Python has it.

use crate::lcp::Status;
use crate::step::{self, Passed, step_figures};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// How Python has a figure of a step.
trait Figure {
    type InPython: for<'py> IntoPyObject<'py> + Clone + Send + Sync;
    fn in_python(&self) -> Self::InPython;
}

macro_rules! as_it_is {
    ($($type:ty),*) => {
        $(impl Figure for $type {
            type InPython = $type;
            fn in_python(&self) -> $type {
                *self
            }
        })*
    };
}

as_it_is!(bool, u32, u64, usize, f64, Option<f64>, Option<usize>);

impl Figure for Option<[usize; 2]> {
    type InPython = Option<(usize, usize)>;
    fn in_python(&self) -> Self::InPython {
        self.map(<(usize, usize)>::from)
    }
}

impl Figure for Option<Passed> {
    type InPython = usize;
    fn in_python(&self) -> usize {
        self.map_or(0, |passed| passed.pairs)
    }
}

impl Figure for Status {
    type InPython = &'static str;
    fn in_python(&self) -> &'static str {
        self.name()
    }
}

macro_rules! report {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $before:expr, $joins:ident, $elsewhere:tt;)*) => {
        /// What one step did. Lengths are in the scene's unit, wall times in seconds.
        #[pyclass(frozen, get_all, module = "relcp")]
        pub(super) struct StepReport {
            $($(#[$doc])* $name: <$type as Figure>::InPython,)*
            /// The first pair that went through each other, where there is one.
            passed_pair: Option<(usize, usize)>,
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
                    $($name: report.$name.in_python(),)*
                    passed_pair: report.passed.map(|passed| <(usize, usize)>::from(passed.pair)),
                    wall_seconds: wall.as_secs_f64(),
                    broad_phase_seconds: phases.broad_phase.as_secs_f64(),
                    narrow_phase_seconds: phases.narrow_phase.as_secs_f64(),
                    solve_seconds: phases.solve.as_secs_f64(),
                    integrate_seconds: phases.integrate.as_secs_f64(),
                    growth_seconds: phases.growth.as_secs_f64(),
                }
            }

            fn figures<'py>(&self, dict: &Bound<'py, PyDict>) -> PyResult<()> {
                $(dict.set_item(stringify!($name), self.$name)?;)*
                Ok(())
            }
        }
    };
}

step_figures!(report);

#[pymethods]
impl StepReport {
    /// The report as a dict, with the attributes as keys.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.figures(&dict)?;
        dict.set_item("passed_pair", self.passed_pair)?;
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
