//! `relcp view`: one HTML file that shows a run in a browser, with nothing loaded from a network.
//!
//! The page's own parts lie in `assets/view/`: what it looks like, its script, and the shaders, which cast rays against
//! the smooth surfaces as [`render`](mod@crate::render) does. Here the states are packed into it. A number that a
//! picture needs is a whole number of small steps, what changes between states is kept as differences, and [`Errors`]
//! tells what is lost:
//!
//! * `places`: centres, turns and lengths;
//! * `bodies`: what all states share of a body: its id, parent, birth, generation, group, shape and sizes;
//! * `bonds`: the bonds that hold;
//! * `values`: the colour quantity;
//! * `contacts`: contacts with their forces;
//! * `steps`: the run's `steps.csv` and `measures.csv`, thinned;
//! * `columns`: how numbers become bytes, and those the text in the page;
//! * `header`: the description of all these data; `page`: the file;
//! * `live`: the same of a run that goes on, state by state.
//!
//! A file holds no custom shape; in a state of one's own, such a body is drawn as the ellipsoid that reaches as far
//! along the body's axes.

mod bodies;
mod bonds;
mod columns;
mod contacts;
mod header;
mod live;
mod page;
mod places;
mod select;
mod steps;
mod values;

pub use live::{Live, Taken};
pub use places::Errors;

use crate::measure::{Frame, Settings, View, scene_behind};
use crate::record::{Snapshot, States, Watch, durable};
use crate::render::{Quantity, RenderError};
use crate::scene::Scene;
use crate::walls::Walls;
use bodies::Table;
use bonds::Bonds;
use columns::Block;
use contacts::Touching;
use header::{Header, StateHeader};
use places::{Grid, Places};
use rayon::prelude::*;
use select::Chosen;
use serde::Serialize;
use std::path::Path;
use steps::Tables;
use values::{Measured, Scales};

/// Which states a page has, and what it shows at first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pages {
    /// The initial colour quantity; none: one that shows something of these bodies.
    pub colour: Option<Quantity>,
    /// Every Nth state, from the first of the interval on.
    pub every: usize,
    /// The first time.
    pub from: f64,
    /// The last time.
    pub to: f64,
}

impl Default for Pages {
    fn default() -> Self {
        Pages { colour: None, every: 1, from: f64::NEG_INFINITY, to: f64::INFINITY }
    }
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Viewed {
    /// Size of the file.
    pub bytes: u64,
    /// States in it.
    pub states: usize,
    /// Bodies of the largest state.
    pub bodies: usize,
    /// How far what is shown is from what was recorded.
    pub errors: Errors,
    /// What its user should know.
    pub notes: Vec<String>,
}

/// A state, and what is computed of it before it is packed.
struct Prepared {
    state: Snapshot,
    measured: Measured,
    touching: Option<Touching>,
}

/// Writes the page of `states`, which were [opened](States::open) from `source`, as the file `path`, whole or not at
/// all.
///
/// ```
/// use relcp::record::States;
/// use relcp::view::{Pages, view};
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("view.html");
/// let viewed = view("three-capsules", &States::open("three-capsules")?, &Pages::default(), &path, &mut |_done, _all|
/// true)?;
/// assert!(viewed.states == 1 && viewed.bodies == 3 && path.is_file());
/// # Ok::<(), relcp::Error>(())
/// ```
///
/// # Errors
/// A [`RenderError`]: states that cannot be read or are not there, a file that cannot be written.
pub fn view(
    source: impl AsRef<Path>,
    states: &States,
    pages: &Pages,
    path: &Path,
    watch: Watch<'_>,
) -> Result<Viewed, RenderError> {
    let (page, viewed) = page_of_run(source, states, pages, watch)?;
    durable::write(path, &page)?;
    Ok(viewed)
}

/// The page of [`fn@view`] itself, in UTF-8.
///
/// # Errors
/// As [`fn@view`].
pub fn page_of_run(
    source: impl AsRef<Path>,
    states: &States,
    pages: &Pages,
    watch: Watch<'_>,
) -> Result<(Vec<u8>, Viewed), RenderError> {
    let source = source.as_ref();
    let frame = Frame::of(source, states)?;
    let scene = scene_behind(source)?.map(|(scene, _)| scene);
    let tables = Tables::read(source, pages);
    Joined { states, frame, scene: scene.as_ref(), tables, pages }.page(watch)
}

/// The page of one state of `scene`, in UTF-8, such as that of a simulation between two steps.
///
/// ```
/// use relcp::Scene;
/// use relcp::record::Snapshot;
/// use relcp::view::{Pages, page_of_state};
/// let scene = Scene::built_in("three-capsules")?;
/// let (bodies, removed, fields) = (scene.build()?, Vec::new(), Vec::new());
/// let state = Snapshot { step: 0, time: 0.0, bodies, warm: None, removed, fields };
/// let (page, viewed) = page_of_state(&scene, state, &Pages::default())?;
/// assert_eq!((page.len() as u64, viewed.states, viewed.bodies), (viewed.bytes, 1, 3));
/// # Ok::<(), relcp::Error>(())
/// ```
///
/// # Errors
/// A [`RenderError`].
pub fn page_of_state(scene: &Scene, state: Snapshot, pages: &Pages) -> Result<(Vec<u8>, Viewed), RenderError> {
    let states = States::single(&scene.name, state);
    let frame = Frame::of_scene(scene, scene.name.clone());
    Joined { states: &states, frame, scene: Some(scene), tables: Tables::default(), pages }.page(&mut |_, _| true)
}

/// What a page is made of.
struct Joined<'a> {
    states: &'a States,
    frame: Frame,
    scene: Option<&'a Scene>,
    tables: Tables,
    pages: &'a Pages,
}

