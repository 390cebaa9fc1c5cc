//! What a run did so far: the sums and extremes of its steps' reports, which a checkpoint carries on.

use super::Leg;
use crate::simulation::Simulation;
use crate::step::{Passed, Phases, StepReport, step_figures, step_phases};
use serde::{Deserialize, Deserializer, Serialize};
use std::time::Duration;

/// How many of the steps that did not meet a tolerance are named; the others are counted.
const NAMED: usize = 10;

macro_rules! wall_seconds {
    ($($(#[$doc:meta])* $name:ident, $label:literal;)*) => {
        /// Wall time by phase, in seconds.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct WallSeconds {
            /// All of the run, over its resumptions.
            pub total: f64,
            $($(#[$doc])* pub $name: f64,)*
            /// Writing files, the check of the final state, and its picture.
            pub output: f64,
            /// Placing the bodies, or reading the checkpoint.
            pub setup: f64,
        }

        impl WallSeconds {
            fn add(&mut self, phases: &Phases) {
                $(self.$name += phases.$name.as_secs_f64();)*
            }

            /// The phases by name, without the total.
            pub fn phases(&self) -> Vec<(&'static str, f64)> {
                vec![$(($label, self.$name),)* ("output", self.output), ("setup", self.setup)]
            }
        }
    };
}

step_phases!(wall_seconds);

/// A step that left a larger overlap than the scene tolerates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverStep {
    /// Its number, from 1.
    pub step: u64,
    /// The overlap that it left, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub max_overlap: f64,
    /// The pair of bodies that overlaps by it.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap by it, if they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<[usize; 2]>,
}

/// A step in which bodies went through each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassedStep {
    /// Its number, from 1.
    pub step: u64,
    /// How many pairs did.
    pub pairs: usize,
    /// The first of them.
    pub pair: [usize; 2],
}

/// A step with a solve that did not reach the solver's tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnconvergedStep {
    /// Its number, from 1.
    pub step: u64,
    /// Its largest residual, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub residual: f64,
}

/// A step whose velocities come from a solve that is not right to the overlap tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnsettledStep {
    /// Its number, from 1.
    pub step: u64,
    /// What its velocities times `dt` may be off by, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub residual: f64,
}

macro_rules! totals {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $before:expr, $joins:ident, {
        $(column($($column:tt)*))?
        $(counts($($count:ident: $whole:ty = $how:ident),*))?
        $(retried($($again:ident: $again_whole:ty = $again_how:ident),*))?
        $(largest($largest:ident))?
        $(total($total:ident))?
    };)*) => {
        /// Steps that did not go at once.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(default)]
        pub struct Retried {
            /// Steps of which some attempt failed.
            pub steps: u64,
            $($($(
                #[doc = concat!(over_steps!($again_how), " [`StepReport::", stringify!($name), "`].")]
                pub $again: $again_whole,
            )*)?)*
        }

        /// Sums and extremes over the steps of a run. JSON has no infinity: a length that is not finite is null.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Totals {
            /// Steps taken.
            pub steps: u64,
            /// Largest overlap of the start, a length.
            #[serde(deserialize_with = "or_infinite")]
            pub start_max_overlap: f64,
            $($($(
                #[doc = concat!(over_steps!($how), " [`StepReport::", stringify!($name), "`].")]
                #[serde(default)]
                pub $count: $whole,
            )*)?)*
            $($(
                #[doc = concat!("The largest [`StepReport::", stringify!($name), "`].")]
                #[serde(default, deserialize_with = "or_infinite")]
                pub $largest: f64,
            )?)*
            $($(
                #[doc = concat!("The sum of [`StepReport::", stringify!($name), "`].")]
                #[serde(default)]
                pub $total: f64,
            )?)*
            /// What of a user's own acted on it, and is not in its folder: "forces", "rules".
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub own: Vec<String>,
            /// Largest overlap of sub-spheres that a step left, where the method has them.
            pub proxy_overlap: Option<f64>,
            /// Steps that left more than the overlap tolerance.
            pub steps_over_tolerance: u64,
            /// The first of them.
            pub over: Vec<OverStep>,
            /// Steps in which bodies went through each other.
            #[serde(default)]
            pub steps_passed: u64,
            /// The first of them.
            #[serde(default)]
            pub passed: Vec<PassedStep>,
            /// Steps whose velocities are not right to the overlap tolerance.
            #[serde(default)]
            pub steps_unsettled: u64,
            /// The first of them.
            #[serde(default)]
            pub unsettled: Vec<UnsettledStep>,
            /// The first steps with a solve that did not reach the solver's tolerance.
            pub unconverged_steps: Vec<UnconvergedStep>,
            /// Steps that did not go at once.
            #[serde(default)]
            pub retried: Retried,
            /// The farthest that a body's velocity carries it in a step, in thicknesses of its own, by the recorded
            /// states.
            #[serde(default)]
            pub farthest_way: f64,
            /// What computed which steps: one entry for each time that the run was started or resumed.
            #[serde(default)]
            pub legs: Vec<Leg>,
            /// Wall time.
            pub wall: WallSeconds,
        }

        impl Totals {
            /// Adds the figures that are summed up as they are.
            fn add_figures(&mut self, report: &StepReport) {
                self.retried.steps += u64::from(report.failed_attempts > 0);
                $($($(over_steps!($again_how, self.retried.$again, report.$name);)*)?)*
                $($($(over_steps!($how, self.$count, report.$name);)*)?)*
                $($(self.$largest = worse(self.$largest, report.$name);)?)*
                $($(self.$total += report.$name.unwrap_or_default();)?)*
            }
        }
    };
}

