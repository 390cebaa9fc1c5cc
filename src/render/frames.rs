//! The pictures of a run, one a recorded state, with one camera and one scale of colours for all of them. In periodic
//! space each body is drawn once, with its centre in the cell about the origin.
//!
//! All states are looked at before anything is written: for the space that they take, the values that their colours
//! tell, and what they lack. Then the pictures are drawn, some at a time in parallel. A picture is there whole or not
//! at all, and its bytes do not depend on threads.

use super::backdrop::Backdrop;
use super::camera::{Extent, axes_from};
use super::quantity::Quantity;
use super::scale::{self, Scale};
use super::{
    BLACK, Background, Camera, Image, Rays, RenderError, Side, View, WHITE, caption, inks_on, on_cpu, on_device,
    painted,
};
use crate::measure::{Frame, LeftOut, scene_behind};
use crate::record::{RecordError, Snapshot, States, Watch, durable};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the pictures, in that of a rendering.
const FOLDER: &str = "frames";
/// What a rendering says of itself. It is there, not complete, before the first picture.
const DOCUMENT: &str = "frames.json";
/// The movie, where it has no other place.
pub const MOVIE: &str = "movie.mp4";
/// How far a time may be outside the interval and still count as in it, relative to the larger of both: the rounding of
/// a product.
const ROUNDING: f64 = 1e-9;
/// Memory that the rays of the pictures drawn at a time may take together, in bytes; a picture alone may take more.
const MEMORY: usize = 2 << 30;
/// Memory that a pixel takes while it is drawn, in bytes: four rays of 16 bytes, and its colour.
const MEMORY_A_PIXEL: usize = 67;

/// What camera and scale are fitted to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// All pictures together: bodies move and grow in a still frame, and a colour has one meaning.
    #[default]
    Run,
    /// Each picture by itself.
    Each,
}

/// Which pictures are made, and their looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// What the colours tell.
    pub colour: Quantity,
    /// The ends of the scale of colours, without those that fit the values.
    pub range: Option<[f64; 2]>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where bodies are seen from; without it from the top in a planar run, else obliquely.
    pub side: Option<Side>,
    /// What stands behind the bodies.
    pub background: Background,
    /// What camera and scale are fitted to.
    pub fit: Fit,
    /// Whether there are words: time, number of bodies, bar of length, scale of colours.
    pub words: bool,
    /// Every so many states, from the first of the interval on.
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
            fit: Fit::default(),
            words: true,
            every: 1,
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
        }
    }
}

/// A picture that was made.
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
    /// What stands in its middle.
    pub centre: [f64; 3],
    /// Pixels to a length of one.
    pub pixels_per_length: f64,
    /// Its scale of colours, where they are on one.
    pub scale: Option<Scale>,
}

/// What was made, as `frames.json` has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rendered {
    /// Whether all pictures are there.
    pub complete: bool,
    /// The device that cast the rays; null on the CPU.
    pub adapter: Option<String>,
    /// What the colours tell.
    pub colour: Quantity,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where bodies are seen from.
    pub side: Side,
    /// What camera and scale are fitted to.
    pub fit: Fit,
    /// The pictures, in the order of their states.
    pub frames: Vec<RenderedFrame>,
    /// What its user should know.
    pub notes: Vec<String>,
}

/// A state that was looked at.
struct ScannedState {
    /// Its number among the states.
    index: usize,
    time: f64,
    extent: Extent,
    scale: Option<Scale>,
    /// Whether some body is another one's daughter.
    births: bool,
}

