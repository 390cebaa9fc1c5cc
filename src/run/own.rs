//! A user's own forces and rules in a run. They act on it and are not in its folder.

use super::Run;
use crate::dynamics::ForceField;
use crate::record::RecordError;
use crate::simulation::Rules;

impl Run {
    /// Adds an external force to those of the scene. It is not in the folder: a resumed run needs the same forces
    /// again, and has a [note](Run::notes) until it gets some.
    pub fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.has_own("forces");
        self.simulation.add_force(force);
    }

    /// Has cells grow and divide by these rules. As for forces, a resumed run needs the same ones again.
    pub fn set_rules(&mut self, rules: Box<dyn Rules>) {
        self.has_own("rules");
        self.simulation.set_rules(rules);
    }

    /// Remembers what of a user's own acts on the run.
    fn has_own(&mut self, what: &str) {
        self.notes.retain(|note| *note != without(what));
        if !self.totals.own.iter().any(|own| own == what) {
            self.totals.own.push(what.into());
        }
    }

    /// Takes a step that failed by its user's own force or rule as not begun, as the user has interrupted it there: the
    /// run is to be resumed.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn interrupted(&mut self) -> Result<(), RecordError> {
        let last = self.folder.last();
        match self.stopped.take() {
            Some(_) if last.exists() => std::fs::remove_file(&last).map_err(RecordError::io(&last, "remove it")),
            _ => Ok(()),
        }
    }
}

/// The note of a resumed run that lacks what of a user's own acted on it.
pub(super) fn without(own: &str) -> String {
    format!("{own} of a user's own acted on this run and are not in its folder: without them it goes on in another way")
}
