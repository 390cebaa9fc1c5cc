//! What a run writes while it goes on and at its end: rows, states, checkpoints, LCPs, the picture, the summary.

use super::{Measures, Run, RunError, RunStatus, Summary, way, write_scene};
use crate::record::lives::Lives;
use crate::record::{LcpHeader, RecordError, durable, encode, encode_with_forces, write_lcp, write_state};
use crate::render::{Backdrop, View, picture};
use crate::step::{Fault, StepReport, max_overlap_but};
use std::time::{Duration, Instant};

/// The size of a run's final picture in pixels: a run of seconds should not wait for it.
const PICTURE_SIDES: [u32; 2] = [1280, 720];

impl Run {
    /// Without `removal` the file begins with the first body that a change takes out.
    fn record_lives(&mut self) -> Result<(), RecordError> {
        let ended = self.simulation.ended();
        if self.lives.is_none() && !ended.is_empty() {
            let groups = self.simulation.scene().group_names();
            self.lives = Some(Lives::create(&self.folder.lineage(), groups)?);
        }
        self.lives.as_mut().map_or(Ok(()), |lives| lives.push(ended))
    }

    pub(super) fn record(&mut self, report: &StepReport, wall: Duration) -> Result<(), RunError> {
        let begun = Instant::now();
        tell(report, self.simulation.scene().contact.overlap_tolerance, wall);
        self.latest = Some((*report, wall));
        self.follow_changes();
        self.record_lives()?;
        // The schedule does not know the end in advance.
        let done = self.simulation.done();
        if done || self.schedule.row_due(report.step) {
            self.steps.push(report, wall.as_secs_f64())?;
            if let Some(measures) = &mut self.measures {
                measures.push(&self.simulation)??;
            }
        }
        if done || self.schedule.state_due(report.step) {
            self.record_state()?;
            self.steps.flush()?;
            self.measures.as_mut().map_or(Ok(()), Measures::flush)?;
            self.lives.as_mut().map_or(Ok(()), Lives::flush)?;
        }
        self.count_output(begun);
        if self.last_checkpoint.elapsed() >= self.checkpoint_every {
            self.checkpoint()?;
        }
        Ok(())
    }

    /// Records from now on as the scene with its changes so far.
    fn follow_changes(&mut self) {
        let made = self.simulation.changes_made();
        if made != self.changes_followed {
            self.changes_followed = made;
            self.schedule = self.schedule.changed(self.simulation.scene());
            self.measures.as_mut().into_iter().for_each(|measures| measures.follow(self.simulation.scene()));
        }
    }

    /// Saves the LCPs that the scene's `solver.dump` selects.
    pub(super) fn save_lcps(&mut self) -> Result<(), RunError> {
        let begun = Instant::now();
        let kept = self.simulation.take_lcps();
        if kept.is_empty() {
            return Ok(());
        }
        let folder = self.folder.lcps();
        std::fs::create_dir_all(&folder).map_err(RecordError::io(&folder, "create the folder"))?;
        for kept in kept {
            let header = LcpHeader::new(&self.simulation, &kept);
            write_lcp(&self.folder.lcp(kept.step, kept.recursion), &kept.lcp, &header)?;
        }
        self.count_output(begun);
        Ok(())
    }

    pub(super) fn record_state(&mut self) -> Result<(), RunError> {
        let state = self.simulation.state()?;
        self.totals.farthest_way = self.totals.farthest_way.max(way::farthest(self.simulation.scene(), &state.bodies));
        let path = self.folder.state(state.step);
        log::info!("state of step {} into {}", state.step, path.display());
        let (hash, time) = (&self.scene_hash, self.simulation.time());
        let bytes = match self.simulation.scene().output.forces {
            true => encode_with_forces(state, hash, time),
            false => encode(state, hash, time, None),
        };
        let bytes = bytes.map_err(RecordError::state(&path))?;
        Ok(durable::place(&path, &bytes)?)
    }

