//! Pictures as arrays, pages as objects of notebooks, and their arguments.

use super::compute::warn;
use super::error::{recorded, rendered};
use crate::figure::Format;
use crate::record::durable;
use crate::render::{Background, Frames, Image, Quantity, RenderError, Side, View};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// A picture: height, width, and red, green, blue and opacity.
pub(super) type Picture<'py> = Bound<'py, PyArray3<u8>>;

/// The module of the package with the object that notebooks show.
const PAGE: &str = "relcp._page";

const SIDES: [(&str, Side); 4] =
    [("top", Side::Top), ("front", Side::Front), ("right", Side::Right), ("oblique", Side::Oblique)];

const BACKGROUNDS: [(&str, Background); 3] =
    [("white", Background::White), ("dark", Background::Dark), ("transparent", Background::Transparent)];

/// The arguments of `render`.
pub(super) struct Look<'a> {
    pub width: u32,
    pub height: Option<u32>,
    pub view: Option<&'a str>,
    pub colour: &'a str,
    pub range: Option<[f64; 2]>,
    pub background: &'a str,
    pub words: bool,
}

impl Look<'_> {
    /// What they ask for.
    pub fn frames(&self) -> PyResult<Frames> {
        let height = self.height.unwrap_or((self.width.saturating_mul(9) / 16).max(1));
        for (name, side) in [("width", self.width), ("height", height)] {
            if !(1..=View::LARGEST_SIDE).contains(&side) {
                let most = View::LARGEST_SIDE;
                return Err(PyValueError::new_err(format!("{name}: expected 1 to {most} pixels, found {side}")));
            }
        }
        if let Some([low, high]) = self.range
            && !(low < high && low.is_finite() && high.is_finite())
        {
            return Err(PyValueError::new_err(format!(
                "range: expected two numbers, the lower first, found {low}, {high}"
            )));
        }
        Ok(Frames {
            colour: quantity(self.colour)?,
            range: self.range,
            size: [self.width, height],
            side: self.view.map(|view| one_of("view", view, &SIDES)).transpose()?,
            background: one_of("background", self.background, &BACKGROUNDS)?,
            words: self.words,
            ..Frames::default()
        })
    }
}

/// What a name stands for.
pub(super) fn one_of<T: Copy>(argument: &str, name: &str, all: &[(&str, T)]) -> PyResult<T> {
    all.iter().find(|(own, _)| *own == name).map(|(_, one)| *one).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|(own, _)| *own).collect();
        PyValueError::new_err(format!("{argument}: expected one of {}, found {name:?}", names.join(", ")))
    })
}

/// The quantity of a name.
pub(super) fn quantity(name: &str) -> PyResult<Quantity> {
    one_of("colour", name, &Quantity::ALL.map(|quantity| (quantity.name(), quantity)))
}

/// What the arguments ask for, in the format that the name of a file ends in.
pub(super) fn in_file(look: &Look<'_>, path: &Path) -> PyResult<Frames> {
    let formats = [("png", Format::Png), ("svg", Format::Svg), ("pdf", Format::Pdf)];
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_lowercase();
    let format = formats.iter().find(|(own, _)| *own == ending).map(|(_, format)| *format);
    let format = format.ok_or_else(|| PyValueError::new_err("path: a picture's name ends in .png, .svg or .pdf"))?;
    Ok(Frames { format, ..look.frames()? })
}

/// Writes a picture, whole or not at all; returns its path.
pub(super) fn placed(py: Python<'_>, path: PathBuf, bytes: Result<Vec<u8>, RenderError>) -> PyResult<PathBuf> {
    durable::place(&path, &bytes.map_err(|no| rendered(py, no))?).map_err(|no| recorded(&no))?;
    Ok(path)
}

/// A picture as an array.
pub(super) fn array(py: Python<'_>, image: Image) -> PyResult<Picture<'_>> {
    let shape = [image.height() as usize, image.width() as usize, 4];
    let opaque = vec![u8::MAX; shape[0] * shape[1]];
    let alpha = image.alpha().unwrap_or(&opaque);
    let pixels = image.pixels().as_chunks::<3>().0.iter().zip(alpha);
    let bytes: Vec<u8> = pixels.flat_map(|([red, green, blue], alpha)| [*red, *green, *blue, *alpha]).collect();
    bytes.into_pyarray(py).reshape(shape)
}

/// A page as an object that notebooks show, with warnings of what its user should know.
pub(super) fn page<'py>(
    py: Python<'py>,
    page: Vec<u8>,
    notes: &[String],
    width: Option<Bound<'py, PyAny>>,
    height: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    notes.iter().try_for_each(|note| warn(py, note))?;
    let page = String::from_utf8_lossy(&page);
    py.import(PAGE)?.getattr("Page")?.call1((page, width, height))
}