impl Joined<'_> {
    fn page(self, watch: Watch<'_>) -> Result<(Vec<u8>, Viewed), RenderError> {
        let Joined { states, frame, scene, tables, pages } = self;
        let chosen = Chosen::of(states, pages, &mut *watch)?;
        let walls = scene.map_or_else(Walls::default, |scene| Walls::new(&scene.walls, frame.planar));
        let mut packer = Packer::new(&chosen);
        let mut notes = states.notes().to_vec();
        notes.extend(tables.notes.iter().cloned());
        for part in chosen.indices.chunks(rayon::current_num_threads().max(1)) {
            if !watch(packer.headers.len(), chosen.indices.len()) {
                return Err(RenderError::Stopped { done: packer.headers.len(), all: chosen.indices.len() });
            }
            let one = |&index: &usize| prepare(states, index, &frame, &walls, chosen.indices.len());
            for prepared in part.par_iter().map(one).collect::<Result<Vec<_>, RenderError>>()? {
                packer.add(prepared);
            }
            packer.pack();
        }
        watch(chosen.indices.len(), chosen.indices.len());
        notes.extend(packer.notes());
        let viewed =
            Viewed { bytes: 0, states: chosen.indices.len(), bodies: chosen.most, errors: packer.errors, notes };
        let header = Header::new(states.name(), pages, &frame, scene, &chosen, &packer, tables, &viewed);
        let bytes = page::joined(&header, &packer)?;
        let viewed = Viewed { bytes: bytes.len() as u64, ..viewed };
        Ok((bytes, viewed))
    }
}

/// Reads a state and computes the colour quantity and the contacts.
fn prepare(states: &States, index: usize, frame: &Frame, walls: &Walls, all: usize) -> Result<Prepared, RenderError> {
    let state = states.read(index)?.into_owned();
    Ok(Prepared::of(state, frame, walls, all, index + 1 == states.len()))
}

impl Prepared {
    /// One of `all` states, the last of them or not.
    fn of(state: Snapshot, frame: &Frame, walls: &Walls, all: usize, last: bool) -> Prepared {
        let settings = Settings::default();
        let seen = View::new(&state, frame, &settings);
        let measured = Measured::of(&seen);
        let touching = Touching::of(&seen, &walls.at(state.time).gone(&state.bodies.walls), all, last);
        drop(seen);
        Prepared { state, measured, touching }
    }
}

/// Packs states, one after the other.
struct Packer {
    grid: Grid,
    table: Table,
    places: Places,
    bonds: Bonds,
    scales: Scales,
    errors: Errors,
    headers: Vec<StateHeader>,
    waiting: Vec<Block>,
    packed: Vec<String>,
    custom: bool,
}

impl Packer {
    fn new(chosen: &Chosen) -> Packer {
        Packer {
            grid: chosen.grid,
            table: Table::default(),
            places: Places::default(),
            bonds: Bonds::default(),
            scales: Scales::default(),
            errors: Errors::default(),
            headers: Vec::new(),
            waiting: Vec::new(),
            packed: Vec::new(),
            custom: false,
        }
    }

    fn add(&mut self, Prepared { state, measured, touching }: Prepared) {
        let bodies = state.bodies.wrapped();
        let mut block = Block::default();
        let rows = self.table.rows(&bodies, &mut block);
        self.custom |= bodies.first_custom().is_some();
        let centres = self.places.centres(&bodies, &rows, &self.grid, &mut block, &mut self.errors);
        self.places.turns(&bodies, &rows, &mut block, &mut self.errors);
        let grown = self.table.grown(&bodies, &rows);
        let half_length = if grown { places::lengths(&bodies, &mut block, &mut self.errors) } else { None };
        let mut about = StateHeader::new(&state);
        about.ranges.extend(half_length.map(|range| ("half_length", range)));
        self.bonds.pack(&bodies, &mut block);
        measured.pack(&mut block, &mut about);
        self.scales.add(&state, &measured, &mut about);
        if let Some(touching) = touching {
            touching.pack(&state, &centres, &self.grid, &mut block, &mut about);
        }
        about.columns = block.layout();
        self.headers.push(about);
        self.waiting.push(block);
    }

    /// Compresses what was added since the last time.
    fn pack(&mut self) {
        let waiting = std::mem::take(&mut self.waiting);
        self.packed.par_extend(waiting.into_par_iter().map(|block| columns::text(block.bytes())));
    }

    fn notes(&self) -> Vec<String> {
        let without = self.headers.iter().filter(|state| state.contacts.is_none()).count();
        let contacts = (without > 0).then(|| {
            format!(
                "{without} of {} states have too many contacts for a page, so that it has none of these",
                self.headers.len()
            )
        });
        let custom = "custom shapes are drawn as ellipsoids that reach as far along the body's axes";
        contacts.into_iter().chain(self.custom.then(|| custom.into())).collect()
    }
}
