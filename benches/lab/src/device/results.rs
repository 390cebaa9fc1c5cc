//! The results so far, as a file that is written completely after each item and read to continue.

use super::clusters::ClusterRow;
use super::colony::Growth;
use super::constants::SmallRow;
use super::parity::Check;
use super::speed::{IterationRow, SpeedRow};
use crate::StudyError;
use relcp::gpu::Gpu;
use relcp::record::durable;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The format version of the file. Other versions are rejected.
const FORMAT: u32 = 1;

/// The name of the file.
pub const FILE: &str = "report.json";

/// The device and the program. Results of two of them do not belong in one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// The adapter's name.
    pub adapter: String,
    /// The driver and its version.
    pub driver: String,
    /// The program's version.
    pub version: String,
    /// Whether the program was built with debug assertions, which make times on the host long.
    pub debug: bool,
}

/// The finding of an item.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "found", rename_all = "snake_case", deny_unknown_fields)]
pub enum Finding {
    /// Differences from the CPU.
    Parity {
        /// The differences with their bounds.
        checks: Vec<Check>,
    },
    /// The copy bandwidth of the device.
    Bandwidth {
        /// Bytes read and written per second.
        bytes_a_second: f64,
    },
    /// The cost of steps.
    Speed(Box<SpeedRow>),
    /// An iteration by stages.
    Iteration {
        /// The times by problem and stage.
        rows: Vec<IterationRow>,
    },
    /// The problem size up to which one workgroup is faster than many.
    Small {
        /// The times by problem.
        rows: Vec<SmallRow>,
    },
    /// The time of an iteration by clusters, compared with one by pairs.
    Clusters(ClusterRow),
    /// A colony.
    Growth(Growth),
    /// A failure. The next call tries the item again.
    Failed {
        /// The reason.
        why: String,
    },
}

/// An item's result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Seconds that it took.
    pub wall_seconds: f64,
    /// Seconds since 1970 when it ended.
    pub ended_unix_seconds: u64,
    /// The finding.
    pub finding: Finding,
}

/// The file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Results {
    format: u32,
    /// The machine that computed the results.
    pub machine: Machine,
    /// The program, the processor and the system in words.
    pub host: String,
    /// Properties of the device, by name.
    pub device: BTreeMap<String, String>,
    /// The entries by item name.
    pub items: BTreeMap<String, Entry>,
    /// The items that the last call skipped, with reasons.
    pub skipped: BTreeMap<String, String>,
}

impl Machine {
    /// This one.
    pub fn of(gpu: &Gpu) -> Machine {
        Machine {
            adapter: gpu.name().to_owned(),
            driver: gpu.driver().to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            debug: cfg!(debug_assertions),
        }
    }

    fn words(&self) -> String {
        let Machine { adapter, driver, version, debug } = self;
        format!("{adapter} ({driver}) by program {version}{}", if *debug { " with debug assertions" } else { "" })
    }
}

impl Results {
    /// Those of a folder, or none yet.
    ///
    /// # Errors
    /// [`StudyError::Damaged`] for a file that cannot be read as results, [`StudyError::Elsewhere`] for one of another
    /// device, driver or version. Neither is overwritten.
    pub fn open(folder: &Path, gpu: &Gpu) -> Result<Results, StudyError> {
        let (path, machine) = (folder.join(FILE), Machine::of(gpu));
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => return Ok(Results::new(gpu, machine)),
            Err(fault) => return Err(StudyError::Damaged(format!("{}: {fault}", path.display()))),
        };
        let damaged = |what: String| {
            StudyError::Damaged(format!(
                "{}: {what}. It is left as it is; move it away to begin anew, or name another folder with --out",
                path.display()
            ))
        };
        let found: Results = serde_json::from_slice(&text).map_err(|fault| damaged(fault.to_string()))?;
        if found.format != FORMAT {
            return Err(damaged(format!("it has the format {}, not {FORMAT}", found.format)));
        }
        if found.machine != machine {
            return Err(StudyError::Elsewhere(format!(
                "{} has results of {}, and this is {}; name another folder with --out",
                path.display(),
                found.machine.words(),
                machine.words()
            )));
        }
        Ok(found)
    }

    fn new(gpu: &Gpu, machine: Machine) -> Results {
        Results {
            format: FORMAT,
            machine,
            host: crate::machine(),
            device: about(gpu),
            items: BTreeMap::new(),
            skipped: BTreeMap::new(),
        }
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`StudyError::Record`].
    pub fn write(&self, folder: &Path) -> Result<(), StudyError> {
        std::fs::create_dir_all(folder).map_err(relcp::record::RecordError::io(folder, "create the folder"))?;
        Ok(durable::write_json(&folder.join(FILE), self)?)
    }

    /// What an item found, where it did not fail.
    pub fn finding(&self, name: &str) -> Option<&Finding> {
        self.items.get(name).map(|entry| &entry.finding).filter(|finding| !matches!(finding, Finding::Failed { .. }))
    }
}

/// What is known of a device: it was opened, so the self-test has passed.
fn about(gpu: &Gpu) -> BTreeMap<String, String> {
    let mib = |bytes: u64| format!("{} MiB", bytes >> 20);
    let yes = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let warnings = gpu.warnings();
    let tested = if warnings.is_empty() { "passed".to_owned() } else { format!("passed; {}", warnings.join("; ")) };
    let facts = [
        ("software", yes(gpu.is_software())),
        ("64-bit floats", yes(gpu.has_f64())),
        ("timestamps", yes(gpu.has_timestamps())),
        ("largest buffer", mib(gpu.most_elements(1))),
        ("bound at once", mib(gpu.bank_bytes())),
        ("self-test", tested),
    ];
    facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
