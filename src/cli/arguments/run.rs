//! Arguments of commands that compute.

use super::backend::BackendParser;
use super::{MOST_THREADS, complete};
use clap::{Args, ValueEnum, ValueHint};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How to compute.
#[derive(Args, Clone, Debug)]
pub(in crate::cli) struct Compute {
    /// Backend: auto uses the CPU, and prints a hint if a hardware GPU may be faster. gpu uses a hardware GPU, or
    /// else a software adapter. mpi runs one simulation on all MPI ranks of mpirun or srun, to the same
    /// bits
    #[arg(long, default_value = "auto", value_parser = BackendParser)]
    pub(in crate::cli) backend: Backend,
    /// The adapter, by a part of its name; `relcp devices` lists them
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) adapter: Option<String>,
    /// Floating-point precision [default: f64 on the CPU and on a software adapter, f32 on a hardware GPU]
    #[arg(long, value_enum)]
    pub(in crate::cli) precision: Option<Precision>,
    /// Number of threads [default: one per core; with --backend mpi one]. The bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) threads: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Backend {
    Auto,
    Cpu,
    Gpu,
    Mpi,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Precision {
    F32,
    F64,
}

/// What to print.
#[derive(Args, Clone, Debug)]
pub(in crate::cli) struct Print {
    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub(in crate::cli) json: bool,
    /// Print no progress and no summary; messages of faults remain
    #[arg(long)]
    pub(in crate::cli) quiet: bool,
}

const RUN_EXAMPLES: &str = "\
Examples:
  relcp run two-ellipsoids
      a built-in scene, into runs/two-ellipsoids
  relcp run colony.json --out runs/slow --set growth.rate=0.1
  relcp run --resume --out runs/slow   resume a stopped run
  relcp run --resume --until 20 --out runs/slow
      continue it past its end
  relcp run --from runs/slow@8 --set growth.rate=0.3
      another run from its state at time 8, with a changed key
  relcp run colony --live
      watch and steer it in a browser, at the printed address
  relcp run colony.json --json | jq .max_overlap

Ctrl-C ends the run after the current step and writes a checkpoint. A second Ctrl-C quits at once.
The folder contains scene.json, steps.csv, states/, final.json, final.png, summary.json and the checkpoint.";

#[derive(Args, Debug)]
#[command(after_help = RUN_EXAMPLES)]
pub(in crate::cli) struct Run {
    /// A scene file, the name of a built-in scene, or - for the standard input; optional with --resume and --from
    #[arg(value_name = "SCENE", add = complete::scene())]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// The run's folder, new or empty [default: runs/NAME, or runs/NAME-2 and so on if that exists]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// Replace a value of the scene by its dotted key, as in time.dt=0.01 or bodies.0.position=[0,0,1]
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(in crate::cli) sets: Vec<String>,
    /// Continue an earlier run from its checkpoint, to the same bits as an uninterrupted run: the run in --out,
    /// or the newest unfinished one in runs/, of this scene if one is given
    #[arg(long)]
    pub(in crate::cli) resume: bool,
    /// With --resume: continue to this time of the scene, later than the run's own end, in the same folder; a finished
    /// run continues too, to the same bits as a run that was started with this end
    #[arg(long, value_name = "TIME", requires = "resume", value_parser = super::number::length)]
    pub(in crate::cli) until: Option<f64>,
    /// Begin with a state of another run: its last one, or the last that is not later than TIME. SCENE is by default
    /// that of the other run; --set changes its keys. The folder's from.json names the other run
    #[arg(long, value_name = "RUN[@TIME]", value_hint = ValueHint::DirPath, value_parser = recorded)]
    #[arg(conflicts_with = "resume")]
    pub(in crate::cli) from: Option<Recorded>,
    /// Largest time between checkpoints [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(in crate::cli) checkpoint_every: Option<Duration>,
    /// Stop with a checkpoint, as by Ctrl-C, after the step in which this much time has passed
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(in crate::cli) max_wall: Option<Duration>,
    /// At the end write a page that shows the run in a browser, like `relcp view`
    #[arg(long)]
    pub(in crate::cli) view: bool,
    /// Serve a page on this computer that shows the run while it goes on, and steers it: play, pause, step, other
    /// values of keys, end. The run waits at its start for the page. The address has a token; only who knows it can
    /// use the page
    #[arg(long)]
    pub(in crate::cli) live: bool,
    /// With --live: the port of the page [default: a free one]
    #[arg(long, value_name = "N", requires = "live", value_parser = clap::value_parser!(u16).range(1..))]
    pub(in crate::cli) port: Option<u16>,
    /// Print a profile: wall time by phase and peak memory; on a GPU also times, dispatches, read-backs and bytes by
    /// stage, pipelines and buffers
    #[arg(long)]
    pub(in crate::cli) profile: bool,
    #[command(flatten)]
    pub(in crate::cli) compute: Compute,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}

