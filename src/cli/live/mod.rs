//! `relcp run --live`: a run that is watched and steered in a browser.
//!
//! * `desk`: what the run and its page have in common: what is asked of the run, and what it tells;
//! * `driver`: the run's side, between two steps;
//! * `frames`: states for the page, at a bounded cost;
//! * `curves`: the run's figures over its steps, thinned;
//! * `server`: connections, `request`: one request, `routes`: who may ask for what, `answer`: what is sent back.

mod answer;
mod curves;
mod desk;
mod driver;
mod frames;
mod request;
mod routes;
mod server;

pub(super) use driver::Driver;
pub(super) use server::Server;

use super::exit::CliError;
use super::output;
use relcp::run::Run;

/// Serves the page of a run, and says where.
pub(super) fn serve(server: Server, run: &Run) -> Result<Driver, CliError> {
    let address = server.address();
    let (driver, desk) = Driver::start(run)?;
    server.serve(desk)?;
    output::message(&format!("the run waits; open its page and press Play: {address}"));
    Ok(driver)
}
