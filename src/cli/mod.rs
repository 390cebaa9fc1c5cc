//! The program: arguments, messages and exit statuses around the library.

mod arguments;
mod batch;
mod batch_devices;
mod batch_progress;
mod compiling;
mod compute;
mod contacts;
mod devices;
mod driver;
mod exit;
mod export;
mod hint;
mod interrupt;
mod live;
mod manual;
mod measure;
mod output;
mod placing;
#[cfg(feature = "mpi")]
mod processes;
mod progress;
mod render;
mod report;
mod resume;
mod run;
mod scenes;
mod view;
mod watched;

use arguments::{Arguments, Command};
use exit::{CliError, Exit};
use relcp::internals::program;
use std::process::ExitCode;

/// Runs the program on its arguments.
pub fn main() -> ExitCode {
    manual::complete();
    program::prepare();
    interrupt::outlive_file_limits();
    std::panic::set_hook(Box::new(|panic| {
        output::message(&format!("internal fault, please report it with the scene and the command: {panic}"));
        std::process::exit(Exit::Internal as i32);
    }));
    let arguments = Arguments::of_program();
    program::start_log(arguments.log.map(Into::into));
    let exit = dispatch(arguments.command).unwrap_or_else(|error| {
        let exit = error.exit();
        output::report(error);
        exit
    });
    ExitCode::from(exit as u8)
}

fn dispatch(command: Command) -> Result<Exit, CliError> {
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Batch(arguments) => batch::batch(&arguments),
        Command::Scenes(arguments) => scenes::scenes(&arguments),
        Command::Check(arguments) => scenes::check(&arguments),
        Command::Contacts(arguments) => contacts::contacts(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Measure(arguments) => measure::measure(&arguments),
        Command::Render(arguments) => render::render(&arguments),
        Command::View(arguments) => view::view(&arguments),
        Command::Devices(arguments) => devices::devices(&arguments),
        Command::Schema(arguments) => scenes::schema(&arguments),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Man(arguments) => manual::man(&arguments),
    }
}