/// A state of a run: its last one, or the last that is not later than a time.
#[derive(Clone, Debug)]
pub(in crate::cli) struct Recorded {
    pub(in crate::cli) run: PathBuf,
    pub(in crate::cli) time: Option<f64>,
}

/// `RUN` or `RUN@TIME`. A folder with an `@` in its own name is found under that name.
fn recorded(text: &str) -> Result<Recorded, String> {
    match text.rsplit_once('@') {
        Some((run, time)) if !Path::new(text).exists() => {
            let time = super::number::length(time).map_err(|why| format!("the time after @: {why}"))?;
            Ok(Recorded { run: run.into(), time: Some(time) })
        }
        _ => Ok(Recorded { run: text.into(), time: None }),
    }
}

/// A time span, in seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let number: f64 = text.parse().map_err(|_| "it is not a number of seconds".to_string())?;
    Duration::try_from_secs_f64(number).map_err(|_| "it is not a time of 0 seconds or more".into())
}

const BATCH_EXAMPLES: &str = "\
Examples:
  relcp batch rates.json           every member, as many at once as cores
  relcp batch rates.json --list    the members and their folders
  relcp batch rates.json --index 3 --threads 4
      one member, as a job of a cluster
  relcp batch rates.json --table   the table of the results so far

A sweep file: {\"name\": \"rates\", \"scene\": \"colony\", \"set\": {\"time.end\": 4},
  \"grid\": {\"growth.rate\": [0.5, 1, 2]}, \"seeds\": {\"from\": 1, \"count\": 5}}
Repeat the command to continue the members that were stopped; finished members are left alone.
Ctrl-C stops all of them with checkpoints. The exit status is the worst of all members.";

#[derive(Args, Debug)]
#[command(after_help = BATCH_EXAMPLES)]
pub(in crate::cli) struct Batch {
    /// A sweep file; `relcp schema --sweep` describes it
    #[arg(value_name = "SWEEP", value_hint = ValueHint::FilePath)]
    pub(in crate::cli) sweep: PathBuf,
    /// The folder of the members' folders [default: runs/NAME]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(in crate::cli) out: Option<PathBuf>,
    /// Most concurrent members [default: one per core; with --backend gpu 64, which the device computes as one]. The
    /// bits of the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub(in crate::cli) jobs: Option<u16>,
    /// Also continue failed members, from their last accepted state
    #[arg(long)]
    pub(in crate::cli) retry: bool,
    /// Run only this member, numbered from 0, and write no table
    #[arg(long, value_name = "K", group = "part")]
    pub(in crate::cli) index: Option<usize>,
    /// Print the number of members, without running them
    #[arg(long, group = "part")]
    pub(in crate::cli) count: bool,
    /// Print the members, their parameters and their folders, without running them
    #[arg(long, group = "part")]
    pub(in crate::cli) list: bool,
    /// Write the table of the results so far, without running
    #[arg(long, group = "part")]
    pub(in crate::cli) table: bool,
    #[command(flatten)]
    pub(in crate::cli) compute: Compute,
    #[command(flatten)]
    pub(in crate::cli) print: Print,
}
