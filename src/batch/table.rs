//! The table of a batch: one row per member, from the folders.

use super::error::BatchError;
use super::member_state::{Folders, MemberState, Outcome};
use super::ordered::Ordered;
use super::plan::{Member, Plan};
use crate::digits::few;
use crate::record::{RecordError, durable};
use crate::run::RunStatus;
use crate::scene::StopReason;
use serde::{Serialize, Serializer};
use serde_json::Value;
use std::fmt;
use std::path::{Path, PathBuf};

/// The columns of `batch.csv` after the index and the varied keys.
const COLUMNS: [&str; 14] = [
    "status",
    "stopped_by",
    "steps",
    "bodies",
    "max_overlap",
    "recursions_mean",
    "products",
    "wall_seconds",
    "state_hash",
    "backend",
    "precision",
    "folder",
    "message",
    "reason",
];
/// The longest value in the printed table, in characters.
const WIDEST: usize = 32;

/// The status of a member in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RowStatus {
    /// It reached its end, and every step met its tolerances.
    Done,
    /// It reached its end; some step did not meet its tolerances.
    OutOfTolerance,
    /// It was stopped before its end, and continues when the batch runs again.
    Interrupted,
    /// A step could not meet its tolerances.
    Stopped,
    /// A step could not be taken, by an earlier version.
    Fault,
    /// It is running, or was killed; it continues when the batch runs again.
    Unfinished,
    /// It did not run yet.
    Missing,
    /// Its folder belongs to a different scene, or contains other files.
    Refused,
    /// It could not run; the message gives the reason.
    Failed,
}

impl RowStatus {
    fn name(self) -> &'static str {
        match self {
            RowStatus::Done => "done",
            RowStatus::OutOfTolerance => "out_of_tolerance",
            RowStatus::Interrupted => "interrupted",
            RowStatus::Stopped => "stopped",
            RowStatus::Fault => "fault",
            RowStatus::Unfinished => "unfinished",
            RowStatus::Missing => "missing",
            RowStatus::Refused => "refused",
            RowStatus::Failed => "failed",
        }
    }

    /// Whether the run reached its end.
    pub fn finished(self) -> bool {
        matches!(self, RowStatus::Done | RowStatus::OutOfTolerance)
    }
}

impl From<RunStatus> for RowStatus {
    fn from(status: RunStatus) -> Self {
        match status {
            RunStatus::Done => RowStatus::Done,
            RunStatus::OutOfTolerance => RowStatus::OutOfTolerance,
            RunStatus::Interrupted => RowStatus::Interrupted,
            RunStatus::Stopped => RowStatus::Stopped,
            RunStatus::Fault => RowStatus::Fault,
        }
    }
}

/// A member and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The member.
    pub member: Member,
    /// Its folder.
    pub folder: PathBuf,
    /// Its status.
    pub status: RowStatus,
    /// The content of its summary, if it has one.
    pub outcome: Option<Outcome>,
    /// Why it is refused or failed.
    pub message: Option<String>,
}

/// The rows of all members.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// The sweep's name.
    pub name: String,
    /// The varied keys.
    pub columns: Vec<String>,
    /// The rows, in the members' order; `members` in `batch.json`.
    #[serde(rename = "members")]
    pub rows: Vec<Row>,
}

impl Table {
    /// The table of these members of a plan, whose folders are under `out`.
    ///
    /// # Errors
    /// [`BatchError::Record`] if a file cannot be read. A refused folder is a row.
    pub fn of(plan: &Plan, out: &Path, members: &[Member]) -> Result<Self, BatchError> {
        let folders = Folders::read(out)?;
        let rows = members.iter().map(|member| Row::of(plan, &folders, out, member)).collect::<Result<_, _>>()?;
        Ok(Table { name: plan.sweep().name.clone(), columns: plan.columns().to_vec(), rows })
    }

    /// Records that a member could not run.
    pub fn failed(&mut self, index: usize, message: String) {
        for row in self.rows.iter_mut().filter(|row| row.member.index == index) {
            if !matches!(row.status, RowStatus::Fault | RowStatus::Stopped) {
                row.status = RowStatus::Failed;
            }
            row.message = Some(message.clone());
        }
    }

    /// Writes `batch.csv` and `batch.json` into the folder `out`.
    ///
    /// # Errors
    /// [`BatchError::Record`].
    pub fn write(&self, out: &Path) -> Result<(), BatchError> {
        let path = out.join("batch.csv");
        durable::write(&path, &self.to_csv().map_err(RecordError::io(&path, "write it"))?)?;
        Ok(durable::write_json(&out.join("batch.json"), self)?)
    }

    /// The content of `batch.csv`. Strings are written as they are, other values as JSON. A varied key with the name of
    /// another column becomes `set.KEY`.
    ///
    /// # Errors
    /// The error of the writer.
    pub fn to_csv(&self) -> std::io::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let taken = |key: &str| key == "index" || COLUMNS.contains(&key);
        let varied = self.columns.iter().map(|key| if taken(key) { format!("set.{key}") } else { key.clone() });
        let headings = std::iter::once("index".to_owned()).chain(varied);
        writer.write_record(headings.chain(COLUMNS.map(str::to_owned)))?;
        for row in &self.rows {
            let values = row.member.values.0.iter().map(|(_, value)| plain(value));
            writer.write_record(std::iter::once(row.member.index.to_string()).chain(values).chain(row.cells()))?;
        }
        writer.into_inner().map_err(|e| e.into_error())
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

impl Row {
    fn of(plan: &Plan, folders: &Folders, out: &Path, member: &Member) -> Result<Self, RecordError> {
        let mut row = Row {
            member: member.clone(),
            folder: out.join(member.name()),
            status: RowStatus::Missing,
            outcome: None,
            message: None,
        };
        match folders.of(plan, member) {
            Ok((folder, state)) => {
                row.folder = folder;
                match state {
                    MemberState::Missing => {}
                    MemberState::Unstarted | MemberState::Unfinished => row.status = RowStatus::Unfinished,
                    MemberState::Summed(outcome) => {
                        row.status = outcome.status.into();
                        row.message.clone_from(&outcome.message);
                        row.outcome = Some(*outcome);
                    }
                }
            }
            Err(refusal @ (RecordError::OtherScene { .. } | RecordError::NotEmpty { .. })) => {
                row.status = RowStatus::Refused;
                row.message = Some(refusal.to_string());
            }
            Err(fault) => return Err(fault),
        }
        Ok(row)
    }

