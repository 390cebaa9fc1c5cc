//! `relcp completions` and `relcp man`, both made from the definition of the arguments.

use super::arguments::{Arguments, Completions, Man};
use super::exit::{CliError, Exit};
use super::output;
use clap::{Command, CommandFactory};
use clap_complete::env::{CompleteEnv, Shells};
use relcp::scene::nearest;

const NAME: &str = "relcp";
/// The variable with which a shell's script requests completions.
const ASKED: &str = "RELCP_COMPLETE";
/// The foot of a page.
const SOURCE: &str = concat!("relcp ", env!("CARGO_PKG_VERSION"));

pub(super) fn completions(arguments: &Completions) -> Result<Exit, CliError> {
    let shells = Shells::builtins();
    let shell = shells.completer(&arguments.shell.to_string());
    let shell = shell.ok_or_else(|| CliError::Usage(format!("{} has no completions", arguments.shell)))?;
    output::write(|out| shell.write_registration(ASKED, NAME, NAME, NAME, &mut *out))?;
    Ok(Exit::Done)
}

/// Prints completions and exits, if a shell's script requests them.
pub(super) fn complete() {
    CompleteEnv::with_factory(Arguments::command).var(ASKED).complete();
}

pub(super) fn man(arguments: &Man) -> Result<Exit, CliError> {
    let mut program = Arguments::command().disable_help_subcommand(true);
    // Gives the commands their full names, as in `relcp-run`.
    program.build();
    let page = match &arguments.command {
        None => program,
        Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
            let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
            let near = nearest(name, names.iter().copied()).map(|near| format!("; the nearest is `{near}`"));
            let near = near.unwrap_or_default();
            CliError::Usage(format!("unknown command `{name}`{near}; the commands are {}", names.join(", ")))
        })?,
    };
    output::write(|out| clap_mangen::Man::new(page).source(SOURCE).render(&mut *out))?;
    Ok(Exit::Done)
}
