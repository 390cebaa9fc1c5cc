//! Information from a run's scene that its states lack: whether it is planar, the drag, and which bodies are fixed.

use crate::constraint::friction::Coefficients;
use crate::dynamics::{Drag, Stream};
use crate::fixed::Fixed;
use crate::periodic::CellShear;
use crate::record::{States, StatesError, scene_of};
use crate::scene::{self, Growth, Scene};
use crate::step::Method;
use crate::walls::Wall;
use serde::Serialize;
use std::path::Path;

/// The data that all states of a run share.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// Whether the run is measured as planar: areas instead of volumes, angles in the plane.
    pub planar: bool,
    /// The source of this information.
    pub planar_from: String,
    /// The drag of the overdamped law, if this is the run's law, no flow carries its bodies and its scene
    /// is available.
    pub drag: Option<Drag>,
    /// The shear of the run's sheared cell, if it has one and its scene is available, and the flow that carries bodies,
    /// under a law with drag.
    #[serde(skip)]
    pub(super) shear: Option<(CellShear, Option<Stream>)>,
    /// The fixed bodies, if the scene is available.
    #[serde(skip)]
    pub(super) fixed: Fixed,
    /// The coefficients of friction, if the scene is available and has some.
    #[serde(skip)]
    pub(super) friction: Option<Coefficients>,
    /// The walls, if the scene is available.
    #[serde(skip)]
    pub(super) walls: Vec<Wall>,
    /// The names of groups, if the scene is available.
    #[serde(skip)]
    pub(super) group_names: Vec<String>,
    /// Whether contacts are those of sub-spheres, if the scene is available.
    #[serde(skip)]
    pub(super) sub_spheres: bool,
    /// How its scene's bodies grow, if the scene is available.
    #[serde(skip)]
    pub(super) growth: Vec<Growth>,
    /// Whether its scene removes bodies.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub removes: bool,
}

impl Frame {
    /// The frame of `states`, which were [opened](States::open) from `source`: from the scene, which is `scene.json`
    /// for a run's folder or a state in one. Without a scene it is planar if all bodies of the last state have centres
    /// in one plane of constant z and are mirror-symmetric in it.
    ///
    /// # Errors
    /// A scene or a state that cannot be read.
    pub fn of(source: impl AsRef<Path>, states: &States) -> Result<Frame, StatesError> {
        if let Some((scene, origin)) = scene_behind(source.as_ref())? {
            return Ok(Frame::of_scene(&scene, origin));
        }
        Ok(Frame {
            planar: states.planar()?,
            planar_from: "the bodies of the last state".into(),
            drag: None,
            shear: None,
            fixed: Fixed::default(),
            friction: None,
            walls: Vec::new(),
            group_names: Vec::new(),
            sub_spheres: false,
            growth: Vec::new(),
            removes: false,
        })
    }

    /// The frame of a scene named `origin`.
    pub fn of_scene(scene: &Scene, origin: String) -> Frame {
        let cell = scene.periodic;
        Frame {
            planar: scene.planar,
            planar_from: origin,
            drag: scene.dynamics.drag().filter(|_| scene.flow.is_none() && !cell.is_some_and(|cell| cell.changes())),
            shear: cell
                .and_then(|cell| cell.shear)
                .map(|shear| (shear, Stream::of_cell(&shear, &scene.dynamics, scene.planar))),
            fixed: scene.fixed(),
            friction: Some(scene.friction()).filter(|friction| !friction.is_none()),
            walls: scene.walls.clone(),
            group_names: scene.group_names(),
            sub_spheres: matches!(scene.contact.method, Method::Multisphere { .. }),
            growth: scene.growth.clone(),
            removes: !scene.removal.is_empty(),
        }
    }
}

/// The scene that states were [opened](States::open) from or belong to, and its name in messages. `None` if a run's
/// folder has no scene.
///
/// # Errors
/// A scene that cannot be read.
pub(crate) fn scene_behind(path: &Path) -> Result<Option<(Scene, String)>, StatesError> {
    if let Some(path) = scene_of(path) {
        return Ok(Some((Scene::read(&path)?, path.display().to_string())));
    }
    if path.is_dir() || path.extension().is_some_and(|extension| extension == "npz") {
        return Ok(None);
    }
    Ok(Some((Scene::load(path, scene::NO_OVERRIDES)?, path.display().to_string())))
}
