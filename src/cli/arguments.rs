//! The program's arguments.

use crate::render::{Background, Fit, Quantity, Side, View};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// More threads than this are a slip of the pen.
const MOST_THREADS: i64 = 1024;

/// No screen shows more pictures a second than this.
const MOST_A_SECOND: i64 = 240;

/// Rigid smooth bodies in contact: spheres, spherocylinders, ellipsoids and rings that do not overlap.
#[derive(Debug, Parser)]
#[command(name = "relcp", version, max_term_width = 100, after_help = EXIT_STATUS)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) command: Command,
}

const EXIT_STATUS: &str = "\
Exit status:
  0    done, and every step met its tolerances
  1    an internal fault, or a step that could not be taken
  2    bad arguments or a bad scene; nothing was written
  3    the run went to its end, but some step did not meet its tolerances (the summary says which)
  4    a file could not be read or written
  5    no usable adapter, or the device was lost
  130  interrupted; a checkpoint was written";

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Run a scene
    Run(Run),
    /// Run many variants of a scene from one file, one folder each
    Batch(Batch),
    /// List the built-in scenes, or print one
    Scenes(Scenes),
    /// Read and validate a scene, run nothing
    Check(Check),
    /// Print the pairs of bodies that are near or overlap
    Contacts(Contacts),
    /// Write a run's states in another format, for OVITO or ParaView
    Export(Export),
    /// Measure a run's states: order, correlation, packing, contacts, stress and more
    Measure(Measure),
    /// Make pictures of a run's states, and a movie
    Render(Render),
    /// Measure, and write tables
    Study(Study),
    /// List the adapters of this machine, and which one would be taken
    Devices(Devices),
    /// Print the JSON Schema of scene files, or of sweep files
    Schema(Schema),
    /// Print a script that completes commands and options in a shell
    Completions(Completions),
    /// Print a page of the manual, for `man`
    Man(Man),
}

/// How to compute.
#[derive(Args, Clone, Debug)]
pub(super) struct Compute {
    /// What computes: auto takes a hardware GPU if there is one, else the CPU; gpu takes a software adapter too
    #[arg(long, value_enum, default_value = "auto")]
    pub(super) backend: Backend,
    /// The adapter, by a part of its name; `relcp devices` lists them
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Which numbers to compute with; without it f32 on a GPU and f64 on the CPU
    #[arg(long, value_enum)]
    pub(super) precision: Option<Precision>,
    /// How many threads; without it, one a core. The results are the same bits for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(super) threads: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Backend {
    Auto,
    Cpu,
    Gpu,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Precision {
    F32,
    F64,
}

/// What to print.
#[derive(Args, Clone, Debug)]
pub(super) struct Print {
    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub(super) json: bool,
    /// Print no progress and no summary; messages of faults remain
    #[arg(long)]
    pub(super) quiet: bool,
}

const RUN_EXAMPLES: &str = "\
Examples:
  relcp run two-ellipsoids                             a built-in scene, into runs/two-ellipsoids
  relcp run colony.json --out runs/slow --set growth.rate=0.1
  relcp run --resume --out runs/slow                   go on with a run that was stopped
  relcp run colony.json --json | jq .max_overlap

Ctrl-C ends the run after the step being taken and leaves a checkpoint, as every minute does;
a second one quits at once.
The folder has scene.json, steps.csv, states/, final.json, final.png, summary.json and the checkpoint.";

#[derive(Args, Debug)]
#[command(after_help = RUN_EXAMPLES)]
pub(super) struct Run {
    /// A scene file, or the name of a built-in scene; with --resume and --out it may be left out
    #[arg(value_name = "SCENE")]
    pub(super) scene: Option<String>,
    /// The run's folder, new or empty; without it, runs/NAME, or runs/NAME-2 and so on where that is taken
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Replace a value of the scene by its dotted key, as in time.dt=0.01 or bodies.0.position=[0,0,1]
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) sets: Vec<String>,
    /// Go on with an earlier run from its checkpoint, to the same bits as if it had not stopped: the one in --out,
    /// or the latest of this scene in runs/
    #[arg(long)]
    pub(super) resume: bool,
    /// Write a checkpoint at least so often; without it, every minute
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) checkpoint_every: Option<Duration>,
    /// Stop with a checkpoint, as by Ctrl-C, after the step in which this much time has passed
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(super) max_wall: Option<Duration>,
    /// Print where the time went and the most memory held; on a device also pipelines, buffers, dispatches and read-backs
    #[arg(long)]
    pub(super) profile: bool,
    #[command(flatten)]
    pub(super) compute: Compute,
    #[command(flatten)]
    pub(super) print: Print,
}

