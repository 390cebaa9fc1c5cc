//! The measures of all states of a run.

use super::{Cell, Column, Found, Frame, LeftOut, Measure, MeasureError, Settings, Tracks, View};
use crate::bodies::Bodies;
use crate::record::{States, Watch};
use std::path::Path;

/// The largest deviation of the squared norm of an orientation from 1; the error of rotated axes is then at most this.
/// States of a run in f32 are within 1e-15 (500 steps of two ellipsoids), so this concerns states made by other
/// programs.
const UNIT_TOLERANCE: f64 = 1e-4;

/// The measures of several states.
pub struct Measured {
    /// The data that all states share.
    pub frame: Frame,
    /// What the user chose.
    pub settings: Settings,
    /// The measures.
    pub measures: Vec<&'static dyn Measure>,
    /// Steps taken, by state.
    pub steps: Vec<u64>,
    /// The times, by state.
    pub times: Vec<f64>,
    /// Numbers of bodies, by state.
    pub bodies: Vec<usize>,
    /// The results, by measure and state.
    pub found: Vec<Vec<Result<Found, LeftOut>>>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Measures all of `states`, which were [opened](States::open) from `source`.
///
/// # Errors
/// States that cannot be read or hold numbers that are not finite; [`MeasureError::Stopped`] if `watch` returns false.
pub fn measure(
    source: impl AsRef<Path>,
    states: &States,
    measures: &[&'static dyn Measure],
    settings: &Settings,
    watch: Watch<'_>,
) -> Result<Measured, MeasureError> {
    let frame = Frame::of(source, states)?;
    measure_in(frame, states, 0, measures, settings, watch)
}

/// As [`measure()`], of the last state only.
///
/// # Errors
/// As [`measure()`].
pub fn measure_last(
    source: impl AsRef<Path>,
    states: &States,
    measures: &[&'static dyn Measure],
    settings: &Settings,
    watch: Watch<'_>,
) -> Result<Measured, MeasureError> {
    let frame = Frame::of(source, states)?;
    measure_in(frame, states, states.len().saturating_sub(1), measures, settings, watch)
}

/// As [`measure()`], with a given frame, from state `first` on.
pub(super) fn measure_in(
    frame: Frame,
    states: &States,
    first: usize,
    measures: &[&'static dyn Measure],
    settings: &Settings,
    watch: Watch<'_>,
) -> Result<Measured, MeasureError> {
    let all = states.len() - first.min(states.len());
    let mut measured = Measured {
        frame,
        settings: settings.clone(),
        measures: measures.to_vec(),
        steps: Vec::new(),
        times: Vec::new(),
        bodies: Vec::new(),
        found: vec![Vec::new(); measures.len()],
        notes: states.notes().to_vec(),
    };
    let follows = measures.iter().any(|measure| measure.follows());
    let mut tracks = Tracks::new(all, settings.seed);
    for done in 0..all {
        if !watch(done, all) {
            return Err(MeasureError::Stopped { done, all });
        }
        let state = states.read(first + done)?;
        check(&state.bodies, &|| states.origin(first + done))?;
        let view = View::new(&state, &measured.frame, settings);
        for (found, measure) in measured.found.iter_mut().zip(measures) {
            found.push(measure.of(&view));
        }
        if follows {
            tracks.push(&state.bodies, &measured.frame.fixed);
        }
        measured.steps.push(state.step);
        measured.times.push(state.time);
        measured.bodies.push(state.bodies.len());
    }
    watch(all, all);
    for (found, measure) in measured.found.iter_mut().zip(measures) {
        measure.over_time(&measured.times, found);
        measure.along(&measured.times, &tracks, found);
    }
    measured.tell();
    Ok(measured)
}

fn check(bodies: &Bodies, origin: &dyn Fn() -> String) -> Result<(), MeasureError> {
    let fault = |body: usize, what: String| Err(MeasureError::Unfit { origin: origin(), body, what });
    for i in 0..bodies.len() {
        if !bodies.position[i].is_finite() {
            return fault(i, "position is not finite".into());
        }
        let off = (bodies.orientation[i].length_squared() - 1.0).abs();
        if off.is_nan() || off >= UNIT_TOLERANCE {
            return fault(i, "orientation is not a unit quaternion".into());
        }
        if let Err(wrong) = bodies.shape[i].validate() {
            return fault(i, format!("shape cannot be: {wrong}"));
        }
    }
    Ok(())
}

impl Measured {
    /// The number of measured states.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether there was no state.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The columns of all measures, in order.
    pub fn columns(&self) -> impl Iterator<Item = &'static Column> {
        self.measures.iter().flat_map(|measure| measure.columns())
    }

    /// The values of state `state`, in the order of the columns.
    pub fn values(&self, state: usize) -> impl Iterator<Item = Cell> {
        self.measures.iter().zip(&self.found).flat_map(move |(measure, found)| {
            let values = found[state].as_ref().ok().map(|found| found.values.as_slice());
            (0..measure.columns().len())
                .map(move |column| values.and_then(|values| values.get(column).copied().flatten()))
        })
    }

    /// The value of state `state` in a column; none if it is not defined.
    pub fn value(&self, state: usize, column: &str) -> Cell {
        self.columns().zip(self.values(state)).find(|(of, _)| of.name == column)?.1
    }

    /// Why a measure, or a part of it, is missing for a state.
    pub fn remark(&self, measure: usize, state: usize) -> Option<&str> {
        match &self.found[measure][state] {
            Ok(found) => found.remark.as_deref(),
            Err(LeftOut(reason)) => Some(reason),
        }
    }

    /// Notes on missing measures: each reason once, with the number of states.
    fn tell(&mut self) {
        let mut notes: Vec<(String, usize)> = Vec::new();
        for (at, measure) in self.measures.iter().enumerate() {
            for remark in (0..self.len()).filter_map(|state| self.remark(at, state)) {
                let note = format!("{}: {remark}", measure.name());
                match notes.iter_mut().find(|(known, _)| *known == note) {
                    Some((_, times)) => *times += 1,
                    None => notes.push((note, 1)),
                }
            }
        }
        let all = self.len();
        self.notes.extend(notes.into_iter().map(|(note, times)| match times {
            _ if times == all => note,
            _ => format!("{note} ({times} of {all} states)"),
        }));
    }
}
