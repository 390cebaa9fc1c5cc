//! `measures.csv`: the measures of the scene's `output.measures`, one row for each recorded step.

use crate::measure::{self, Frame, Measure, Settings, View};
use crate::record::rows::Rows;
use crate::record::{RecordError, Snapshot};
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::step::Fault;
use std::path::Path;

/// The columns before those of the measures.
const OWN: [&str; 3] = ["step", "time", "bodies"];

/// The file, open for writing.
pub(super) struct Measures {
    rows: Rows,
    measures: Vec<&'static dyn Measure>,
    frame: Frame,
    settings: Settings,
}

impl Measures {
    /// Starts the file if the scene has measures.
    pub(super) fn create(path: &Path, scene: &Scene) -> Result<Option<Self>, RecordError> {
        Self::of(scene, |columns| Rows::create(path, columns))
    }

    /// Reopens the file as it was after step `last`: see [`Rows::reopen`].
    pub(super) fn reopen(path: &Path, scene: &Scene, last: Option<u64>) -> Result<Option<Self>, RecordError> {
        Self::of(scene, |columns| Rows::reopen(path, columns, last))
    }

    fn of(scene: &Scene, open: impl Fn(&[&str]) -> Result<Rows, RecordError>) -> Result<Option<Self>, RecordError> {
        // A validated scene names only existing measures; an empty list would mean all of them.
        let names = &scene.output.measures;
        let Some(measures) = measure::select(names).ok().filter(|_| !names.is_empty()) else { return Ok(None) };
        let columns: Vec<&str> =
            OWN.into_iter().chain(measures.iter().flat_map(|m| m.columns()).map(|column| column.name)).collect();
        let frame = Frame::of_scene(scene, scene.name.clone());
        Ok(Some(Measures { rows: open(&columns)?, measures, frame, settings: Settings::default() }))
    }

    /// Measures from now on in a changed scene.
    pub(super) fn follow(&mut self, scene: &Scene) {
        self.frame = Frame::of_scene(scene, scene.name.clone());
    }

    /// Measures the present state and adds its row.
    pub(super) fn push(&mut self, simulation: &Simulation) -> Result<Result<(), RecordError>, Fault> {
        let state = simulation.state()?;
        let (step, time) = (state.step, simulation.time());
        let snapshot = Snapshot {
            step,
            time,
            bodies: state.bodies.clone(),
            warm: Some(state.warm.clone()),
            removed: state.removed.clone(),
            fields: state.fields.clone(),
        };
        let view = View::new(&snapshot, &self.frame, &self.settings);
        let of = |measure: &&'static dyn Measure| {
            let mut values = measure.of(&view).map(|found| found.values).unwrap_or_default();
            values.resize(measure.columns().len(), None);
            values.into_iter().map(measure::field)
        };
        let values: Vec<String> = self.measures.iter().flat_map(of).collect();
        Ok(self.rows.push((step, time, snapshot.bodies.len(), values)))
    }

    /// Flushes the rows to the system.
    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        self.rows.flush()
    }

    /// Syncs the rows to the disk.
    pub(super) fn sync(&mut self) -> Result<(), RecordError> {
        self.rows.sync()
    }
}
