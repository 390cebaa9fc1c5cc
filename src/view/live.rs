//! A run that goes on as a page for a browser: the same page as of a recorded run, which gets its states one by one.
//!
//! A state that is sent stands for itself: the page needs none of the states before, so a server may leave out any. It
//! is the description of a page with this state alone, as JSON after its length in bytes (a 32-bit number, lowest byte
//! first), then the columns of its bodies and of the state, unpacked. `assets/view/live.js` reads it.

use super::places::Grid;
use super::select::Chosen;
use super::{Packer, Pages, Prepared, Viewed, page};
use crate::measure::Frame;
use crate::record::Snapshot;
use crate::render::RenderError;
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::step::Fault;
use crate::walls::Walls;
use glam::DVec3;
use std::sync::Arc;

/// What states are shown with, until a change of the scene.
struct Behind {
    scene: Scene,
    frame: Frame,
}

/// The states of a simulation for its page.
///
/// ```
/// use relcp::view::Live;
/// let mut simulation = relcp::Simulation::new(relcp::Scene::built_in("three-capsules")?)?;
/// let mut live = Live::of(&simulation)?;
/// let page = Live::page()?;
/// simulation.step()?;
/// let state = live.take(&simulation)?;
/// assert_eq!(state.step(), 1);
/// assert!(!page.is_empty() && !state.pack()?.is_empty());
/// # Ok::<(), relcp::Error>(())
/// ```
pub struct Live {
    grid: Grid,
    behind: Arc<Behind>,
    /// Changes of the scene that these know.
    changes: usize,
}

/// A state that was taken, to be packed elsewhere.
pub struct Taken {
    state: Snapshot,
    grid: Grid,
    behind: Arc<Behind>,
}

impl Live {
    /// Those of a simulation from its present state on, whose centres are in steps of its bodies' sizes.
    ///
    /// # Errors
    /// [`Fault::Device`] if the device does not respond.
    pub fn of(simulation: &Simulation) -> Result<Live, Fault> {
        let bodies = simulation.state()?.bodies.wrapped();
        let places = || bodies.position.iter().filter(|x| x.is_finite());
        let low = places().fold(DVec3::INFINITY, |low, x| low.min(*x));
        let high = places().fold(DVec3::NEG_INFINITY, |high, x| high.max(*x));
        let thinnest = bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
        let grid = Grid::new(low, high, thinnest);
        Ok(Live { grid, behind: Behind::of(simulation), changes: simulation.changes_made() })
    }

    /// The page.
    ///
    /// # Errors
    /// None is known.
    pub fn page() -> Result<Vec<u8>, RenderError> {
        page::live()
    }

    /// Copies the present state.
    ///
    /// # Errors
    /// [`Fault::Device`] if the device does not respond.
    pub fn take(&mut self, simulation: &Simulation) -> Result<Taken, Fault> {
        if self.changes != simulation.changes_made() {
            (self.behind, self.changes) = (Behind::of(simulation), simulation.changes_made());
        }
        // A change may remove and add bodies before the next step.
        let state = simulation.coming_state()?;
        let state = Snapshot {
            step: state.step,
            time: simulation.time(),
            bodies: state.bodies.clone(),
            warm: Some(state.warm.clone()),
            removed: state.removed.clone(),
            fields: state.fields.clone(),
        };
        Ok(Taken { state, grid: self.grid, behind: self.behind.clone() })
    }
}

impl Behind {
    fn of(simulation: &Simulation) -> Arc<Behind> {
        let scene = simulation.scene().clone();
        Arc::new(Behind { frame: Frame::of_scene(&scene, scene.name.clone()), scene })
    }
}

impl Taken {
    /// Steps before the state.
    pub fn step(&self) -> u64 {
        self.state.step
    }

    /// The state as the page reads it.
    ///
    /// # Errors
    /// None is known.
    pub fn pack(self) -> Result<Vec<u8>, RenderError> {
        let Taken { state, grid, behind } = self;
        let Behind { scene, frame } = &*behind;
        let periods = state.bodies.wrapped().periods.lengths();
        let chosen = Chosen { indices: vec![0], periods, most: state.bodies.len(), grid };
        let walls = Walls::new(&scene.walls, frame.planar);
        let mut packer = Packer::new(&chosen);
        packer.add(Prepared::of(state, frame, &walls, 1, true));
        let notes = packer.notes();
        let viewed = Viewed { bytes: 0, states: 1, bodies: chosen.most, errors: packer.errors, notes };
        let shown = super::header::Header::new(
            &scene.name,
            &Pages::default(),
            frame,
            Some(scene),
            &chosen,
            &packer,
            super::steps::Tables::default(),
            &viewed,
        );
        let document = page::json(&shown.live())?;
        let mut bytes = Vec::from((document.len() as u32).to_le_bytes());
        bytes.extend(document);
        bytes.extend(packer.shared().bytes());
        packer.waiting.iter().for_each(|block| bytes.extend(block.bytes()));
        Ok(bytes)
    }
}