/// A time span, in seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let number: f64 = text.parse().map_err(|_| "not a number of seconds".to_string())?;
    Duration::try_from_secs_f64(number).map_err(|e| e.to_string())
}

const BATCH_EXAMPLES: &str = "\
Examples:
  relcp batch rates.json                               every member, as many at a time as there are cores
  relcp batch rates.json --list                        what would be run, and where
  relcp batch rates.json --index 3 --threads 4         one member, as a job of a cluster
  relcp batch rates.json --table                       the table of what is there so far

A sweep file: {\"name\": \"rates\", \"scene\": \"colony\", \"set\": {\"time.end\": 4},
  \"grid\": {\"growth.rate\": [0.5, 1, 2]}, \"seeds\": {\"from\": 1, \"count\": 5}}
The same command again leaves finished members alone and goes on with those that were stopped.
Ctrl-C stops all of them with checkpoints. The exit status is the worst of the members'.";

#[derive(Args, Debug)]
#[command(after_help = BATCH_EXAMPLES)]
pub(super) struct Batch {
    /// A sweep file; `relcp schema --sweep` describes it
    #[arg(value_name = "SWEEP")]
    pub(super) sweep: PathBuf,
    /// The folder with the members' folders; without it, runs/NAME
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Most members at a time; without it, one a core, and on a device one. The results are the same bits for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(super) jobs: Option<u16>,
    /// Go on with members that failed, too, from their last good state
    #[arg(long)]
    pub(super) retry: bool,
    /// Run this member alone, from 0, and write no table
    #[arg(long, value_name = "K", group = "part")]
    pub(super) index: Option<usize>,
    /// Print how many members there are, run nothing
    #[arg(long, group = "part")]
    pub(super) count: bool,
    /// Print the members, what they vary, and their folders, run nothing
    #[arg(long, group = "part")]
    pub(super) list: bool,
    /// Make the table of what is there, run nothing
    #[arg(long, group = "part")]
    pub(super) table: bool,
    #[command(flatten)]
    pub(super) compute: Compute,
    #[command(flatten)]
    pub(super) print: Print,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  relcp schema > scene.schema.json\n  relcp schema --markdown | less")]
pub(super) struct Schema {
    /// That of sweep files, for `relcp batch`
    #[arg(long)]
    pub(super) sweep: bool,
    /// The keys of a scene as a page of Markdown instead
    #[arg(long, conflicts_with = "sweep")]
    pub(super) markdown: bool,
}

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  relcp completions bash > ~/.local/share/bash-completion/completions/relcp
  relcp completions zsh > ~/.zfunc/_relcp
  relcp completions fish > ~/.config/fish/completions/relcp.fish";

#[derive(Args, Debug)]
#[command(after_help = COMPLETIONS_EXAMPLES)]
pub(super) struct Completions {
    /// Which shell
    #[arg(value_enum)]
    pub(super) shell: clap_complete::Shell,
}

const MAN_EXAMPLES: &str = "\
Examples:
  relcp man | man -l -
  relcp man run > relcp-run.1";

#[derive(Args, Debug)]
#[command(after_help = MAN_EXAMPLES)]
pub(super) struct Man {
    /// The page of this command; without it, that of the program
    #[arg(value_name = "COMMAND")]
    pub(super) command: Option<String>,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  relcp scenes two-ellipsoids > mine.json")]
pub(super) struct Scenes {
    /// Print this one, as JSON
    pub(super) name: Option<String>,
    /// List them as JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum StudyName {
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
    /// Small scenes of the kinds that break contact codes, with a verdict on each
    Hard,
    /// All of them, each in a folder of its own, and an index of their pages
    All,
}

const STUDY_EXAMPLES: &str = "\
Examples:
  relcp study throughput --backend gpu --largest 131072
  relcp study solvers --quick
  relcp study two-ellipsoids --out docs/studies/two-ellipsoids
  relcp study hard --quick
  relcp study all --quick --out studies                some minutes
  relcp run colony --set solver.dump.when=slow --out runs/slow
  relcp study solvers runs/slow                        every solver on the LCPs that were slow there";

#[derive(Args, Clone, Debug)]
#[command(after_help = STUDY_EXAMPLES)]
pub(super) struct Study {
    /// Which study
    #[arg(value_enum)]
    pub(super) name: StudyName,
    /// For solvers: files of LCPs, folders of them, or runs with them (see solver.dump), in place of the built-in ones
    #[arg(value_name = "FILES")]
    pub(super) files: Vec<PathBuf>,
    /// For throughput: the largest number of bodies
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    pub(super) largest: usize,
    /// For throughput: the smallest number of bodies
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) smallest: usize,
    /// For throughput: what is stepped, if not both
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) of: Option<crate::study::throughput::Kind>,
    /// For throughput: steps timed of each size
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) steps: u32,
    /// For throughput: steps taken before those
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(super) warm_up: u32,
    /// Fewer iterations, or fewer and shorter runs: a minute or two at most; of throughput with all only
    #[arg(long)]
    pub(super) quick: bool,
    /// Where the tables go; with all, a folder for each study in it
    #[arg(long, value_name = "DIR", default_value = "studies")]
    pub(super) out: PathBuf,
    #[command(flatten)]
    pub(super) compute: Compute,
    #[command(flatten)]
    pub(super) print: Print,
}

