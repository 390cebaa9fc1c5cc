//! The pictures of a run in memory, one after the other, with one camera and one colour scale.

use super::backdrop::Backdrop;
use super::camera::Extent;
use super::frames::{Fit, Frames};
use super::painter::{Painter, ScannedState};
use super::scale::Scale;
use super::{Image, RenderError, Side, View};
use crate::measure::Frame;
use crate::record::{Snapshot, States, Watch};
use crate::scene::Scene;

/// The pictures that [`render`](fn@super::render) draws into files. The states were scanned; a picture is drawn when it
/// is asked for.
///
/// ```
/// use relcp::Scene;
/// use relcp::record::States;
/// use relcp::render::{Frames, Reel};
/// let (scene, states) = (Scene::built_in("three-capsules")?, States::open("three-capsules")?);
/// let frames = Frames { size: [120, 80], ..Frames::default() };
/// let reel = Reel::of(&scene, &states, &frames, &mut |_done, _all| true)?;
/// let image = reel.picture(&scene, &states, 0)?;
/// assert_eq!((reel.len(), image.width(), image.height()), (1, 120, 80));
/// # Ok::<(), relcp::Error>(())
/// ```
pub struct Reel {
    frames: Frames,
    seen: Vec<ScannedState>,
    extent: Extent,
    scale: Option<Scale>,
}

impl Reel {
    /// Scans the states of a run of `scene`. The format of `frames` has no effect.
    ///
    /// # Errors
    /// A [`RenderError`]: states that cannot be read, or do not have the colour quantity; no state in the interval.
    pub fn of(scene: &Scene, states: &States, frames: &Frames, watch: Watch<'_>) -> Result<Reel, RenderError> {
        if frames.range.is_some() && frames.colour.ends().is_none() {
            return Err(RenderError::NoScale { colour: frames.colour.name() });
        }
        let (seen, _) = painter(scene, states, frames).scan(watch)?;
        let (extent, scale) = Painter::together(&seen);
        Ok(Reel { frames: frames.clone(), seen, extent, scale })
    }

    /// The number of pictures.
    pub fn len(&self) -> usize {
        self.seen.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// Picture `nth`, less than [`Reel::len`], of the same scene and states.
    ///
    /// # Errors
    /// A state that cannot be read.
    pub fn picture(&self, scene: &Scene, states: &States, nth: usize) -> Result<Image, RenderError> {
        let (painter, seen) = (painter(scene, states, &self.frames), &self.seen[nth]);
        match self.frames.fit {
            Fit::Run => painter.draw_alone(seen, self.extent, self.scale),
            Fit::Each => {
                let (extent, scale) = Painter::together(std::slice::from_ref(seen));
                painter.draw_alone(seen, extent, scale)
            }
        }
    }
}

fn painter<'a>(scene: &Scene, states: &'a States, frames: &'a Frames) -> Painter<'a> {
    Painter {
        rays: None,
        states,
        frames,
        run: Frame::of_scene(scene, scene.name.clone()),
        backdrop: Backdrop::of(scene),
        side: frames.side.unwrap_or(if scene.planar { Side::Top } else { Side::Oblique }),
        size: frames.size.map(|side| side.clamp(1, View::LARGEST_SIDE)),
    }
}

/// The picture of one state of `scene`, as [`render`](fn@super::render) draws it: camera and colour scale fit it.
///
/// ```
/// use relcp::Scene;
/// use relcp::record::Snapshot;
/// use relcp::render::{Frames, still};
/// let scene = Scene::built_in("three-capsules")?;
/// let (bodies, removed, fields) = (scene.build()?, Vec::new(), Vec::new());
/// let state = Snapshot { step: 0, time: 0.0, bodies, warm: None, removed, fields };
/// let image = still(&scene, state, &Frames { size: [120, 80], ..Frames::default() })?;
/// assert_eq!((image.width(), image.height()), (120, 80));
/// # Ok::<(), relcp::Error>(())
/// ```
///
/// # Errors
/// [`RenderError::Missing`] if the state does not have the colour quantity, [`RenderError::NoScale`] for a range of a
/// quantity without a scale.
pub fn still(scene: &Scene, state: Snapshot, frames: &Frames) -> Result<Image, RenderError> {
    let frames = Frames { from: f64::NEG_INFINITY, to: f64::INFINITY, ..frames.clone() };
    let states = States::single(&scene.name, state);
    // There is one state, and the scan has it.
    Reel::of(scene, &states, &frames, &mut |_, _| true)?.picture(scene, &states, 0)
}

/// The same as a file in the format of `frames`: pixels, or vectors for a planar scene seen from the top.
///
/// # Errors
/// As [`still`], and [`RenderError::NoVectors`].
pub fn still_file(scene: &Scene, state: Snapshot, frames: &Frames) -> Result<Vec<u8>, RenderError> {
    let frames = Frames { from: f64::NEG_INFINITY, to: f64::INFINITY, ..frames.clone() };
    let states = States::single(&scene.name, state);
    let painter = painter(scene, &states, &frames);
    painter.check_format()?;
    let reel = Reel::of(scene, &states, &frames, &mut |_, _| true)?;
    // There is one state, and the scan has it.
    painter.file_alone(&reel.seen[0])
}