/// Makes the pictures of `states`, which were [opened](States::open) from `source`, as `folder/frames/000000.png` and
/// so on, and `folder/frames.json`. What an earlier rendering left there, whole or not, is replaced.
///
/// ```
/// use relcp::record::States;
/// use relcp::render::{Frames, render};
/// let folder = tempfile::tempdir()?;
/// let states = States::open("three-capsules")?;
/// let frames = Frames { size: [120, 80], ..Frames::default() };
/// let rendered = render("three-capsules", &states, &frames, folder.path(), &mut |_done, _all| true)?;
/// assert!(rendered.complete && folder.path().join("frames/000000.png").is_file());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A [`RenderError`]: states that cannot be read, or do not have what the colours are to tell.
pub fn render(
    source: &str,
    states: &States,
    frames: &Frames,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<Rendered, RenderError> {
    render_on(None, source, states, frames, folder, watch)
}

/// As [`render`], the rays cast by a device where there is one.
///
/// # Errors
/// As [`render`], and [`RenderError::Device`].
pub fn render_on(
    rays: Option<&Rays>,
    source: &str,
    states: &States,
    frames: &Frames,
    folder: &Path,
    watch: Watch<'_>,
) -> Result<Rendered, RenderError> {
    if frames.range.is_some() && frames.colour.ends().is_none() {
        return Err(RenderError::NoScale { colour: frames.colour.name() });
    }
    let run = Frame::of(source, states)?;
    let side = frames.side.unwrap_or(if run.planar { Side::Top } else { Side::Oblique });
    let size = frames.size.map(|side| side.clamp(1, View::LARGEST_SIDE));
    let scene = scene_behind(source)?.map(|(scene, _)| scene);
    let backdrop = scene.map_or_else(Backdrop::default, |scene| Backdrop::of(&scene));
    let painter = Painter { rays, states, frames, run, backdrop, side, size };
    let (seen, note) = painter.look(&mut *watch)?;
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

struct Painter<'a> {
    rays: Option<&'a Rays>,
    states: &'a States,
    frames: &'a Frames,
    run: Frame,
    backdrop: Backdrop,
    side: Side,
    size: [u32; 2],
}

impl Painter<'_> {
    /// Looks at the states that are to be drawn; and says how many have nothing to colour them by.
    fn look(&self, watch: Watch<'_>) -> Result<(Vec<ScannedState>, Option<String>), RenderError> {
        let Frames { from, to, every, .. } = *self.frames;
        let all = from == f64::NEG_INFINITY && to == f64::INFINITY;
        // Without an interval those between need not be read.
        let asked: Vec<usize> = (0..self.states.len()).step_by(if all { every.max(1) } else { 1 }).collect();
        let mut seen = Vec::new();
        let mut missing = (0, None);
        let mut times = [f64::INFINITY, f64::NEG_INFINITY];
        for part in asked.chunks(rayon::current_num_threads().max(1)) {
            if !watch(seen.len(), asked.len()) {
                return Err(RenderError::Stopped { done: seen.len(), all: asked.len() });
            }
            for looked in part.par_iter().map(|&i| self.look_at(i)).collect::<Vec<_>>() {
                let state = match looked {
                    Err(fault @ RenderError::Missing { .. }) => {
                        missing = (missing.0 + 1, missing.1.or(Some(fault)));
                        continue;
                    }
                    looked => looked?,
                };
                times = [times[0].min(state.time), times[1].max(state.time)];
                if all || inside(state.time, from, to) {
                    seen.push(state);
                }
            }
        }
        if !all {
            seen = seen.into_iter().step_by(every.max(1)).collect();
        }
        let Some(last) = seen.last() else {
            if let Some(fault) = missing.1 {
                return Err(fault);
            }
            let interval = interval(from, to);
            return Err(RenderError::Nothing { states: asked.len(), interval, first: times[0], last: times[1] });
        };
        if self.frames.colour.is_of_births() && !seen.iter().any(|state| state.births) {
            return Err(RenderError::Missing {
                origin: self.states.origin(last.index),
                colour: self.frames.colour.name(),
                why: "no body was born in these states".into(),
                help: "bodies are born where the scene has `growth` and a cell has reached growth.division_length",
            });
        }
        let colour = self.frames.colour.name();
        let note = (missing.0 > 0).then(|| {
            let states = missing.0;
            format!("{states} states have no {colour} and are left out; output.forces=true records the forces of all")
        });
        Ok((seen, note))
    }

    fn look_at(&self, index: usize) -> Result<ScannedState, RenderError> {
        let state = self.states.read(index)?;
        let outside = !inside(state.time, self.frames.from, self.frames.to);
        if outside {
            return Ok(ScannedState { index, time: state.time, extent: Extent::NONE, scale: None, births: false });
        }
        let extent = Extent::of(axes_from(self.side), &state.bodies.wrapped());
        let births = state.bodies.lineage.iter().any(|line| line.parent.is_some() || line.generation > 0);
        Ok(ScannedState { index, time: state.time, extent, scale: self.scale_of(&self.values(index, &state)?), births })
    }

    fn values(&self, index: usize, state: &Snapshot) -> Result<Vec<f64>, RenderError> {
        self.frames.colour.of(state, &self.run).map_err(|LeftOut(why)| RenderError::Missing {
            origin: self.states.origin(index),
            colour: self.frames.colour.name(),
            why,
            help: "run with output.forces = true (`relcp run SCENE --set output.forces=true`), and with contact.method relcp or snsd; \
                   or choose orientation, length, speed, contacts or overlap, which every state tells",
        })
    }

    fn scale_of(&self, values: &[f64]) -> Option<Scale> {
        let fitted = Scale::of(values, self.frames.colour.ends()?)?;
        Some(match self.frames.range {
            Some([low, high]) => Scale { low, high, ..fitted },
            None => fitted,
        })
    }

    /// Draws the states and writes the pictures, as many at a time as there are threads.
    fn draw(&self, seen: &[ScannedState], folder: &Path, watch: Watch<'_>) -> Result<Vec<RenderedFrame>, RenderError> {
        let together = seen.iter().fold(Extent::NONE, |all, state| all.with(state.extent));
        let scale = seen.iter().filter_map(|state| state.scale).reduce(Scale::with);
        let pixels = self.size[0] as usize * self.size[1] as usize;
        let at_a_time = rayon::current_num_threads().min(MEMORY / (MEMORY_A_PIXEL * pixels)).max(1);
        let mut drawn = Vec::new();
        for part in seen.chunks(at_a_time) {
            if !watch(drawn.len(), seen.len()) {
                return Err(RenderError::Stopped { done: drawn.len(), all: seen.len() });
            }
            let first = drawn.len();
            let one = |(k, state): (usize, &ScannedState)| {
                let (extent, scale) = match self.frames.fit {
                    Fit::Run => (together, scale),
                    Fit::Each => (state.extent, state.scale),
                };
                let camera = extent.fit(axes_from(self.side), self.size);
                self.draw_one(first + k, state.index, &camera, scale, folder)
            };
            drawn.extend(part.par_iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?);
        }
        watch(seen.len(), seen.len());
        Ok(drawn)
    }

    fn draw_one(
        &self,
        number: usize,
        index: usize,
        camera: &Camera,
        scale: Option<Scale>,
        folder: &Path,
    ) -> Result<RenderedFrame, RenderError> {
        let state = self.states.read(index)?;
        let values = self.values(index, &state)?;
        let colours = scale::colours(self.frames.colour, &state.bodies, &values, scale);
        let [width, height] = self.size;
        let view = View {
            width,
            height,
            planar: self.run.planar,
            background: self.frames.background,
            scale_bar: self.frames.words,
            ..View::default()
        };
        let bodies = state.bodies.wrapped();
        let paint = |inks: [Vec3; 2]| {
            let mut image = match self.rays {
                Some(rays) => painted(&bodies, &view, camera, &colours, inks, on_device(rays))?,
                None => {
                    let Ok(image) = painted(&bodies, &view, camera, &colours, inks, on_cpu);
                    image
                }
            };
            let inks = inks.map(super::bytes);
            self.backdrop.draw(&mut image, &view, camera, inks[0], inks[1]);
            if self.frames.words {
                caption::state(&mut image, &state, inks);
                caption::legend(&mut image, self.frames.colour, scale, inks);
            }
            Ok::<_, RenderError>(image)
        };
        let image = match self.frames.background {
            Background::Transparent => Image::between(paint(inks_on(WHITE))?, &paint(inks_on(BLACK))?),
            background => paint(background.ink_and_paper())?,
        };
        let file = Path::new(FOLDER).join(format!("{number:06}.png"));
        write(&image, &folder.join(&file))?;
        Ok(RenderedFrame {
            file,
            step: state.step,
            time: state.time,
            bodies: state.bodies.len(),
            centre: camera.centre.to_array(),
            pixels_per_length: camera.pixels_per_length(),
            scale,
        })
    }
}

/// An interval of time in words.
pub(crate) fn interval(from: f64, to: f64) -> String {
    match (from.is_finite(), to.is_finite()) {
        (true, true) => format!("from time {from} to {to}"),
        (true, false) => format!("at time {from} or later"),
        _ => format!("at time {to} or earlier"),
    }
}

/// Whether a time is in an interval, but for rounding.
pub(crate) fn inside(time: f64, from: f64, to: f64) -> bool {
    let slack = |bound: f64| if bound.is_finite() { ROUNDING * time.abs().max(bound.abs()) } else { 0.0 };
    time >= from - slack(from) && time <= to + slack(to)
}

fn write(image: &Image, path: &Path) -> Result<(), RecordError> {
    let mut bytes = Vec::new();
    image.encode(&mut bytes).map_err(RecordError::io(path, "pack it"))?;
    durable::place(path, &bytes)
}

/// Makes the folder, and removes the pictures of an earlier rendering.
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
    let number = path.file_name().and_then(|name| name.to_str()?.strip_suffix(".png"));
    number.is_some_and(|number| number.len() >= 6 && number.bytes().all(|byte| byte.is_ascii_digit()))
}
