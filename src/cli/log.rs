//! The log on standard error: nothing unless `--log` or the variable `RELCP_LOG` sets a level.

use super::arguments::Level;
use env_logger::{Builder, Env};
use std::io::Write;
use std::time::Instant;

/// The variable that takes levels by module, as `relcp=debug,wgpu_core=info`; `--log` wins over it.
const VARIABLE: &str = "RELCP_LOG";

/// Starts it.
pub(super) fn start(level: Option<Level>) {
    // The graphics libraries have much to say: of them, faults alone.
    let filter = level.map(|level| format!("error,relcp={}", name(level)));
    let mut builder = match filter {
        Some(filter) => {
            let mut builder = Builder::new();
            builder.parse_filters(&filter);
            builder
        }
        None => Builder::from_env(Env::new().filter_or(VARIABLE, "off")),
    };
    let begun = Instant::now();
    builder.format(move |out, record| {
        let (seconds, level) = (begun.elapsed().as_secs_f64(), record.level());
        writeln!(out, "{seconds:9.3} {level:<5} {}: {}", record.target(), record.args())
    });
    // There is one logger in a program: where one is set already, it stays.
    let _ = builder.try_init();
}

fn name(level: Level) -> &'static str {
    match level {
        Level::Error => "error",
        Level::Warn => "warn",
        Level::Info => "info",
        Level::Debug => "debug",
        Level::Trace => "trace",
    }
}
