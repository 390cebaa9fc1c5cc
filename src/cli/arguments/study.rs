//! Arguments of studies.

use super::number::positive;
use super::{Compute, Figures, Print};
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum StudyName {
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

const STUDY_EXAMPLES: &str = "\
Examples:
  relcp study throughput --backend gpu --largest 131072
  relcp study solvers --quick
  relcp study two-ellipsoids --out docs/studies/two-ellipsoids
  relcp study work-precision --backend gpu   on the CPU, and on a device too
  relcp study hard --quick
  relcp study hard --random 200 --confined 40 --seed 3
      scenes that nobody thought of
  relcp study hard --pressed 200             bodies where there is hardly room
  relcp study hard --chambers 200 --stall
      growth chambers until they overflow
  relcp study device --minutes 9             the same again goes on
  relcp study all --quick --out studies      some minutes
  relcp run colony --set solver.dump.when=slow --out runs/slow
  relcp study solvers runs/slow              every solver on its slow LCPs";

#[derive(Args, Clone, Debug)]
#[command(after_help = STUDY_EXAMPLES)]
pub(in crate::cli) struct Study {
    /// Which study
    #[arg(value_enum)]
    pub(in crate::cli) name: StudyName,
    /// For solvers: files of LCPs, folders of them, or runs with them (see solver.dump), in place of the built-in ones
    #[arg(value_name = "FILES", value_hint = ValueHint::AnyPath)]
    pub(in crate::cli) files: Vec<PathBuf>,
    /// For throughput: the largest number of bodies
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub(in crate::cli) largest: usize,
    /// For throughput: the smallest number of bodies
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) smallest: usize,
    /// For throughput: what is stepped, if not both
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(in crate::cli) of: Option<relcp::study::throughput::Kind>,
    /// For device: the numbers of bodies, by commas [default: 1024 to 1048576, each four times the one before]
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = bodies)]
    pub(in crate::cli) sizes: Vec<usize>,
    /// For device: minutes that this call may take; what does not fit is left to the next call
    #[arg(long, value_name = "MINUTES", default_value_t = 9.0, value_parser = positive)]
    pub(in crate::cli) minutes: f64,
    /// For throughput: steps timed of each size
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(in crate::cli) steps: u32,
    /// For throughput: steps taken before those
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(in crate::cli) warm_up: u32,
    /// For work-precision: makes the reference solutions anew and writes them into this folder, in place of the study
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) make_references: Option<PathBuf>,
    /// For hard: so many scenes drawn from --seed, in place of the cases
    #[arg(long, value_name = "N")]
    pub(in crate::cli) random: Option<u64>,
    /// For hard: so many confined colonies drawn from --seed, in place of the cases
    #[arg(long, value_name = "N")]
    pub(in crate::cli) confined: Option<u64>,
    /// For hard: so many scenes of pressed bodies drawn from --seed, in place of the cases
    #[arg(long, value_name = "N")]
    pub(in crate::cli) pressed: Option<u64>,
    /// For hard: so many growth chambers drawn from --seed, each followed until it overflows, in place of the cases
    #[arg(long, value_name = "N", conflicts_with_all = ["random", "confined", "pressed", "lines"])]
    pub(in crate::cli) chambers: Option<u64>,
    /// With --chambers: cells without room wait
    #[arg(long, requires = "chambers")]
    pub(in crate::cli) stall: bool,
    /// For hard: bodies in line between closing walls, held against closed forms, in place of the cases
    #[arg(long, conflicts_with_all = ["random", "confined", "pressed"])]
    pub(in crate::cli) lines: bool,
    /// For hard: what scenes are drawn from
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// Fewer iterations, or fewer and shorter runs: a minute or two at most; of throughput with all only
    #[arg(long)]
    pub(in crate::cli) quick: bool,
    /// Where the tables go; with all, a folder for each study in it; with device and without --out, one by its name
    #[arg(long, value_name = "DIR", default_value = "studies", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: PathBuf,
    #[command(flatten)]
    pub(in crate::cli) figures: Figures,
    #[command(flatten)]
    pub(in crate::cli) compute: Compute,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

/// A number of bodies.
fn bodies(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| (1..=MOST_BODIES).contains(n))
        .ok_or_else(|| format!("it is not a whole number from 1 to {MOST_BODIES}"))
}

/// Bodies of a study of a device at most.
const MOST_BODIES: usize = 1 << 24;
