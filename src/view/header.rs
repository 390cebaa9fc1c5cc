//! The description of a page's data: `assets/view/` reads this document by these names.

use super::columns::{Block, Column};
use super::select::Chosen;
use super::steps::{Measures, Steps, Tables};
use super::values::given;
use super::{Errors, Packer, Pages, Viewed};
use crate::measure::Frame;
use crate::periodic::Tilt;
use crate::record::Snapshot;
use crate::render::Quantity;
use crate::scene::Scene;
use crate::walls::{Moved, Wall, WallState, standing};
use glam::DQuat;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The most bonds that a state of a run that goes on tells again: some 100 kB.
const MOST_LIVE_BONDS: usize = 1_000;

/// The document.
#[derive(Serialize)]
pub(super) struct Header {
    name: String,
    version: &'static str,
    /// The numbers of the scene by their dotted keys.
    parameters: Vec<(String, Value)>,
    planar: bool,
    /// The initial colour quantity, if one was chosen.
    colour: Option<&'static str>,
    /// Length of a step of centres.
    length_step: f64,
    /// The middle of all centres: in steps, and as a place.
    middle: [i32; 3],
    origin: [f64; 3],
    groups: Vec<String>,
    periods: [Option<f64>; 3],
    walls: Vec<Wall>,
    /// Whether bodies have bonds, or may get some.
    bonded: bool,
    /// Where states do not tell which hold: the bonds between bodies with these ids, from a point of each in its axes.
    bonds: Vec<([u64; 2], [[f64; 3]; 2])>,
    quantities: Vec<Told>,
    measured: Vec<&'static str>,
    table: Shared,
    states: Vec<StateHeader>,
    steps: Option<Steps>,
    measures: Option<Measures>,
    contacts_left_out: String,
    errors: Errors,
    about: Vec<String>,
}

/// A quantity that colours can show.
#[derive(Serialize)]
struct Told {
    name: &'static str,
    text: &'static str,
    kind: &'static str,
    /// Low end, high end, largest value.
    scale: Option<[f64; 3]>,
    missing: Option<String>,
}

/// The table of all bodies.
#[derive(Serialize)]
struct Shared {
    bodies: usize,
    columns: Vec<Column>,
}

/// What is known of a state.
#[derive(Clone, Default, Serialize)]
pub(super) struct StateHeader {
    step: u64,
    time: f64,
    bodies: usize,
    /// How many contacts; null where they were too many.
    pub contacts: Option<usize>,
    /// The values at the ends of columns of 65,535 steps.
    pub ranges: BTreeMap<&'static str, [f64; 2]>,
    /// The scales of colours of this state alone.
    pub scales: BTreeMap<&'static str, [f64; 3]>,
    /// What it does not tell, and why.
    pub missing: BTreeMap<&'static str, String>,
    pub columns: Vec<Column>,
    /// Which of the scene's bonds are broken.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    broken_bonds: Vec<u32>,
    /// Where walls under a load are.
    #[serde(skip)]
    loaded: Vec<WallState>,
    /// The periods of space then, where they change.
    #[serde(skip_serializing_if = "Option::is_none")]
    periods: Option<[Option<f64>; 3]>,
    /// By how much images across one axis are displaced along another, in a sheared cell: direction, gradient, offset.
    #[serde(skip_serializing_if = "Option::is_none")]
    tilt: Option<(usize, usize, f64)>,
    /// Where each wall of the scene is that moves, and null for each that does not; left out where none moves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    walls: Vec<Option<WallPlace>>,
}

/// Where a wall is.
#[derive(Clone, Serialize)]
struct WallPlace {
    /// Its reference point as the scene gives it.
    reference: [f64; 3],
    /// How far it has gone.
    shift: [f64; 3],
    /// How it has turned about its reference point, `[w, x, y, z]`.
    turn: [f64; 4],
}

impl StateHeader {
    /// Of a state, without columns yet.
    pub fn new(state: &Snapshot) -> StateHeader {
        StateHeader {
            step: state.step,
            time: state.time,
            bodies: state.bodies.len(),
            broken_bonds: state.bodies.broken_bonds.clone(),
            loaded: state.bodies.walls.clone(),
            ..StateHeader::default()
        }
    }

    /// Tells where the walls are, if any moves.
    fn place_walls(&mut self, walls: &[Wall]) {
        if walls.iter().any(|wall| wall.motion().is_some() || wall.load().is_some()) {
            let stand = standing(walls, &self.loaded);
            let place = |(wall, stands): (&Wall, &Wall)| {
                let gone = stands.reference() - wall.reference();
                let moved = match wall.load() {
                    Some(_) => Moved { reference: wall.reference(), shift: gone, turn: None },
                    None => wall.moved(self.time)?,
                };
                Some(WallPlace::of(moved))
            };
            self.walls = walls.iter().zip(&stand).map(place).collect();
        }
    }
}

impl WallPlace {
    fn of(moved: Moved) -> WallPlace {
        let turn = moved.turn.unwrap_or(DQuat::IDENTITY);
        let (reference, shift) = (moved.reference.to_array(), moved.shift.to_array());
        WallPlace { reference, shift, turn: [turn.w, turn.x, turn.y, turn.z] }
    }
}