#[derive(Args, Debug)]
pub(super) struct Devices {
    /// Which one would be taken of those with this in their names
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    #[command(flatten)]
    pub(super) print: Print,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  relcp check mine.json --set time.end=2")]
pub(super) struct Check {
    /// A scene file, or the name of a built-in scene
    #[arg(value_name = "SCENE")]
    pub(super) scene: String,
    /// Replace a value of the scene by its dotted key
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) sets: Vec<String>,
    #[command(flatten)]
    pub(super) print: Print,
}

const CONTACTS_EXAMPLES: &str = "\
Examples:
  relcp contacts runs/colony
  relcp contacts runs/colony/final.json --json
  relcp contacts runs/colony/states/state_0000000100.npz --cutoff 0.01";

#[derive(Args, Debug)]
#[command(after_help = CONTACTS_EXAMPLES)]
pub(super) struct Contacts {
    /// A scene file, a run's final.json, one of its states (.npz; it knows no walls), or a run's folder: the state that it stands at
    #[arg(value_name = "STATE")]
    pub(super) state: String,
    /// Pairs nearer than this, a length; in a periodic scene at most the shortest period
    #[arg(long, value_name = "LENGTH", default_value_t = 0.0, allow_negative_numbers = true, value_parser = length)]
    pub(super) cutoff: f64,
    #[command(flatten)]
    pub(super) compute: Compute,
    #[command(flatten)]
    pub(super) print: Print,
}

const EXPORT_EXAMPLES: &str = "\
Examples:
  relcp export runs/colony --format gsd          one file, runs/colony/gsd/colony.gsd: ovito runs/colony/gsd/colony.gsd
  relcp export runs/colony --format vtk          collections of states: paraview --script=runs/colony/vtk/show.py
  relcp export runs/colony/final.json --format gsd --out final
  relcp export runs/colony --format vtk --cutoff 0.01 --json | jq .files

gsd: a frame a state; a type of particles for each size of a shape (for growing rods, 256 classes; exact sizes in log/).
vtk: bodies.pvd, axes.pvd and contacts.pvd with the times of the run, and show.py, which shows them in ParaView.
Every file appears whole or not at all.";

/// A format to export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ExportFormat {
    /// For OVITO and HOOMD's tools
    Gsd,
    /// For ParaView
    Vtk,
}

#[derive(Args, Debug)]
#[command(after_help = EXPORT_EXAMPLES)]
pub(super) struct Export {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN")]
    pub(super) run: String,
    /// The format
    #[arg(long, value_enum)]
    pub(super) format: ExportFormat,
    /// Where the files go; without it RUN/gsd or RUN/vtk, and for what is no folder NAME-gsd or NAME-vtk here
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Pairs nearer than this are contacts, a length; without it a thousandth of the thinnest body. With vtk only
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = length)]
    pub(super) cutoff: Option<f64>,
    /// How many threads; without it, one a core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    pub(super) print: Print,
}

const MEASURE_EXAMPLES: &str = "\
Examples:
  relcp measure runs/colony                      every measure of every state, into runs/colony/measures
  relcp measure runs/colony --only nematic,correlation
  relcp measure runs/colony --last --json | jq '.states[0].values'
  relcp measure runs/colony/states/state_0000000100.npz --domain-angle 5 --out at-100

measures.csv has a row a state, NAME.csv the rows of a profile by state, measures.json all of it; plots are SVG.
What a state cannot give is an empty cell, and the reason stands in measures.json. Contact forces are known
in the checkpoint, and in all states of a run with output.forces; stress and force chains are measured of these.";

