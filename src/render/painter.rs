//! Draws the states of a run, one picture per state: scans all of them first, then draws several in parallel.

use super::backdrop::Backdrop;
use super::camera::{Extent, axes_from};
use super::frames::{FOLDER, Fit, Frames, RenderedFrame, inside, interval, picture_file};
use super::quantity::Quantity;
use super::scale::{self, Scale};
use super::{
    BLACK, Background, Camera, Image, Rays, RenderError, Side, View, WHITE, caption, inks_on, on_cpu, on_device,
    painted, vector,
};
use crate::bodies::{Bodies, NO_GROUP};
use crate::figure::Format;
use crate::measure::{Frame, LeftOut};
use crate::page::Page;
use crate::record::{RecordError, Snapshot, States, Watch, durable};
use glam::Vec3;
use rayon::prelude::*;
use std::path::Path;

/// The largest memory of the rays of all pictures that are drawn in parallel, in bytes; a single picture may take more.
const MEMORY: usize = 2 << 30;
/// Memory per pixel during drawing, in bytes: four rays of 16 bytes, and the colour.
const MEMORY_A_PIXEL: usize = 67;

/// A state that was scanned.
pub(super) struct ScannedState {
    /// The index of the state.
    index: usize,
    time: f64,
    extent: Extent,
    scale: Option<Scale>,
    /// Whether any body is a daughter.
    births: bool,
    /// Whether any body has a group.
    groups: bool,
}

/// Draws the pictures of a run.
pub(super) struct Painter<'a> {
    pub rays: Option<&'a Rays>,
    pub states: &'a States,
    pub frames: &'a Frames,
    pub run: Frame,
    pub backdrop: Backdrop,
    pub side: Side,
    pub size: [u32; 2],
}