/// How a whole number is made of the steps' figures: in words, and for one step more.
macro_rules! over_steps {
    (sum) => {
        "The sum of"
    };
    (most) => {
        "The largest"
    };
    (last) => {
        "The last step's"
    };
    (steps) => {
        "The number of steps with some"
    };
    (several) => {
        "The number of steps with several"
    };
    (sum, $total:expr, $figure:expr) => {
        $total += $figure as u64
    };
    (most, $total:expr, $figure:expr) => {
        $total = $total.max($figure as _)
    };
    (last, $total:expr, $figure:expr) => {
        $total = $figure as u64
    };
    (steps, $total:expr, $figure:expr) => {
        $total += u64::from($figure as u64 > 0)
    };
    (several, $total:expr, $figure:expr) => {
        $total += u64::from($figure > 1)
    };
}

step_figures!(totals);

fn or_infinite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// The larger of the two, and infinite where the new one is not a number: a maximum must not lose that.
fn worse(so_far: f64, new: f64) -> f64 {
    if new.is_nan() { f64::INFINITY } else { so_far.max(new) }
}

impl Totals {
    /// Adds a step that took `wall` in all.
    pub fn add(&mut self, report: &StepReport, overlap_tolerance: f64, wall: Duration) {
        self.steps += 1;
        if let Some(proxy) = report.proxy_overlap {
            self.proxy_overlap = Some(worse(self.proxy_overlap.unwrap_or(0.0), proxy));
        }
        if !report.within(overlap_tolerance) {
            self.steps_over_tolerance += 1;
            if self.over.len() < NAMED {
                let (step, pair, wall) = (report.step, report.worst_pair, report.worst_wall);
                self.over.push(OverStep { step, max_overlap: report.max_overlap, pair, wall });
            }
        }
        if let Some(Passed { pairs, pair }) = report.passed {
            self.steps_passed += 1;
            if self.passed.len() < NAMED {
                self.passed.push(PassedStep { step: report.step, pairs, pair });
            }
        }
        if !report.settled(overlap_tolerance) {
            self.steps_unsettled += 1;
            if self.unsettled.len() < NAMED {
                self.unsettled.push(UnsettledStep { step: report.step, residual: report.velocity_residual });
            }
        }
        if report.unconverged > 0 && self.unconverged_steps.len() < NAMED {
            self.unconverged_steps.push(UnconvergedStep { step: report.step, residual: report.residual });
        }
        self.add_figures(report);
        self.wall.add(&report.phases);
        self.wall.total += wall.as_secs_f64();
    }

    /// Adds the time of a step that failed, which has no phases.
    pub(crate) fn add_failed(&mut self, wall: Duration) {
        self.wall.total += wall.as_secs_f64();
    }

    /// Notes that a simulation takes the steps from here on.
    pub(crate) fn taken_up_by(&mut self, simulation: &Simulation) {
        let leg = Leg::of(simulation);
        log::info!("{leg}");
        self.legs.push(leg);
    }

    /// Whether every step met its tolerances, and no bodies went through each other.
    pub fn clean(&self) -> bool {
        self.reason().is_none()
    }

    /// What a run missed, in one word, the worst first: `overlap` where a step left more than the tolerance, `passed`
    /// where bodies went through each other, `residual` where velocities come from a solve that is not right to the
    /// overlap tolerance.
    pub fn reason(&self) -> Option<&'static str> {
        let missed =
            [("overlap", self.steps_over_tolerance), ("passed", self.steps_passed), ("residual", self.steps_unsettled)];
        missed.into_iter().find(|(_, steps)| *steps > 0).map(|(reason, _)| reason)
    }
}
