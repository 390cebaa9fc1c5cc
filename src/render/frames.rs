//! The pictures of a run, one per recorded state, with one camera and one colour scale for all. In periodic space each
//! body is drawn once, with its centre in the cell about the origin.
//!
//! All states are scanned before anything is written: for their extent, the values of the colour quantity, and missing
//! data. Then the pictures are drawn, several in parallel. Pictures are written atomically, and their bytes do not
//! depend on threads.

use super::backdrop::Backdrop;
use super::painter::Painter;
use super::quantity::Quantity;
use super::scale::Scale;
use super::{Background, Rays, RenderError, Side, View};
use crate::figure::Format;
use crate::measure::{Frame, scene_behind};
use crate::record::{RecordError, States, Watch, durable};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the pictures, in the folder of a rendering.
pub(super) const FOLDER: &str = "frames";
/// The file of a picture, in the folder of a rendering.
pub(super) fn picture_file(number: usize, format: Format) -> PathBuf {
    Path::new(FOLDER).join(format!("{number:06}.{}", format.extension()))
}

/// The description of a rendering. It is written, marked incomplete, before the first picture.
const DOCUMENT: &str = "frames.json";
/// The default movie.
pub const MOVIE: &str = "movie.mp4";
/// A time this far outside the interval still counts as inside, relative to the larger of both: the rounding of a
/// product.
const ROUNDING: f64 = 1e-9;

/// The states that set the camera and the colour scale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// All pictures together: the camera is fixed, and a colour has one meaning.
    #[default]
    Run,
    /// Each picture by itself.
    Each,
}

/// Which pictures are made, and their appearance.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// The colour quantity.
    pub colour: Quantity,
    /// The ends of the colour scale. Without it: fitted to the values.
    pub range: Option<[f64; 2]>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The camera position. Without it: above a planar run, otherwise oblique.
    pub side: Option<Side>,
    /// The background.
    pub background: Background,
    /// The format: pixels, or vectors for a planar run seen from the top.
    pub format: Format,
    /// The states that set the camera and the colour scale.
    pub fit: Fit,
    /// Whether pictures have text: time, number of bodies, scale bar, colour scale.
    pub words: bool,
    /// Every Nth state, from the first of the interval on.
    pub every: usize,
    /// The first time.
    pub from: f64,
    /// The last time.
    pub to: f64,
}