impl Painter<'_> {
    /// Scans the states to draw, and returns how many lack the colour quantity.
    pub fn scan(&self, watch: Watch<'_>) -> Result<(Vec<ScannedState>, Option<String>), RenderError> {
        let Frames { from, to, every, .. } = *self.frames;
        let all = from == f64::NEG_INFINITY && to == f64::INFINITY;
        // Without an interval, the states in between need not be read.
        let asked: Vec<usize> = (0..self.states.len()).step_by(if all { every.max(1) } else { 1 }).collect();
        let mut seen = Vec::new();
        let mut missing = (0, None);
        let mut times = [f64::INFINITY, f64::NEG_INFINITY];
        for part in asked.chunks(rayon::current_num_threads().max(1)) {
            if !watch(seen.len(), asked.len()) {
                return Err(RenderError::Stopped { done: seen.len(), all: asked.len() });
            }
            for scanned in part.par_iter().map(|&i| self.scan_state(i)).collect::<Vec<_>>() {
                let state = match scanned {
                    Err(fault @ RenderError::Missing { .. }) => {
                        missing = (missing.0 + 1, missing.1.or(Some(fault)));
                        continue;
                    }
                    scanned => scanned?,
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
        if self.frames.colour == Quantity::Group && !seen.iter().any(|state| state.groups) {
            return Err(RenderError::Missing {
                origin: self.states.origin(last.index),
                colour: self.frames.colour.name(),
                why: "no body of these states has a group".into(),
                help: "give bodies, or rules of `generate`, a `group` in the scene; daughters inherit it",
            });
        }
        let colour = self.frames.colour.name();
        let note = (missing.0 > 0).then(|| {
            let states = missing.0;
            format!(
                "{states} states have no {colour} and are left out; output.forces=true records forces in all states"
            )
        });
        Ok((seen, note))
    }

    /// Refuses vectors of what has depth.
    pub fn check_format(&self) -> Result<(), RenderError> {
        let planar = self.run.planar;
        if self.frames.format != Format::Png && (self.side != Side::Top || !planar) {
            return Err(RenderError::NoVectors { side: if planar { "from a side" } else { "in space" } });
        }
        Ok(())
    }

    fn scan_state(&self, index: usize) -> Result<ScannedState, RenderError> {
        let state = self.states.read(index)?;
        let outside = !inside(state.time, self.frames.from, self.frames.to);
        if outside {
            return Ok(ScannedState {
                index,
                time: state.time,
                extent: Extent::NONE,
                scale: None,
                births: false,
                groups: false,
            });
        }
        let extent = Extent::of(axes_from(self.side), &state.bodies.wrapped());
        let births = state.bodies.lineage.iter().any(|line| line.parent.is_some() || line.generation > 0);
        let groups = state.bodies.group.iter().any(|group| *group != NO_GROUP);
        let scale = self.scale_of(&self.values(index, &state)?);
        Ok(ScannedState { index, time: state.time, extent, scale, births, groups })
    }

    fn values(&self, index: usize, state: &Snapshot) -> Result<Vec<f64>, RenderError> {
        self.frames.colour.of(state, &self.run).map_err(|LeftOut(why)| RenderError::Missing {
            origin: self.states.origin(index),
            colour: self.frames.colour.name(),
            why,
            help: "run with output.forces = true (output.forces=true as an override), and with contact.method relcp or snsd; \
                   or choose orientation, length, speed, contacts or overlap, which all states have",
        })
    }

    fn scale_of(&self, values: &[f64]) -> Option<Scale> {
        let fitted = Scale::of(values, self.frames.colour.ends()?)?;
        Some(match self.frames.range {
            Some([low, high]) => Scale { low, high, ..fitted },
            None => fitted,
        })
    }

    /// Draws the states and writes the pictures, one per thread at a time.
    pub fn draw(
        &self,
        seen: &[ScannedState],
        folder: &Path,
        watch: Watch<'_>,
    ) -> Result<Vec<RenderedFrame>, RenderError> {
        let (together, scale) = Painter::together(seen);
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
        let bytes = self.bytes(&state, camera, &colours, scale, folder)?;
        let file = picture_file(number, self.frames.format);
        durable::place(&folder.join(&file), &bytes)?;
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

    /// The file of a picture; `folder` is where it goes, for messages.
    fn bytes(
        &self,
        state: &Snapshot,
        camera: &Camera,
        colours: &[Vec3],
        scale: Option<Scale>,
        folder: &Path,
    ) -> Result<Vec<u8>, RenderError> {
        let bodies = state.bodies.wrapped();
        if self.frames.format == Format::Png {
            let mut bytes = Vec::new();
            let image = self.pixels(state, &bodies, camera, colours, scale)?;
            image.encode(&mut bytes).map_err(RecordError::io(folder, "pack a picture"))?;
            return Ok(bytes);
        }
        let page = self.vectors(state, &bodies, camera, colours, scale);
        let failed = |what| RecordError::io(folder, "draw a picture")(std::io::Error::other(what));
        Ok(page.file(self.frames.format).map_err(failed)?)
    }

    /// The extent and the colour scale of all states together.
    pub fn together(seen: &[ScannedState]) -> (Extent, Option<Scale>) {
        let extent = seen.iter().fold(Extent::NONE, |all, state| all.with(state.extent));
        (extent, seen.iter().filter_map(|state| state.scale).reduce(Scale::with))
    }

    /// The picture of a scanned state, in pixels.
    pub fn draw_alone(&self, seen: &ScannedState, extent: Extent, scale: Option<Scale>) -> Result<Image, RenderError> {
        let state = self.states.read(seen.index)?;
        let values = self.values(seen.index, &state)?;
        let colours = scale::colours(self.frames.colour, &state.bodies, &values, scale);
        let camera = extent.fit(axes_from(self.side), self.size);
        self.pixels(&state, &state.bodies.wrapped(), &camera, &colours, scale)
    }

    /// The file of a scanned state's picture.
    pub fn file_alone(&self, seen: &ScannedState) -> Result<Vec<u8>, RenderError> {
        let state = self.states.read(seen.index)?;
        let values = self.values(seen.index, &state)?;
        let colours = scale::colours(self.frames.colour, &state.bodies, &values, seen.scale);
        let camera = seen.extent.fit(axes_from(self.side), self.size);
        self.bytes(&state, &camera, &colours, seen.scale, Path::new(FOLDER))
    }

    /// The picture of a state in pixels.
    fn pixels(
        &self,
        state: &Snapshot,
        bodies: &Bodies,
        camera: &Camera,
        colours: &[Vec3],
        scale: Option<Scale>,
    ) -> Result<Image, RenderError> {
        let [width, height] = self.size;
        let view = View {
            width,
            height,
            planar: self.run.planar,
            background: self.frames.background,
            scale_bar: self.frames.words,
            ..View::default()
        };
        let backdrop = self.backdrop.of_state(state.time, &state.bodies.walls, &state.fields);
        let paint = |inks: [Vec3; 2]| {
            let mut image = match self.rays {
                Some(rays) => painted(bodies, &view, camera, colours, inks, on_device(rays))?,
                None => {
                    let Ok(image) = painted(bodies, &view, camera, colours, inks, on_cpu);
                    image
                }
            };
            let inks = inks.map(super::bytes);
            backdrop.draw(&mut image, &view, camera, inks[0], inks[1]);
            if self.frames.words {
                caption::state(&mut image, state, inks);
                caption::legend(&mut image, (self.frames.colour, scale), &backdrop.groups, inks);
            }
            Ok::<_, RenderError>(image)
        };
        Ok(match self.frames.background {
            Background::Transparent => Image::between(paint(inks_on(WHITE))?, &paint(inks_on(BLACK))?),
            background => paint(background.ink_and_paper())?,
        })
    }

    /// The picture of a state as vectors.
    fn vectors(
        &self,
        state: &Snapshot,
        bodies: &Bodies,
        camera: &Camera,
        colours: &[Vec3],
        scale: Option<Scale>,
    ) -> Page {
        let words = self.frames.words.then(|| (caption::words(state), self.frames.colour, scale));
        let (backdrop, background, size) = (
            &self.backdrop.of_state(state.time, &state.bodies.walls, &state.fields),
            self.frames.background,
            self.size,
        );
        vector::page(&vector::Drawn { bodies, colours, backdrop, camera, background, size, words })
    }
}
