//! Pictures as arrays, pages as objects of notebooks, and their arguments.

use super::compute::warn;
use crate::render::{Background, Frames, Image, Quantity, Side, View};
use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

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
