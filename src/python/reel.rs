//! Pictures and movies over the states of a run.

use super::error::rendered;
use super::picture::{self, Look, Picture, one_of, quantity};
use super::work::{quietly, watched};
use crate::record::{RecordError, States};
use crate::render::{self, ENDINGS, Encoder, Fit, Frames, MovieKind, Reel, RenderError, render};
use crate::scene::Scene;
use crate::view::Pages;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::Path;
use std::sync::Arc;

/// The pictures of a run, drawn when they are asked for.
#[pyclass(frozen, name = "Reel", module = "relcp._relcp")]
pub(super) struct PyReel {
    scene: Arc<Scene>,
    states: Arc<States>,
    reel: Reel,
}

impl PyReel {
    /// The pictures of the states of a run of `scene`.
    pub fn of(py: Python<'_>, scene: Arc<Scene>, states: Arc<States>, frames: Frames) -> PyResult<Self> {
        let reel = watched(py, |watch| Reel::of(&scene, &states, &frames, watch))?.map_err(|no| rendered(py, no))?;
        Ok(PyReel { scene, states, reel })
    }
}

#[pymethods]
impl PyReel {
    fn __len__(&self) -> usize {
        self.reel.len()
    }

    fn picture<'py>(&self, py: Python<'py>, nth: usize) -> PyResult<Picture<'py>> {
        if nth >= self.reel.len() {
            return Err(PyIndexError::new_err(format!("picture {nth}; there are {}", self.reel.len())));
        }
        let drawn = quietly(py, || self.reel.picture(&self.scene, &self.states, nth))?;
        picture::array(py, drawn.map_err(|no| rendered(py, no))?)
    }
}

/// The arguments of pictures over a run: how they look, by name, and which states they show.
pub(super) fn frames(look: &Bound<'_, PyDict>, every: usize, start: Option<f64>, end: Option<f64>) -> PyResult<Frames> {
    let Pages { every, from, to, .. } = pages("plain", every, start, end)?;
    let get = |name: &str| look.get_item(name).map(|value| value.filter(|value| !value.is_none()));
    let text = |name: &str, otherwise: &str| match get(name)? {
        Some(value) => value.extract::<String>(),
        None => Ok(otherwise.to_owned()),
    };
    let view = get("view")?.map(|value| value.extract::<String>()).transpose()?;
    let (colour, background) = (text("colour", "orientation")?, text("background", "white")?);
    let look_of = Look {
        width: get("width")?.ok_or_else(|| PyValueError::new_err("width: expected a number of pixels"))?.extract()?,
        height: get("height")?.map(|value| value.extract()).transpose()?,
        view: view.as_deref(),
        colour: &colour,
        range: get("range")?.map(|value| value.extract()).transpose()?,
        background: &background,
        words: get("words")?.map_or(Ok(true), |value| value.extract())?,
    };
    let fit = one_of("fit", &text("fit", "run")?, &[("run", Fit::Run), ("each", Fit::Each)])?;
    Ok(Frames { fit, every, from, to, ..look_of.frames()? })
}

/// Which states a page has, and its colours.
pub(super) fn pages(colour: &str, every: usize, start: Option<f64>, end: Option<f64>) -> PyResult<Pages> {
    if every == 0 {
        return Err(PyValueError::new_err("every: expected at least one state"));
    }
    let (from, to) = (start.unwrap_or(f64::NEG_INFINITY), end.unwrap_or(f64::INFINITY));
    Ok(Pages { colour: Some(quantity(colour)?), every, from, to })
}

/// Makes a movie of the states of the run in a folder.
pub(super) fn movie(
    py: Python<'_>,
    (source, states): (&Path, &States),
    frames: &Frames,
    frames_a_second: u32,
    path: &Path,
) -> PyResult<()> {
    let kind = MovieKind::of(path);
    let kind = kind.ok_or_else(|| PyValueError::new_err(format!("path: a movie's name ends in {ENDINGS}")))?;
    if frames_a_second == 0 {
        return Err(PyValueError::new_err("frames_a_second: expected at least one"));
    }
    let encoder = Encoder::find();
    if encoder.is_none() && kind != MovieKind::Animation {
        return Err(rendered(py, RenderError::NoEncoder));
    }
    let made = watched(py, |watch| {
        let place = tempfile::tempdir().map_err(RecordError::io(&std::env::temp_dir(), "create a folder in it"))?;
        render(source, states, frames, place.path(), watch)?;
        render::movie(encoder.as_ref(), place.path(), frames_a_second, path)
    })?;
    made.map_err(|no: RenderError| rendered(py, no))
}
