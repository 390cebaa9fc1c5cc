//! Arguments, messages and exit statuses around the studies.

mod all;
mod arguments;
mod compute;
mod device;
mod fault;
mod hard;
mod inertia;
mod interrupt;
mod output;
mod paper;
mod solvers;
mod study;
mod work_precision;

use arguments::Arguments;
use clap::Parser;
use fault::Exit;
use relcp::internals::program;
use std::process::ExitCode;

/// Runs the program on its arguments.
pub fn main() -> ExitCode {
    program::prepare();
    std::panic::set_hook(Box::new(|panic| {
        output::message(&format!("internal fault, please report it with the command: {panic}"));
        std::process::exit(Exit::Internal as i32);
    }));
    let arguments = Arguments::parse();
    program::start_log(arguments.log);
    let exit = study::study(&arguments).unwrap_or_else(|error| {
        let exit = error.exit();
        output::report(error);
        exit
    });
    ExitCode::from(exit as u8)
}