impl Default for Frames {
    fn default() -> Self {
        let View { width, height, background, .. } = View::default();
        Frames {
            colour: Quantity::default(),
            range: None,
            size: [width, height],
            side: None,
            background,
            format: Format::Png,
            fit: Fit::default(),
            words: true,
            every: 1,
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
        }
    }
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderedFrame {
    /// Its file, in the folder of the rendering.
    pub file: PathBuf,
    /// Steps taken in its state.
    pub step: u64,
    /// The time of its state.
    pub time: f64,
    /// Bodies of its state.
    pub bodies: usize,
    /// The point at its centre.
    pub centre: [f64; 3],
    /// Pixels to a length of one.
    pub pixels_per_length: f64,
    /// Its colour scale, if it has one.
    pub scale: Option<Scale>,
}

/// The result of a rendering, as in `frames.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rendered {
    /// Whether all pictures are complete.
    pub complete: bool,
    /// The device that cast the rays; null on the CPU.
    pub adapter: Option<String>,
    /// The colour quantity.
    pub colour: Quantity,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The camera position.
    pub side: Side,
    /// The states that set the camera and the colour scale.
    pub fit: Fit,
    /// The pictures, in the order of their states.
    pub frames: Vec<RenderedFrame>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Makes the pictures of `states`, which were [opened](States::open) from `source`, as `folder/frames/000000.png` and
/// so on (`.svg` or `.pdf` for vectors), and `folder/frames.json`. They replace those of an earlier rendering, complete
/// or not.
///
/// ```
/// use relcp::record::States;
/// use relcp::render::{Frames, render};
/// let folder = tempfile::tempdir()?;
/// let states = States::open("three-capsules")?;
/// let frames = Frames { size: [120, 80], ..Frames::default() };
/// let rendered = render("three-capsules", &states, &frames, folder.path(), &mut |_done, _all| true)?;
/// assert!(rendered.complete && folder.path().join("frames/000000.png").is_file());
/// # Ok::<(), relcp::Error>(())
/// ```
///
/// # Errors
/// A [`RenderError`]: states that cannot be read, or do not have the colour quantity.
pub fn render(
    source: impl AsRef<Path>,
    states: &States,
    frames: &Frames,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<Rendered, RenderError> {
    render_on(None, source, states, frames, folder, watch)
}

/// As [`render`], with the rays cast by a device if one is given.
///
/// # Errors
/// As [`render`], and [`RenderError::Device`].
pub fn render_on(
    rays: Option<&Rays>,
    source: impl AsRef<Path>,
    states: &States,
    frames: &Frames,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<Rendered, RenderError> {
    if frames.range.is_some() && frames.colour.ends().is_none() {
        return Err(RenderError::NoScale { colour: frames.colour.name() });
    }
    let source = source.as_ref();
    let run = Frame::of(source, states)?;
    let side = frames.side.unwrap_or(if run.planar { Side::Top } else { Side::Oblique });
    let size = frames.size.map(|side| side.clamp(1, View::LARGEST_SIDE));
    let scene = scene_behind(source)?.map(|(scene, _)| scene);
    let backdrop = scene.map_or_else(Backdrop::default, |scene| Backdrop::of(&scene));
    let painter = Painter { rays, states, frames, run, backdrop, side, size };
    painter.check_format()?;
    let (seen, note) = painter.scan(&mut *watch)?;
    let mut rendered = Rendered {
        complete: false,
        adapter: rays.map(|rays| rays.gpu().name().to_owned()),
        colour: frames.colour,
        size,
        side,
        fit: frames.fit,
        frames: Vec::new(),
        notes: states.notes().iter().cloned().chain(note).collect(),
    };
    clear(folder)?;
    let document = folder.join(DOCUMENT);
    durable::write_json(&document, &rendered)?;
    rendered.frames = painter.draw(&seen, folder, watch)?;
    durable::sync_folder(&folder.join(FOLDER))?;
    rendered.complete = true;
    durable::write_json(&document, &rendered)?;
    Ok(rendered)
}

/// A description of an interval of time.
pub(crate) fn interval(from: f64, to: f64) -> String {
    match (from.is_finite(), to.is_finite()) {
        (true, true) => format!("from time {from} to {to}"),
        (true, false) => format!("at time {from} or later"),
        _ => format!("at time {to} or earlier"),
    }
}

/// Whether a time is in an interval, up to rounding.
pub(crate) fn inside(time: f64, from: f64, to: f64) -> bool {
    let slack = |bound: f64| if bound.is_finite() { ROUNDING * time.abs().max(bound.abs()) } else { 0.0 };
    time >= from - slack(from) && time <= to + slack(to)
}

/// Creates the folder, and removes the pictures of an earlier rendering.
fn clear(folder: &Path) -> Result<(), RenderError> {
    let pictures = folder.join(FOLDER);
    fs::create_dir_all(&pictures).map_err(RecordError::io(&pictures, "create the folder"))?;
    let entries = fs::read_dir(&pictures).map_err(RecordError::io(&pictures, "list it"))?;
    let paths: Vec<PathBuf> = entries
        .map(|entry| Ok(entry.map_err(RecordError::io(&pictures, "list it"))?.path()))
        .collect::<Result<_, RecordError>>()?;
    let mut old: Vec<PathBuf> = paths.into_iter().filter(|path| is_picture(path)).collect();
    let own = folder.join(DOCUMENT).is_file();
    if !old.is_empty() && !own {
        return Err(RenderError::Foreign { path: pictures });
    }
    old.extend(Some(folder.join(MOVIE)).filter(|movie| own && movie.is_file()));
    for path in &old {
        fs::remove_file(path).map_err(RecordError::io(path, "remove it"))?;
    }
    Ok(durable::sweep(&pictures)?)
}

/// Whether it has the name of a picture.
fn is_picture(path: &Path) -> bool {
    let number = path.file_name().and_then(|name| {
        let name = name.to_str()?;
        [Format::Png, Format::Svg, Format::Pdf].iter().find_map(|f| name.strip_suffix(f.extension())?.strip_suffix('.'))
    });
    number.is_some_and(|number| number.len() >= 6 && number.bytes().all(|byte| byte.is_ascii_digit()))
}
