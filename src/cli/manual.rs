//! `relcp completions` and `relcp man`, both made from the definition of the arguments.

use super::arguments::{Arguments, Completions, Man};
use super::exit::{CliError, Exit};
use super::output;
use clap::{Command, CommandFactory};

const NAME: &str = "relcp";
/// What stands at the foot of a page.
const SOURCE: &str = concat!("relcp ", env!("CARGO_PKG_VERSION"));

pub(super) fn completions(arguments: &Completions) -> Result<Exit, CliError> {
    // Into memory first: the generator takes a writer that fails for a panic.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), NAME, &mut script);
    output::write(|out| out.write_all(&script))?;
    Ok(Exit::Done)
}

pub(super) fn man(arguments: &Man) -> Result<Exit, CliError> {
    let mut program = Arguments::command().disable_help_subcommand(true);
    // Gives the commands their full names, as in `relcp-run`.
    program.build();
    let page = match &arguments.command {
        None => program,
        Some(name) => program.find_subcommand(name).cloned().ok_or_else(|| {
            let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
            CliError::Usage(format!("there is no command `{name}`; the commands are {}", names.join(", ")))
        })?,
    };
    output::write(|out| clap_mangen::Man::new(page).source(SOURCE).render(&mut *out))?;
    Ok(Exit::Done)
}
