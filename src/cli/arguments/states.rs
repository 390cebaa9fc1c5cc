//! Arguments of commands that read states: contacts, export, measure, render, view.

use super::backend::BackendParser;
use super::number::{length, positive, range, size};
use super::{Backend, Figures, MOST_THREADS, Precision, Print, complete};
use clap::{Args, ValueEnum, ValueHint};
use relcp::figure::Format;
use relcp::render::{Background, Fit, Quantity, Side};
use std::path::PathBuf;

/// The most frames per second of a movie.
const MOST_A_SECOND: i64 = 240;

const CONTACTS_EXAMPLES: &str = "\
Examples:
  relcp contacts runs/colony
  relcp contacts runs/colony/final.json --json
  relcp contacts runs/colony/states/state_0000000100.npz --cutoff 0.01
  relcp contacts runs/colony --backend gpu   on a device, in its precision";

#[derive(Args, Clone, Debug)]
#[command(after_help = CONTACTS_EXAMPLES)]
pub(in crate::cli) struct Contacts {
    /// A scene file, the name of a built-in scene, a run's final.json, one of its states (.npz, which has no walls), or
    /// a run's folder: its last state
    #[arg(value_name = "STATE", add = complete::run())]
    pub(in crate::cli) state: PathBuf,
    /// Pairs nearer than this, a length; in a periodic scene at most the shortest period
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, value_parser = length)]
    pub(in crate::cli) cutoff: f64,
    /// Backend: cpu and auto use the CPU in f64; gpu a hardware GPU, or else a software adapter
    #[arg(long, default_value = "cpu", value_parser = BackendParser)]
    pub(in crate::cli) backend: Backend,
    /// The adapter, by a part of its name; `relcp devices` lists them
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) adapter: Option<String>,
    /// Floating-point precision [default: f64 on the CPU and on a software adapter, f32 on a hardware GPU]
    #[arg(long, value_enum)]
    pub(in crate::cli) precision: Option<Precision>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

const EXPORT_EXAMPLES: &str = "\
Examples:
  relcp export runs/colony --format gsd
      then: ovito runs/colony/gsd/colony.gsd
  relcp export runs/colony --format vtk
      then: paraview --script=runs/colony/vtk/show.py
  relcp export runs/colony/final.json --format gsd --out final
  relcp export runs/colony --format vtk --cutoff 0.01 --json | jq .files

gsd: one frame per state; one particle type per size of a shape (256 classes for growing rods; log/ has the exact \
sizes).
lammps, xyz: one frame per state, one line per body; OVITO draws rods in xyz as spherocylinders.
vtk: bodies.pvd, axes.pvd, contacts.pvd and, where there are bonds or fields, bonds.pvd and field-NAME.pvd with the \
times of the run, and show.py, which shows the bodies in ParaView.
Every file appears whole or not at all.";

/// A format to export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ExportFormat {
    /// For OVITO and HOOMD's tools
    Gsd,
    /// LAMMPS' text dump, for LAMMPS, OVITO, ASE and scripts
    Lammps,
    /// For ParaView
    Vtk,
    /// Extended XYZ, for OVITO, ASE and scripts
    Xyz,
}