#[derive(Args, Debug)]
#[command(after_help = MEASURE_EXAMPLES)]
pub(super) struct Measure {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN")]
    pub(super) run: String,
    /// These measures only, by commas or as often as needed: nematic, correlation, radius, packing, density, length,
    /// contacts, stress, force_chains, microdomains, dissipation
    #[arg(long, value_name = "MEASURE", value_delimiter = ',')]
    pub(super) only: Vec<String>,
    /// The last state only
    #[arg(long)]
    pub(super) last: bool,
    /// Where the files go; without it RUN/measures, and for what is no folder NAME-measures here
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Width of the bins of distance, a length; without it the median thickness of the bodies
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub(super) bin: Option<f64>,
    /// Radius of the neighbourhood of local order, a length; without it the median largest extent of the bodies
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub(super) neighbourhood: Option<f64>,
    /// Largest angle between touching bodies of one microdomain, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = crate::measure::DOMAIN_ANGLE, value_parser = positive)]
    pub(super) domain_angle: f64,
    /// Pairs nearer than this touch, a length; without it a thousandth of the thinnest body
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = length)]
    pub(super) cutoff: Option<f64>,
    /// What bodies are drawn by where the correlation is sampled
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// How many threads; without it, one a core. The results are the same bits for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    pub(super) print: Print,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  relcp render runs/colony                       every state, into runs/colony/render/frames, and movie.mp4
  relcp render runs/colony --colour age --size 1280x720 --fps 30 --movie colony.mp4
  relcp render runs/colony --colour pressure     of a run with --set output.forces=true
  relcp render runs/colony --from 2 --to 4 --every 5 --fit each --background dark
  relcp render runs/colony/final.json --out final

frames/000000.png and so on have one camera and one scale of colours, fitted to all of them; frames.json says
which state each shows. What an earlier rendering left in the folder, whole or not, is replaced.
A movie is made where `ffmpeg` is on the path.";

#[derive(Args, Debug)]
#[command(after_help = RENDER_EXAMPLES)]
pub(super) struct Render {
    /// A run's folder, one of its states (.npz), a scene file, or the name of a built-in scene
    #[arg(value_name = "RUN")]
    pub(super) run: String,
    /// Where the files go; without it RUN/render, and for what is no folder NAME-render here
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// What the colours tell
    #[arg(long, value_enum, default_value = "orientation")]
    pub(super) colour: Quantity,
    /// The ends of the scale of colours, as in 0:2.5; without it the values of all states fit, but for the largest
    /// hundredth of speeds, overlaps, forces and pressures
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = range)]
    pub(super) range: Option<[f64; 2]>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = size)]
    pub(super) size: [u32; 2],
    /// Where bodies are seen from; without it the top in a planar run, else obliquely
    #[arg(long, value_enum)]
    pub(super) view: Option<Side>,
    /// What stands behind the bodies
    #[arg(long, value_enum, default_value = "white")]
    pub(super) background: Background,
    /// What camera and scale of colours are fitted to
    #[arg(long, value_enum, default_value = "run")]
    pub(super) fit: Fit,
    /// No words in the pictures: neither time, number of bodies, bar of length nor scale of colours
    #[arg(long)]
    pub(super) bare: bool,
    /// Every so many states
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) every: u32,
    /// From this time on
    #[arg(long, value_name = "TIME", allow_negative_numbers = true, value_parser = length)]
    pub(super) from: Option<f64>,
    /// Up to this time
    #[arg(long, value_name = "TIME", allow_negative_numbers = true, value_parser = length)]
    pub(super) to: Option<f64>,
    /// Pictures a second of the movie
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u32).range(1..=MOST_A_SECOND))]
    pub(super) fps: u32,
    /// The movie, .mp4, .mov or .mkv; without it movie.mp4 beside frames, where there is `ffmpeg`
    #[arg(long, value_name = "FILE", conflicts_with = "no_movie")]
    pub(super) movie: Option<PathBuf>,
    /// No movie, also where there is `ffmpeg`
    #[arg(long)]
    pub(super) no_movie: bool,
    /// How many threads; without it, one a core. The results are the same bits for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    pub(super) print: Print,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|side| (1..=View::LARGEST_SIDE).contains(side)) => Ok(sides),
        _ => Err(format!("it is not two numbers of pixels from 1 to {}, as in 1920x1080", View::LARGEST_SIDE)),
    }
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once(':').ok_or("it is not two numbers, as in 0:2.5")?;
    match [length(low)?, length(high)?] {
        [low, high] if low < high => Ok([low, high]),
        _ => Err("the first number is not below the second".into()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match length(text)? {
        value if value > 0.0 => Ok(value),
        _ => Err("it is not above zero".into()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("it is not a finite number".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }
}
