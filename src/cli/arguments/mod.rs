//! The program's arguments: its commands, with the arguments of the small ones.

mod backend;
mod complete;
mod number;
mod run;
mod states;

pub(super) use run::{Backend, Batch, Compute, Precision, Print, Recorded, Run};
pub(super) use states::{Contacts, Export, ExportFormat, Measure, Render, View};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use log::LevelFilter;
use relcp::figure::Format;
use relcp::scene::nearest;
use std::path::PathBuf;

/// A larger number of threads is refused as a typing error.
const MOST_THREADS: i64 = 1024;

/// Rigid smooth bodies in contact: spheres, spherocylinders, ellipsoids and rings that do not overlap.
#[derive(Debug, Parser)]
#[command(name = "relcp", version, max_term_width = 100, after_help = EXIT_STATUS)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) command: Command,
    /// Write a log to standard error: info logs states and checkpoints, debug every step, trace every solve
    #[arg(long, global = true, value_name = "LEVEL", help_heading = "Logging")]
    pub(super) log: Option<Level>,
}

/// Level of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Level {
    Error,
    Warn,
    Info,
    Debug,
    Trace,
}

impl From<Level> for LevelFilter {
    fn from(level: Level) -> LevelFilter {
        match level {
            Level::Error => LevelFilter::Error,
            Level::Warn => LevelFilter::Warn,
            Level::Info => LevelFilter::Info,
            Level::Debug => LevelFilter::Debug,
            Level::Trace => LevelFilter::Trace,
        }
    }
}

const EXIT_STATUS: &str = "\
Exit status:
  0    done, and every step met its tolerances
  1    an internal fault
  2    bad arguments or a bad scene; nothing was written
  3    a step missed its tolerances: the run stopped there, or ended with such steps (see reason in summary.json)
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
    /// Read and validate a scene, without running it
    Check(Check),
    /// Print the pairs of bodies that are near or overlap
    Contacts(Contacts),
    /// Write a run's states in another format, for OVITO or ParaView
    Export(Export),
    /// Measure a run's states: order, correlation, packing, contacts, stress and more
    Measure(Measure),
    /// Make pictures of a run's states, and a movie
    Render(Render),
    /// Write one HTML file that shows a run in a browser
    View(View),
    /// List the adapters of this machine and mark the one that a run would use
    Devices(Devices),
    /// Print the JSON Schema of scene files, or of sweep files
    Schema(Schema),
    /// Print a script that completes commands and options in a shell
    Completions(Completions),
    /// Print a page of the manual, for `man`
    Man(Man),
}

/// The formats of figures.
#[derive(Args, Clone, Debug)]
pub(super) struct Figures {
    /// Formats of the figures, separated by commas: svg, pdf, png
    #[arg(long, value_enum, value_name = "FORMAT", value_delimiter = ',', default_value = "svg")]
    pub(super) figures: Vec<Format>,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  relcp schema > scene.schema.json\n  relcp schema --markdown | less")]
pub(super) struct Schema {
    /// Print the schema of sweep files, for `relcp batch`
    #[arg(long)]
    pub(super) sweep: bool,
    /// Print the keys of a scene as a page of Markdown instead
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
    /// The shell
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
    /// The command [default: the page of the program]
    #[arg(value_name = "COMMAND")]
    pub(super) command: Option<String>,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  relcp scenes two-ellipsoids > mine.json")]
pub(super) struct Scenes {
    /// Print this scene, as JSON
    #[arg(add = complete::built_in())]
    pub(super) name: Option<String>,
    /// List them as JSON
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args, Debug)]
pub(super) struct Devices {
    /// Mark the adapter that a run would use with this --adapter
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    #[command(flatten)]
    pub(super) print: Print,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  relcp check mine.json --set time.end=2")]
pub(super) struct Check {
    /// A scene file, the name of a built-in scene, or - for the standard input
    #[arg(value_name = "SCENE", add = complete::scene())]
    pub(super) scene: PathBuf,
    /// Replace a value of the scene by its dotted key
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) sets: Vec<String>,
    #[command(flatten)]
    pub(super) print: Print,
}

impl Arguments {
    /// Reads the program's arguments. A negative number is a value everywhere, never an unknown option, so that the
    /// option's own message refuses it.
    pub(super) fn of_program() -> Arguments {
        let matches = negative_numbers_are_values(Arguments::command()).try_get_matches();
        let matches = matches.unwrap_or_else(|error| with_nearest_command(error).exit());
        Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// The message for the former command `study`: the studies are a program of another crate, which is not installed with
/// this one.
const STUDIES: &str = "the studies are a separate program; in the repository: cargo run --release -p relcp-lab -- NAME";

/// Suggests the nearest command for an unknown one, even if it is too short for clap.
fn with_nearest_command(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    if name == "study" {
        return Arguments::command().error(ErrorKind::InvalidSubcommand, STUDIES);
    }
    if error.get(ContextKind::SuggestedSubcommand).is_none() {
        let command = Arguments::command();
        if let Some(near) = nearest(name, command.get_subcommands().map(clap::Command::get_name)) {
            error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![near.to_owned()]));
        }
    }
    error
}

fn negative_numbers_are_values(command: clap::Command) -> clap::Command {
    let takes_value = |arg: Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(takes_value).mut_subcommands(negative_numbers_are_values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }
}