#[derive(Args, Debug)]
#[command(after_help = EXPORT_EXAMPLES)]
pub(in crate::cli) struct Export {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN", add = complete::run())]
    pub(in crate::cli) run: PathBuf,
    /// The format
    #[arg(long, value_enum)]
    pub(in crate::cli) format: ExportFormat,
    /// Output folder [default: RUN/FORMAT; for a single file NAME-FORMAT in the current folder]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// The last state only
    #[arg(long)]
    pub(in crate::cli) last: bool,
    /// Pairs nearer than this are contacts, a length [default: a thousandth of the thinnest body]. For vtk only
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub(in crate::cli) cutoff: Option<f64>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

const MEASURE_EXAMPLES: &str = "\
Examples:
  relcp measure runs/colony   every measure of every state
  relcp measure runs/colony --only nematic,correlation
  relcp measure runs/colony --last --json | jq '.states[0].values'
  relcp measure runs/colony/states/state_0000000100.npz --domain-angle 5

measures.csv has one row per state, NAME.csv the rows of a profile by state, measures.json everything; plots are SVG.
A value that a state cannot give is an empty cell; measures.json gives the reason. Stress and force chains need \
contact forces: the checkpoint has them, and with output.forces all states of a run.";

#[derive(Args, Debug)]
#[command(after_help = MEASURE_EXAMPLES)]
pub(in crate::cli) struct Measure {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN", add = complete::run())]
    pub(in crate::cli) run: PathBuf,
    /// Only these measures, separated by commas or by repeating the option: nematic, correlation, radius, packing,
    /// density, length, contacts, stress, shear_stress, force_chains, friction, walls, fields, bonds,
    /// microdomains, dissipation, msd, velocity_correlation, groups, segregation, removal
    #[arg(long, value_name = "MEASURE", value_delimiter = ',')]
    pub(in crate::cli) only: Vec<String>,
    /// The last state only
    #[arg(long)]
    pub(in crate::cli) last: bool,
    /// Output folder [default: RUN/measures; for a single file NAME-measures in the current folder]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// Width of the distance bins, a length [default: the median thickness of the bodies]
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub(in crate::cli) bin: Option<f64>,
    /// Radius of the neighbourhood for local order, a length [default: the median largest extent of the bodies]
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub(in crate::cli) neighbourhood: Option<f64>,
    /// Largest angle between touching bodies of one microdomain, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = relcp::measure::DOMAIN_ANGLE, value_parser = positive)]
    pub(in crate::cli) domain_angle: f64,
    /// Pairs nearer than this touch, a length [default: a thousandth of the thinnest body]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub(in crate::cli) cutoff: Option<f64>,
    /// Seed for sampling bodies in the correlation of large states
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) seed: u64,
    /// Number of threads [default: one per core]. The bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
    #[command(flatten)]
    pub(in crate::cli) figures: Figures,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  relcp render runs/colony   every state, and movie.mp4
  relcp render runs/colony --colour age --size 1280x720 --movie colony.mp4
  relcp render runs/colony --colour pressure
      of a run with --set output.forces=true
  relcp render runs/colony --from 2 --to 4 --every 5 --background dark
  relcp render runs/colony --last --out final
      one picture
  relcp render runs/colony --movie colony.png
      an animated PNG, which web pages play
  relcp render runs/colony --last --format pdf
      as vectors, for a paper

frames/000000.png and so on share one camera and one colour scale, fitted to all frames; frames.json lists the state \
of each frame. The command replaces the frames of an earlier rendering, complete or not.
A video needs `ffmpeg` on the path; an animated PNG does not. --backend gpu casts the rays on a GPU.";

#[derive(Args, Debug)]
#[command(after_help = RENDER_EXAMPLES)]
pub(in crate::cli) struct Render {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN", add = complete::run())]
    pub(in crate::cli) run: PathBuf,
    /// Output folder [default: RUN/render; for a single file NAME-render in the current folder]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// Quantity shown by the colours
    #[arg(long, value_enum, default_value = "orientation")]
    pub(in crate::cli) colour: Quantity,
    /// Range of the colour scale, as in 0:2.5 [default: all values, except the largest hundredth of speeds, overlaps,
    /// forces and pressures]
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = range)]
    pub(in crate::cli) range: Option<[f64; 2]>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub(in crate::cli) size: [u32; 2],
    /// Camera position [default: above a planar run, otherwise oblique]
    #[arg(long, value_enum)]
    pub(in crate::cli) view: Option<Side>,
    /// Background
    #[arg(long, value_enum, default_value = "white")]
    pub(in crate::cli) background: Background,
    /// Format: pixels, or vectors 178 mm wide for a planar run seen from the top
    #[arg(long, value_enum, default_value = "png")]
    pub(in crate::cli) format: Format,
    /// States that set the camera and the colour scale
    #[arg(long, value_enum, default_value = "run")]
    pub(in crate::cli) fit: Fit,
    /// Draw only bodies: no time, number of bodies, scale bar or colour scale
    #[arg(long)]
    pub(in crate::cli) bare: bool,
    #[command(flatten)]
    pub(in crate::cli) which: Which,
    /// Frames per second of the movie
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=MOST_A_SECOND))]
    pub(in crate::cli) fps: u32,
    /// Movie file: .png (animated) or .apng, or with `ffmpeg` .mp4, .mov or .mkv [default: movie.mp4, if `ffmpeg` is
    /// installed]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "no_movie")]
    pub(in crate::cli) movie: Option<PathBuf>,
    /// Make no movie, even if `ffmpeg` is installed
    #[arg(long)]
    pub(in crate::cli) no_movie: bool,
    /// Backend for ray casting: cpu and auto use the CPU; gpu a hardware GPU, or else a software adapter
    #[arg(long, default_value = "auto", value_parser = BackendParser)]
    pub(in crate::cli) backend: Backend,
    /// The adapter, by a part of its name; `relcp devices` lists them
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) adapter: Option<String>,
    /// Number of threads [default: one per core]. The bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

/// Which states of a run.
#[derive(Args, Debug)]
pub(in crate::cli) struct Which {
    /// The last state only
    #[arg(long, conflicts_with_all = ["every", "from", "to"])]
    pub(in crate::cli) last: bool,
    /// Every Nth state
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(in crate::cli) every: u32,
    /// From this time on
    #[arg(long, value_name = "TIME", value_parser = length)]
    pub(in crate::cli) from: Option<f64>,
    /// Up to this time
    #[arg(long, value_name = "TIME", value_parser = length)]
    pub(in crate::cli) to: Option<f64>,
}

const VIEW_EXAMPLES: &str = "\
Examples:
  relcp view runs/colony          every state, into runs/colony/view.html
  relcp view runs/colony --open   and opens it in the browser
  relcp view runs/colony --colour pressure --from 2 --every 5 --out colony.html
  relcp run colony --view         at the end of a run

The file needs no network and no other file. docs/view.md lists the keys.
The command replaces an earlier page only when the new one is complete.";

#[derive(Args, Debug)]
#[command(after_help = VIEW_EXAMPLES)]
pub(in crate::cli) struct View {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN", add = complete::run())]
    pub(in crate::cli) run: PathBuf,
    /// Output file [default: RUN/view.html; for a single file NAME-view.html in the current folder]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// First colour; the page offers every colour that the states have data for [default: one that shows something:
    /// groups, clones of a colony, rings by their ids, directions of rods]
    #[arg(long, value_enum)]
    pub(in crate::cli) colour: Option<Quantity>,
    #[command(flatten)]
    pub(in crate::cli) which: Which,
    /// Open the page in this machine's browser
    #[arg(long)]
    pub(in crate::cli) open: bool,
    /// Number of threads [default: one per core]. The bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}