    /// Writes the checkpoint, and keeps the one before it. The rows and states up to it are synced first.
    pub fn checkpoint(&mut self) -> Result<(), RunError> {
        let begun = Instant::now();
        self.steps.sync()?;
        self.measures.as_mut().map_or(Ok(()), Measures::sync)?;
        self.lives.as_mut().map_or(Ok(()), Lives::sync)?;
        durable::sync_folder(&self.folder.states())?;
        let path = self.folder.checkpoint();
        log::info!("checkpoint into {}", path.display());
        if path.exists() {
            durable::rename(&path, &self.folder.previous_checkpoint())?;
        }
        write_state(&path, self.simulation.state()?, &self.scene_hash, self.simulation.time(), Some(&self.totals))?;
        self.last_checkpoint = Instant::now();
        self.count_output(begun);
        Ok(())
    }

    fn count_output(&mut self, begun: Instant) {
        let spent = begun.elapsed().as_secs_f64();
        self.totals.wall.output += spent;
        self.totals.wall.total += spent;
    }

    pub(super) fn close(&mut self, status: RunStatus, stopped: Option<&Fault>) -> Result<Summary, RunError> {
        self.checkpoint()?;
        let begun = Instant::now();
        let scene = self.simulation.scene();
        let overlap = max_overlap_but(&scene.fixed(), &self.simulation.state()?.bodies, &self.simulation.walls());
        if self.simulation.done() || stopped.is_some() {
            write_scene(&self.folder.last(), &self.simulation.final_scene()?)?;
        }
        // Before the picture, whose memory must not count as the simulation's.
        let mut summary = Summary::new(&self.simulation, &self.totals, &self.scene_hash, (status, stopped), overlap)?;
        self.draw()?;
        self.count_output(begun);
        summary.wall_seconds = self.totals.wall;
        durable::write_json(&self.folder.summary(), &summary)?;
        Ok(summary)
    }

    fn draw(&self) -> Result<(), RunError> {
        if !self.simulation.scene().output.picture {
            return Ok(());
        }
        let [width, height] = PICTURE_SIDES;
        let view = View { width, height, planar: self.simulation.scene().planar, ..View::default() };
        let path = self.folder.picture();
        let mut bytes = Vec::new();
        let state = self.simulation.state()?;
        let bodies = state.bodies.wrapped();
        let mut image = picture(&bodies, &view);
        let backdrop = Backdrop::of(self.simulation.scene());
        let backdrop = backdrop.of_state(self.simulation.time(), &bodies.walls, &state.fields);
        backdrop.behind(&mut image, &view, &bodies);
        image.encode(&mut bytes).map_err(RecordError::io(&path, "pack it"))?;
        Ok(durable::write(&path, &bytes)?)
    }
}

/// Logs a step.
fn tell(report: &StepReport, tolerance: f64, wall: Duration) {
    let StepReport { step, bodies, constraints, recursions, products, residual, max_overlap, .. } = report;
    log::debug!(
        "step {step}: {bodies} bodies, {constraints} constraints, {recursions} recursions, {products} products, residual {residual:.2e}, \
        overlap {max_overlap:.2e}, {:.3} s",
        wall.as_secs_f64()
    );
    if report.failed_attempts > 0 {
        let StepReport { failed_attempts, pieces, waiting, by_cpu, .. } = report;
        log::info!(
            "step {step}: {failed_attempts} attempts failed; taken in {pieces} pieces, {waiting} cells waiting, by the CPU: {by_cpu}"
        );
    }
    if report.unconverged > 0 {
        log::warn!("step {step}: a solve ended as {:?} with a residual of {residual:.2e}", report.status);
    }
    if *max_overlap > tolerance {
        log::warn!("step {step}: overlap {max_overlap:.3e} of {tolerance:.1e} allowed, {:?}", report.worst_pair);
    }
}