impl Header {
    /// The document of a page that has all its states.
    #[allow(clippy::too_many_arguments)]
    pub fn new(
        name: &str,
        pages: &Pages,
        frame: &Frame,
        scene: Option<&Scene>,
        chosen: &Chosen,
        packer: &Packer,
        tables: Tables,
        viewed: &Viewed,
    ) -> Header {
        let told = |quantity: &Quantity| packer.told(*quantity);
        let quantities: Vec<Told> = Quantity::ALL.iter().map(told).collect();
        let mut states = packer.headers.clone();
        states.iter_mut().for_each(|state| state.place_walls(scene.map_or(&[], |scene| &scene.walls)));
        let changing = scene.and_then(|scene| scene.periodic).filter(|cell| cell.strain_rate.is_some());
        if let Some(cell) = changing {
            states.iter_mut().for_each(|state| state.periods = Some(cell.at(state.time).lengths()));
        }
        if let Some(cell) = scene.and_then(|scene| scene.periodic).filter(|cell| cell.shear.is_some()) {
            let of = |tilt: Tilt| (tilt.direction.index(), tilt.gradient.index(), tilt.offset);
            states.iter_mut().for_each(|state| state.tilt = cell.at(state.time).tilt().map(of));
        }
        let there = |name: &str| quantities.iter().any(|told| told.name == name && told.missing.is_none());
        Header {
            name: name.into(),
            version: env!("CARGO_PKG_VERSION"),
            parameters: scene.map(Scene::adjustable).unwrap_or_default(),
            planar: frame.planar,
            colour: pages.colour.map(|colour| colour.name()).filter(|name| there(name)),
            length_step: chosen.grid.step,
            middle: chosen.grid.middle,
            origin: chosen.grid.origin().to_array(),
            groups: scene.map(Scene::group_names).unwrap_or_default(),
            periods: chosen.periods,
            walls: scene.map(|scene| scene.walls.clone()).unwrap_or_default(),
            bonded: packer.bonds.any || scene.is_some_and(is_bonded),
            bonds: scene.filter(|_| !packer.bonds.any).map(bonds).unwrap_or_default(),
            quantities,
            measured: given(),
            table: Shared { bodies: packer.table.len(), columns: packer.table.block().layout() },
            states,
            steps: tables.steps,
            measures: tables.measures,
            contacts_left_out:
                "This state has too many contacts for a page. A page of fewer states, or of this one alone, has them."
                    .into(),
            errors: viewed.errors,
            about: about(chosen, viewed),
        }
    }
}

impl Header {
    /// The same of a run that goes on.
    pub fn live(mut self) -> Header {
        // Its page has fields for them.
        self.parameters.clear();
        if self.bonds.len() > MOST_LIVE_BONDS {
            self.bonds.clear();
        }
        if let Some(first) = self.about.first_mut() {
            let version = env!("CARGO_PKG_VERSION");
            *first = format!("Shown by relcp {version} while the run goes on. The page asks this program alone.");
        }
        self
    }
}

impl Packer {
    fn told(&self, quantity: Quantity) -> Told {
        let kind = match quantity {
            Quantity::Orientation => "cyclic",
            Quantity::Plain => "none",
            _ => "sequential",
        };
        let missing = self.scales.missing(quantity, self.headers.last());
        Told { name: quantity.name(), text: text_of(quantity), kind, scale: self.scales.of(quantity), missing }
    }

    /// The columns of the table.
    pub fn shared(&self) -> Block {
        self.table.block()
    }
}

/// Whether a scene has bonds or joints, or makes some.
fn is_bonded(scene: &Scene) -> bool {
    !bonds(scene).is_empty() || scene.growth.iter().any(|species| species.bond_daughters.is_some())
}

/// The bonds of a scene, of joints too.
fn bonds(scene: &Scene) -> Vec<([u64; 2], [[f64; 3]; 2])> {
    scene.bonds().ends()
}

/// What a quantity tells, in short.
fn text_of(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Orientation => "where its axis points",
        Quantity::Age => "time since its birth",
        Quantity::Generation => "divisions since its founder",
        Quantity::Length => "its longest extent",
        Quantity::Speed => "its centre's speed",
        Quantity::Contacts => "how many bodies it touches",
        Quantity::Overlap => "its deepest overlap with another body",
        Quantity::Force => "the sum of the contact forces on it, whatever their directions",
        Quantity::Pressure => "its contact pressure",
        Quantity::Group => "the number of its group in the scene, from 1; 0 without one",
        Quantity::Plain => "nothing",
    }
}

/// What the page says of itself.
fn about(chosen: &Chosen, viewed: &Viewed) -> Vec<String> {
    let Errors { centre, turn_degrees, length } = viewed.errors;
    let mut about = vec![
        format!(
            "Written by relcp {} from {} states. The page loads nothing from a network.",
            env!("CARGO_PKG_VERSION"),
            viewed.states
        ),
        "Rays meet the smooth surfaces themselves, as in the pictures of `relcp render`. Without perspective the projection is parallel: a length is the same everywhere.".into(),
        format!(
            "Centres are in steps of {:.3e}; the largest error along an axis is {centre:.3e}. Turns are off by at most {turn_degrees:.1e} degrees. \
             The turn of a body about an axis about which it is round is not kept.",
            chosen.grid.step
        ),
        "Values by which bodies are coloured, forces and separations are in 65,535 steps from the least to the largest of a state.".into(),
    ];
    if length > 0.0 {
        about.push(format!("Lengths of rods are off by at most {length:.1e}."));
    }
    about.extend(viewed.notes.iter().map(|note| format!("Note: {note}.")));
    about
}
