//! The changes of rows: first rows of near pairs, and those at trials.

use super::Device;
use super::row_inputs::RowInputs;
use super::row_set::RowSet;
use super::start::Stages;
use crate::gpu::{GpuError, Recorder};

impl Device {
    /// The rows and their inputs: at the trial, or in the state where first rows are made.
    pub(super) fn row_inputs(&mut self, at_trial: bool) -> (&mut RowSet, RowInputs<'_>) {
        let Device { gpu, setup, states, start, motions, first, narrow, rows, .. } = self;
        let stages = Stages { gpu, setup, states, start };
        (rows, RowInputs::of(stages, first, &narrow.candidates.lists, motions, at_trial))
    }

    /// Changes the rows.
    pub(super) fn change_rows(
        &mut self,
        at_trial: bool,
        change: impl FnOnce(&mut RowSet, &mut Recorder<'_>, RowInputs<'_>) -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("narrow phase");
        let (rows, made) = self.row_inputs(at_trial);
        change(rows, &mut record, made)?;
        record.submit()
    }
}