    fn folder_name(&self) -> String {
        self.folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Its cells of [`COLUMNS`], empty if there is no value.
    fn cells(&self) -> [String; COLUMNS.len()] {
        let of = |cell: fn(&Outcome) -> String| self.outcome.as_ref().map(cell).unwrap_or_default();
        [
            self.status.name().to_owned(),
            of(|o| o.stopped_by.map_or("", StopReason::name).to_owned()),
            of(|o| o.steps.to_string()),
            of(|o| o.bodies.to_string()),
            of(|o| o.max_overlap.map_or("inf".into(), |overlap| format!("{overlap:e}"))),
            of(|o| o.recursions.mean.to_string()),
            of(|o| o.solver.products.to_string()),
            of(|o| o.wall_seconds.total.to_string()),
            of(|o| o.state_hash.clone()),
            of(|o| o.backend.clone()),
            of(|o| o.precision.clone()),
            self.folder_name(),
            self.message.clone().unwrap_or_default(),
            of(|o| o.reason.clone().unwrap_or_default()),
        ]
    }

    /// Its cells in the printed table, after the index and the varied values.
    fn words(&self) -> [String; WORDS.len()] {
        let of = |cell: fn(&Outcome) -> String| self.outcome.as_ref().map(cell).unwrap_or_default();
        [
            match self.outcome.as_ref().and_then(|o| o.reason.as_deref()) {
                Some(reason) => format!("{}: {}", self.status.name(), reason).replace('_', " "),
                None => self.status.name().replace('_', " "),
            },
            of(|o| o.steps.to_string()),
            of(|o| o.bodies.to_string()),
            of(|o| o.max_overlap.map_or("inf".into(), few)),
            of(|o| format!("{:.2}", o.recursions.mean)),
            of(|o| o.solver.products.to_string()),
            of(|o| format!("{:.2}", o.wall_seconds.total)),
            of(|o| o.state_hash.clone()),
            self.folder_name(),
        ]
    }
}

const WORDS: [&str; 9] =
    ["status", "steps", "bodies", "max overlap", "recursions", "products", "wall s", "state", "folder"];

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let short = |text: String| match text.char_indices().nth(WIDEST) {
            Some((end, _)) => format!("{}...", &text[..end]),
            None => text,
        };
        let headings = std::iter::once("member").chain(self.columns.iter().map(String::as_str)).chain(WORDS);
        let mut lines = vec![headings.map(str::to_owned).collect::<Vec<_>>()];
        for row in &self.rows {
            let values = row.member.values.0.iter().map(|(_, value)| short(plain(value)));
            lines.push(std::iter::once(row.member.index.to_string()).chain(values).chain(row.words()).collect());
        }
        let columns = lines[0].len();
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        for line in lines {
            let cells: Vec<String> = line.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}")).collect();
            writeln!(f, "{}", cells.join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// A row of `batch.json`; null if there is no value, or if an overlap was not finite.
#[derive(Serialize)]
struct Entry<'a> {
    index: usize,
    folder: String,
    set: &'a Ordered<Value>,
    values: &'a Ordered<Value>,
    scene_hash: &'a str,
    status: RowStatus,
    stopped_by: Option<StopReason>,
    steps: Option<u64>,
    bodies: Option<u64>,
    max_overlap: Option<f64>,
    recursions_mean: Option<f64>,
    products: Option<u64>,
    wall_seconds: Option<f64>,
    state_hash: Option<&'a str>,
    backend: Option<&'a str>,
    precision: Option<&'a str>,
    version: Option<&'a str>,
    message: Option<&'a str>,
    reason: Option<&'a str>,
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (member, outcome) = (&self.member, self.outcome.as_ref());
        let entry = Entry {
            index: member.index,
            folder: self.folder_name(),
            set: &member.set,
            values: &member.values,
            scene_hash: &member.scene_hash,
            status: self.status,
            stopped_by: outcome.and_then(|o| o.stopped_by),
            steps: outcome.map(|o| o.steps),
            bodies: outcome.map(|o| o.bodies),
            max_overlap: outcome.and_then(|o| o.max_overlap),
            recursions_mean: outcome.map(|o| o.recursions.mean),
            products: outcome.map(|o| o.solver.products),
            wall_seconds: outcome.map(|o| o.wall_seconds.total),
            state_hash: outcome.map(|o| o.state_hash.as_str()),
            backend: outcome.map(|o| o.backend.as_str()),
            precision: outcome.map(|o| o.precision.as_str()),
            version: outcome.map(|o| o.version.as_str()),
            message: self.message.as_deref(),
            reason: outcome.and_then(|o| o.reason.as_deref()),
        };
        entry.serialize(serializer)
    }
}
