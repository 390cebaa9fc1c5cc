//! A load on a wall: it pushes the wall along its normal, against a drag or an inertia of the wall's own, and bodies
//! push back. With the contacts' forces `gamma` the wall moves along its normal, towards the bodies, by
//!
//! ```text
//! drag v = F - sum of gamma,     mass dv/dt = F - sum of gamma
//! ```
//!
//! Both are solved together with contact, as of one more body with one unknown: the velocity over the step is that at
//! its end. In rows the wall has the mobility `n n^T / drag`, or `n n^T dt / mass`.

use super::{Wall, Walls};
use crate::bodies::WallState;
use crate::periodic::Periods;
use crate::separation::Surface;
use glam::DVec3;

/// A load on a plane, which moves it along its normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct WallLoad {
    /// The force that pushes it, along its normal: towards the bodies where it is positive. Needs this or `pressure`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub force: Option<f64>,
    /// The force over the plane's area in one periodic cell (in the plane its length), in place of `force`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub pressure: Option<f64>,
    /// The wall's own drag, a force over a velocity. Needs this or `mass`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub drag: Option<f64>,
    /// The wall's mass, in place of `drag`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub mass: Option<f64>,
    /// Its velocity along its normal at the start, with `mass`. Without it: at rest.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub velocity: Option<f64>,
}

impl WallLoad {
    /// A force on a wall with a drag of its own.
    ///
    /// ```
    /// use relcp::walls::WallLoad;
    /// assert_eq!(WallLoad::of_force(2.0, 0.5).drag, Some(0.5));
    /// ```
    pub fn of_force(force: f64, drag: f64) -> WallLoad {
        WallLoad { force: Some(force), drag: Some(drag), ..WallLoad::default() }
    }

    /// The force on a plane of this area.
    fn whole(&self, area: Option<f64>) -> f64 {
        self.force.or_else(|| Some(self.pressure? * area?)).unwrap_or_default()
    }
}

/// A surface under a load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Loaded {
    /// Its place among the surfaces.
    pub surface: usize,
    /// Towards the bodies.
    pub normal: DVec3,
    /// The force along the normal.
    force: f64,
    load: WallLoad,
}

impl Loaded {
    /// The velocity without contact over a step of `dt`, and the mobility, along the normal.
    pub fn moves(&self, state: WallState, dt: f64) -> [f64; 2] {
        match (self.load.mass, self.load.drag) {
            (Some(mass), _) => [state.velocity + dt * self.force / mass, dt / mass],
            (None, Some(drag)) => [self.force / drag, 1.0 / drag],
            // Validation refuses a load without either.
            (None, None) => [0.0, 0.0],
        }
    }
}

impl Wall {
    /// The load on it, where there is one.
    pub fn load(&self) -> Option<&WallLoad> {
        match self {
            Wall::HalfSpace { load, .. } => load.as_ref(),
            _ => None,
        }
    }

    /// The loaded surface of this wall, whose first surface has the place `first`.
    pub(super) fn loaded(&self, first: usize, periods: &Periods, planar: bool) -> Option<Loaded> {
        let (load, Wall::HalfSpace { normal, .. }) = (*self.load()?, *self) else { return None };
        let area = self.areas(periods, planar).first().copied().flatten();
        let normal = DVec3::from(normal).normalize_or(DVec3::X);
        Some(Loaded { surface: first, normal, force: load.whole(area), load })
    }
}

/// These walls where their loads have moved them, as walls that stand there; those in order that have a load are in
/// `states`.
pub(crate) fn standing(walls: &[Wall], states: &[WallState]) -> Vec<Wall> {
    let mut states = states.iter();
    let stands = |wall: &Wall| match (*wall, wall.load()) {
        (Wall::HalfSpace { normal, offset, motion, friction, load }, Some(_)) => {
            let shift = states.next().map_or(0.0, |state| state.shift);
            Wall::HalfSpace { normal, offset: offset + shift, motion, friction, load }
        }
        _ => *wall,
    };
    walls.iter().map(stands).collect()
}

/// The same as walls to continue with: those under a load with a mass have its velocity.
pub(crate) fn left(walls: &[Wall], states: &[WallState]) -> Vec<Wall> {
    let mut stand = standing(walls, states);
    let loads = stand.iter_mut().filter_map(|wall| match wall {
        Wall::HalfSpace { load, .. } => load.as_mut(),
        _ => None,
    });
    for (load, state) in loads.zip(states) {
        load.velocity = load.mass.map(|_| state.velocity);
    }
    stand
}

impl Walls {
    /// The surfaces under a load.
    pub(crate) fn loaded(&self) -> &[Loaded] {
        &self.loaded
    }

    /// These walls, with those under a load where they have gone from where the scene has them. Without states they
    /// have not gone.
    #[must_use]
    pub fn gone(mut self, states: &[WallState]) -> Walls {
        for (loaded, state) in self.loaded.iter().zip(states) {
            if let Surface::Plane { point, .. } = &mut self.surfaces[loaded.surface] {
                *point += state.shift * loaded.normal;
            }
        }
        self
    }

    /// How far each load moves its wall from rest in a step.
    pub(crate) fn ways_of_loads(&self, dt: f64) -> Vec<f64> {
        let way = |loaded: &Loaded| dt * loaded.moves(WallState::default(), dt)[0].abs();
        self.loaded.iter().map(way).filter(|way| *way > 0.0).collect()
    }

    /// The states of the walls under a load at the start.
    pub(crate) fn first_states(&self) -> Vec<WallState> {
        let of = |loaded: &Loaded| WallState { shift: 0.0, velocity: loaded.load.velocity.unwrap_or_default() };
        self.loaded.iter().map(of).collect()
    }
}
