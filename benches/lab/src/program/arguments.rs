//! The program's arguments.

use clap::{ArgGroup, Parser, ValueEnum, ValueHint};
use log::LevelFilter;
use relcp::figure::Format;
use std::path::PathBuf;

/// The studies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StudyName {
    /// What a step costs by the number of bodies, on the CPU and on a device
    Throughput,
    /// What each solver needs, and what it attains, on stored LCPs and on short runs
    Solvers,
    /// Two ellipsoids pushed past each other: errors by step, by scheme and by sub-spheres, and what they cost
    TwoEllipsoids,
    /// Three capsules with and without recursion: overlaps, and how they shake from step to step
    Jitter,
    /// A sheet of rings that is stretched: overlaps by ReLCP, by sub-spheres and without recursion
    Chainmail,
    /// Ellipsoids drawn into a ball: rows and time by ReLCP and by sub-spheres
    Compaction,
    /// A cell that grows into a colony: rows, time and alignment by ReLCP and by sub-spheres
    Colony,
    /// Rods drawn into a ball: time of a step and overlap by the step's size, beside public engines
    Packing,
    /// What errors at the end of a run cost, by stepping scheme, contact method, step and overlap tolerance, on small
    /// scenes
    WorkPrecision,
    /// Small scenes of the kinds that break contact codes, with a verdict on each
    Hard,
    /// Conservation in inertial motion: angular momentum and energy of tops, energy of heaps
    Inertia,
    /// One device: its results against the CPU's, bandwidth, time of steps and iterations, a growing colony
    Device,
    /// All but that of a device, each in a folder of its own, and an index of their pages
    All,
}

const AFTER_HELP: &str = "\
Examples:
  relcp-lab throughput --backend gpu --largest 131072
  relcp-lab solvers --quick
  relcp-lab two-ellipsoids --out docs/studies/two-ellipsoids
  relcp-lab work-precision --backend gpu   on the CPU, and on a device too
  relcp-lab hard --quick
  relcp-lab hard --random 200 --confined 40 --seed 3
      scenes that nobody thought of
  relcp-lab hard --pressed 200             bodies where there is hardly room
  relcp-lab hard --chambers 200 --stall
      growth chambers until they overflow
  relcp-lab device --minutes 9             the same again goes on
  relcp-lab all --quick --out studies      some minutes
  relcp run colony --set solver.dump.when=slow --out runs/slow
  relcp-lab solvers runs/slow              every solver on its slow LCPs";

/// Measured studies of relcp, which write tables.
#[derive(Parser, Clone, Debug)]
#[command(name = "relcp-lab", version, max_term_width = 100, after_help = AFTER_HELP)]
#[command(group = ArgGroup::new("drawn").multiple(true))]
pub struct Arguments {
    /// Which study
    #[arg(value_enum)]
    pub name: StudyName,
    /// For solvers: files of LCPs, folders of them, or runs with them (see solver.dump), instead of the built-in ones
    #[arg(value_name = "FILES", value_hint = ValueHint::AnyPath)]
    pub files: Vec<PathBuf>,
    /// For throughput: the largest number of bodies
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub largest: usize,
    /// For throughput: the smallest number of bodies
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub smallest: usize,
    /// For throughput: the kind of scene [default: both]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub of: Option<relcp_lab::throughput::Kind>,
    /// For device: the numbers of bodies, separated by commas [default: 1024 to 1048576, each four times the one
    /// before]
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = bodies)]
    pub sizes: Vec<usize>,
    /// For device: time limit of this call in minutes; the next call measures the remaining items
    #[arg(long, value_name = "MINUTES", default_value_t = 9.0, value_parser = positive)]
    pub minutes: f64,
    /// For throughput: timed steps for each size
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub steps: u32,
    /// For throughput: steps before the timed ones
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub warm_up: u32,
    /// For work-precision: compute the reference solutions again and write them into this folder, instead of the study
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub make_references: Option<PathBuf>,
    /// For hard: run this number of scenes drawn from --seed, instead of the cases
    #[arg(long, value_name = "N", group = "drawn")]
    pub random: Option<u64>,
    /// For hard: run this number of confined colonies drawn from --seed, instead of the cases
    #[arg(long, value_name = "N", group = "drawn")]
    pub confined: Option<u64>,
    /// For hard: run this number of scenes of pressed bodies drawn from --seed, instead of the cases
    #[arg(long, value_name = "N", group = "drawn")]
    pub pressed: Option<u64>,
    /// With --random, --confined or --pressed: scenes get friction, and some restitution
    #[arg(long, requires = "drawn")]
    pub friction: bool,
    /// With --random, --confined or --pressed: scenes get fields, walls under a load, drag of real bodies, regions,
    /// fences or removal
    #[arg(long, requires = "drawn")]
    pub keys: bool,
    /// With --random, --confined or --pressed: the number of the first scene, from 0; the others follow it
    #[arg(long, value_name = "NUMBER", requires = "drawn", default_value_t = 0)]
    pub first: u64,
    /// For hard: run this number of growth chambers drawn from --seed, each until it overflows, instead of the cases
    #[arg(long, value_name = "N", conflicts_with_all = ["random", "confined", "pressed", "lines"])]
    pub chambers: Option<u64>,
    /// With --chambers: cells without room wait
    #[arg(long, requires = "chambers")]
    pub stall: bool,
    /// For hard: compare bodies in line between closing walls with closed forms, instead of the cases
    #[arg(long, conflicts_with_all = ["random", "confined", "pressed"])]
    pub lines: bool,
    /// For hard: the seed of drawn scenes
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Fewer iterations, or fewer and shorter runs: a minute or two at most; of throughput with all only
    #[arg(long)]
    pub quick: bool,
    /// The folder of the tables; with all, it gets a folder for each study; with device and without --out, a folder
    /// named after the device
    #[arg(long, value_name = "DIR", default_value = "studies", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Formats of the figures, separated by commas: svg, pdf, png
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',', default_value = "svg")]
    pub figures: Vec<Format>,
    /// Backend: auto computes on the CPU, and also measures a hardware GPU if the study compares both. gpu also accepts
    /// a software adapter
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: Backend,
    /// The adapter, by a part of its name; `relcp devices` lists them
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Floating-point precision [default: f64 on the CPU and on a software adapter, f32 on a hardware GPU]; with
    /// --backend auto that of the GPU
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Number of threads [default: one per core]. The bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub threads: Option<u16>,
    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
    /// Print no progress and no summary; messages of faults remain
    #[arg(long)]
    pub quiet: bool,
    /// Write a log to standard error: error, warn, info, debug or trace; RELCP_LOG sets levels by module
    #[arg(long, value_name = "LEVEL")]
    pub log: Option<LevelFilter>,
}

/// The backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    Auto,
    Cpu,
    Gpu,
}

/// The precision of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Precision {
    F32,
    F64,
}

/// A larger number of threads is rejected as a typing error.
const MOST_THREADS: i64 = 1024;

/// Parses a number above zero.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("it is not a number above zero".into()),
    }
}

/// Parses a number of bodies.
fn bodies(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| (1..=MOST_BODIES).contains(n))
        .ok_or_else(|| format!("it is not a whole number from 1 to {MOST_BODIES}"))
}

/// The largest number of bodies in a study of a device.
const MOST_BODIES: usize = 1 << 24;

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }
}
