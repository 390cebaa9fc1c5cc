//! Changes of a run while it goes on, by its user. They are part of its scene, so that the run is repeated and resumed
//! to the same bits.

use super::{Measures, Run, RunError, write_scene};
use crate::error::Error;
use crate::record::{Folder, Header, all_differing_keys, scene_hash};
use crate::scene::{KeyChange, Scene};
use serde_json::Value;
use std::collections::BTreeMap;

/// Changes that the last checkpoint of a killed run may lack: each has a checkpoint of its own, and the last readable
/// one may be the one before it.
const MOST_LACKING: usize = 2;

impl Run {
    /// Gives the scene other values of dotted keys from the present state on. The change is appended to the scene's
    /// `changes`, in the folder too, before this returns.
    ///
    /// # Errors
    /// What [`Simulation::add_change`](crate::Simulation::add_change) refuses, which changes nothing. A file that
    /// cannot be written; the run must not go on then.
    pub fn change(&mut self, set: BTreeMap<String, Value>) -> Result<(), Error> {
        self.change_by(KeyChange::new(self.simulation.time(), set))
    }

    /// The same of a change that may also remove and add bodies; its time becomes the present one.
    ///
    /// # Errors
    /// As [`Run::change`], and ids that no body has.
    pub fn change_by(&mut self, change: KeyChange) -> Result<(), Error> {
        self.simulation.add_key_change(change)?;
        self.scene_hash = scene_hash(self.simulation.whole_scene());
        // In this order: a scene whose last change lies at or after the checkpoint is known again.
        self.write_own_scene()?;
        self.checkpoint()?;
        Ok(())
    }

    /// Makes the present state the run's end, in its scene too: a run of the folder's scene then ends with this state,
    /// and [`Run::resume_until`] goes on from it.
    ///
    /// # Errors
    /// A file that cannot be written; a step that fails, since a run that was just resumed may have to take one.
    pub fn end_here(&mut self) -> Result<(), RunError> {
        if self.done() {
            return Ok(());
        }
        let has_row = |run: &Run| run.schedule.row_due(run.simulation.steps());
        let had_row = has_row(self);
        let needs_row = |run: &Run| {
            let mut ended = run.simulation.scene().clone();
            ended.time.end = run.simulation.time();
            run.schedule.changed(&ended).row_due(run.simulation.steps())
        };
        if needs_row(self) && !had_row && self.latest.is_none() {
            // Only its step tells what the last row has to say.
            self.advance()?;
            return self.end_here();
        }
        let add_row = needs_row(self) && !had_row;
        if !self.schedule.state_due(self.simulation.steps()) {
            self.record_state()?;
        }
        if let Some((report, wall)) = self.latest.filter(|_| add_row) {
            self.steps.push(&report, wall.as_secs_f64())?;
            self.measures.as_mut().map_or(Ok(Ok(())), |measures: &mut Measures| measures.push(&self.simulation))??;
        }
        self.simulation.end_here();
        self.schedule = self.schedule.changed(self.simulation.scene());
        self.scene_hash = scene_hash(self.simulation.whole_scene());
        // In this order: a checkpoint at the end of the scene is known again.
        self.checkpoint()?;
        self.write_own_scene()
    }

    fn write_own_scene(&self) -> Result<(), RunError> {
        Ok(write_scene(&self.folder.scene(), &self.simulation.whole_scene().with_defaults())?)
    }
}

/// Whether a checkpoint belongs to a folder's own scene although its hash is another one: the process was killed
/// between the writing of the scene and that of the checkpoint.
pub(super) fn is_of(header: &Header, folder: &Folder, scene: &Scene) -> bool {
    if !all_differing_keys(&folder.scene(), scene).is_empty() {
        return false;
    }
    let has_its_hash = |scene: &Scene| scene_hash(scene) == header.scene;
    let ended = || {
        let mut ended = scene.clone();
        ended.output.every = scene.output_every();
        ended.time.end = header.time;
        ended
    };
    let first = scene.changes.partition_point(|change| change.at < header.time);
    let lacking = |from: usize, to: usize| {
        let mut before = scene.clone();
        before.changes.drain(from..to);
        before
    };
    let mut ranges = (first..scene.changes.len()).flat_map(|from| (1..=MOST_LACKING).map(move |n| (from, from + n)));
    has_its_hash(&ended()) || ranges.any(|(from, to)| to <= scene.changes.len() && has_its_hash(&lacking(from, to)))
}
