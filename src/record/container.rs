//! State files: one versioned container format for states and checkpoints.
//!
//! A state is a zip that numpy opens as `.npz`, of these little-endian arrays with one row per body: `position` (N x
//! 3), `orientation` (N x 4, `[w, x, y, z]`), `velocity`, `angular_velocity` (N x 3), `shape` (tag: 0 sphere, 1
//! spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid), `size` (N x 3, the shape's sizes in the order of a scene),
//! `group` (2^32 - 1: none), `id`, `parent` (2^64 - 1: none), `birth`, `generation`, and `birth_length` if cells divide
//! by an added length. If there are superellipsoids, `exponents` (N x 2) has theirs, zero for others. Of bodies with
//! values of their own (version 4) there are `own_rate` and `own_division_length` (NaN: none), and `columns`, the named
//! columns one after the other in the order of the header's `columns`. If bonds are broken, `broken_bonds` has their
//! indices in the scene, ascending. Of the bonds and joints that hold there are `bond` (the number in the scene),
//! `bond_bodies` (B x 2, rows), `bond_at` (B x 6, the end on each body, body axes), `bond_length` (at rest),
//! `bond_energy` (of bends and turns), `bond_contact` (1 where its bodies collide), and with forces `bond_force` and
//! `bond_torque` (B x 3, on the second body, about its end).
//!
//! A checkpoint has `warm_pair`, `warm_feature`, `warm_gamma`, `warm_normal` as well, one row per near pair (and, where
//! contacts have friction, `warm_tangent`, the friction forces on the second bodies, N x 3: version 3), and the run's
//! totals in its header; a state has the former if the scene sets `output.forces`. A checkpoint of a device also has
//! `device_cells` (N x 3, signed integers in the bits of unsigned ones) and `device_numbers` (N x 20), from which this
//! device continues to the same bits ([`Unrounded`](crate::step::Unrounded)).
//!
//! `header` is the [`Header`], the bytes of its JSON text:
//! `json.loads(bytes(state["header"]))`.

use super::blocks::{
    blocks, has_friction, has_tangents, read_bodies, read_broken_bonds, read_columns, read_concentrations,
    read_unrounded, read_walls, read_warm, unrounded_blocks,
};
use super::durable;
use super::error::{RecordError, StateError};
use super::held::read_bonds;
use super::npz::{Archive, MAGIC, write};
use super::totals::Totals;
use crate::bodies::Bodies;
use crate::fields::{Concentration, Grid};
use crate::periodic::{Periods, Tilt};
use crate::scene::LARGEST_NUMBER;
use crate::step::State;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The name of the format, in a file's header.
pub const FORMAT: &str = "relcp-state";
/// The newest version that this program knows: that of states with fields, or whose bodies have values of their own. It
/// reads versions up to it. Version 1 had its header as `header.json`.
pub const VERSION: u64 = 4;
/// The version of other states with friction forces.
const WITH_FRICTION: u64 = 3;
/// The version of all others, which earlier programs read.
const PLAIN: u64 = 2;
/// The part of a period to which floats must resolve positions.
const LEAST_KNOWN: f64 = 0.1;
/// The smallest number of bytes of a body or a near pair, which limits the counts that a file may claim.
const LEAST_ROW: u64 = 8;
/// The same for a broken bond.
const LEAST_BOND: u64 = 4;
/// The same for a cell of a field.
const LEAST_VALUE: u64 = 8;

/// The header of a state file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`FORMAT`].
    pub format: String,
    /// Version of the format.
    pub version: u64,
    /// Version of the program that wrote it.
    pub program: String,
    /// [Hash](super::scene_hash) of its scene.
    pub scene: String,
    /// Steps taken.
    pub step: u64,
    /// Time after them.
    pub time: f64,
    /// The id of the next body to be born.
    pub next_id: u64,
    /// Rows of the arrays of bodies.
    pub bodies: u64,
    /// The periods of space along its axes; absent without periods.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periodic: Option<[Option<f64>; 3]>,
    /// The displacement of images across one axis along another, in a sheared cell; absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<Tilt>,
    /// Whether the bodies cannot leave the plane; absent if they can.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub planar: bool,
    /// Length of the array of broken bonds; absent without broken bonds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub broken_bonds: Option<u64>,
    /// Rows of the arrays of bonds that hold; absent without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bonds: Option<u64>,
    /// Rows of the array of walls under a load; absent without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walls: Option<u64>,
    /// Rows of the arrays of near pairs; absent in a state without contact forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warm: Option<u64>,
    /// The number of bodies that each rule of the scene's `removal` has removed; absent before the first removal.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<u64>,
    /// Whether bodies were placed, turned or lengthened since the last step; absent if not.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub changed: bool,
    /// The names of the columns that bodies have of their own, ascending; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// The fields, in the order of their names; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<FieldHeader>,
    /// The kind of a device's additional numbers; only in a checkpoint of a device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<[f64; 3]>,
    /// The totals of the run so far; only in a checkpoint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub totals: Option<Totals>,
}

/// A field of a state. Its concentrations are in the array `fields`, after those of the fields before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldHeader {
    /// The name of the field.
    pub name: String,
    /// Its grid.
    pub grid: Grid,
}

/// The bytes of a state of the scene with hash `scene`, at `time`. With `totals` it is a checkpoint.
///
/// # Errors
/// [`StateError::Custom`] if a body has a custom shape.
///
/// ```
/// use relcp::record::{decode, encode};
/// use relcp::step::State;
/// let bytes = encode(&State::default(), "0123456789abcdef", 0.0, None)?;
/// let (header, state) = decode(&bytes)?;
/// assert_eq!((header.step, state), (0, State::default()));
/// # Ok::<(), relcp::record::StateError>(())
/// ```
pub fn encode(state: &State, scene: &str, time: f64, totals: Option<&Totals>) -> Result<Vec<u8>, StateError> {
    pack(state, scene, time, totals.is_some(), totals)
}

/// As [`encode`], for a state that is not a checkpoint but has the contact forces.
///
/// # Errors
/// As [`encode`].
pub fn encode_with_forces(state: &State, scene: &str, time: f64) -> Result<Vec<u8>, StateError> {
    pack(state, scene, time, true, None)
}

fn pack(
    state: &State,
    scene: &str,
    time: f64,
    with_warm: bool,
    totals: Option<&Totals>,
) -> Result<Vec<u8>, StateError> {
    if let Some(body) = state.bodies.first_custom() {
        return Err(StateError::Custom { body });
    }
    let header = Header {
        format: FORMAT.into(),
        version: match (
            state.bodies.columns.is_empty() && state.fields.is_empty(),
            with_warm && has_friction(&state.warm),
        ) {
            (false, _) => VERSION,
            (true, true) => WITH_FRICTION,
            (true, false) => PLAIN,
        },
        program: env!("CARGO_PKG_VERSION").into(),
        scene: scene.into(),
        step: state.step,
        time,
        next_id: state.next_id,
        bodies: state.bodies.len() as u64,
        periodic: (!state.bodies.periods.is_none()).then(|| state.bodies.periods.lengths()),
        tilt: state.bodies.periods.tilt(),
        planar: state.bodies.planar,
        broken_bonds: Some(state.bodies.broken_bonds.len() as u64).filter(|broken| *broken > 0),
        bonds: Some(state.bodies.bonds.len() as u64).filter(|bonds| *bonds > 0),
        walls: Some(state.bodies.walls.len() as u64).filter(|walls| *walls > 0),
        warm: with_warm.then_some(state.warm.len() as u64),
        removed: state.removed.clone(),
        changed: state.changed,
        columns: state.bodies.columns.named().map(|(name, _)| name.to_owned()).collect(),
        fields: state.fields.iter().map(|of| FieldHeader { name: of.name.clone(), grid: of.grid }).collect(),
        device: if totals.is_some() { state.unrounded.as_ref().map(|unrounded| unrounded.kind) } else { None },
        totals: totals.cloned(),
    };
    let json = serde_json::to_vec_pretty(&header).map_err(|e| StateError::Unwritable(e.to_string()))?;
    let mut blocks = blocks(state, with_warm);
    if let (Some(unrounded), true) = (&state.unrounded, totals.is_some()) {
        blocks.extend(unrounded_blocks(unrounded));
    }
    write(&json, &blocks)
}

/// Reads the bytes of a state.
///
/// Refuses, with a reason, bytes that are not a state, damaged, truncated or of a newer format. Allocations are limited
/// by the file's size.
pub fn decode(bytes: &[u8]) -> Result<(Header, State), StateError> {
    let (mut archive, header) = Archive::open(bytes, accept)?;
    let warm = header.warm.unwrap_or(0);
    let broken = header.broken_bonds.unwrap_or(0);
    let bonds = header.bonds.unwrap_or(0);
    let walls = header.walls.unwrap_or(0);
    if header.bodies.max(warm).max(bonds).max(walls) > bytes.len() as u64 / LEAST_ROW {
        return Err(StateError::damaged("the header", "it claims more rows than the file can hold"));
    }
    let rows = header.bodies as usize;
    if broken > bytes.len() as u64 / LEAST_BOND {
        return Err(StateError::damaged("the header", "it claims more broken bonds than the file can hold"));
    }
    let mut bodies = read_bodies(&mut archive, rows)?;
    if broken > 0 {
        bodies.broken_bonds = read_broken_bonds(&mut archive, broken as usize)?;
    }
    if bonds > 0 {
        bodies.bonds = read_bonds(&mut archive, [bonds as usize, rows])?;
    }
    if walls > 0 {
        bodies.walls = read_walls(&mut archive, walls as usize)?;
    }
    if header.columns.windows(2).any(|names| names[0] >= names[1]) {
        return Err(StateError::damaged("the header", "the names of its columns do not ascend"));
    }
    if header.columns.len() as u64 > bytes.len() as u64 / header.bodies.saturating_mul(LEAST_ROW).max(1) {
        return Err(StateError::damaged("the header", "it claims more columns than the file can hold"));
    }
    bodies.columns = read_columns(&mut archive, rows, &header.columns)?;
    let periods = periods(&header, &bodies)?;
    let friction = match header.version {
        ..=PLAIN => false,
        WITH_FRICTION => true,
        _ => has_tangents(&archive),
    };
    let state = State {
        step: header.step,
        next_id: header.next_id,
        bodies: Bodies { periods, planar: header.planar, ..bodies },
        removed: header.removed.clone(),
        changed: header.changed,
        fields: read_fields(&mut archive, &header, bytes.len() as u64)?,
        warm: if warm > 0 { read_warm(&mut archive, [warm as usize, rows], friction)? } else { Vec::new() },
        unrounded: header.device.map(|kind| read_unrounded(&mut archive, kind, rows)).transpose()?,
    };
    Ok((header, state))
}

/// The fields of a state, whose header may claim anything.
fn read_fields(archive: &mut Archive, header: &Header, bytes: u64) -> Result<Vec<Concentration>, StateError> {
    if header.fields.is_empty() {
        return Ok(Vec::new());
    }
    let count = |of: &FieldHeader| of.grid.cells.iter().map(|count| u64::from(*count)).fold(1, u64::saturating_mul);
    let all = header.fields.iter().map(count).fold(0, u64::saturating_add);
    if all > bytes / LEAST_VALUE {
        return Err(StateError::damaged("the header", "it claims more cells of fields than the file can hold"));
    }
    let mut values = read_concentrations(archive, all as usize)?.into_iter();
    let field = |of: &FieldHeader| Concentration {
        name: of.name.clone(),
        grid: of.grid,
        values: values.by_ref().take(count(of) as usize).collect(),
    };
    Ok(header.fields.iter().map(field).collect())
}

/// The periods of a state's space. In every state that a run writes, bodies are at most half as long as the shortest
/// period, and near enough that floats distinguish images.
fn periods(header: &Header, bodies: &Bodies) -> Result<Periods, StateError> {
    let Some(lengths) = header.periodic else {
        return match header.tilt {
            None => Ok(Periods::NONE),
            Some(_) => Err(StateError::damaged("the header", "it has a tilt and no periods")),
        };
    };
    let untilted = Periods::new(lengths);
    let periods = header.tilt.map_or(untilted, |tilt| untilted.tilted(tilt));
    if periods.tilt() != header.tilt {
        return Err(StateError::damaged("the header", "its tilt is none that a sheared cell has"));
    }
    let longest = bodies.shape.iter().map(|shape| 2.0 * shape.bounding_radius()).fold(0.0, f64::max);
    let farthest = bodies.position.iter().map(|x| periods.farthest(*x)).fold(0.0, f64::max);
    let fits = |period: f64| {
        longest <= 0.5 * period && period <= LARGEST_NUMBER && farthest * f64::EPSILON <= LEAST_KNOWN * period
    };
    if periods.lengths() == lengths && periods.shortest().is_some_and(fits) {
        return Ok(periods);
    }
    Err(StateError::damaged("the header", "its periods are none, or too short for its bodies and their places"))
}

/// Reads a header, first its version, because newer versions may have other fields.
fn accept(json: &[u8]) -> Result<Header, StateError> {
    #[derive(Deserialize)]
    struct Kind {
        format: String,
        version: u64,
    }
    let kind: Kind = serde_json::from_slice(json).map_err(|_| StateError::NotAState)?;
    if kind.format != FORMAT {
        return Err(StateError::NotAState);
    }
    if kind.version > VERSION {
        return Err(StateError::Newer { found: kind.version, known: VERSION });
    }
    serde_json::from_slice(json).map_err(|e| StateError::damaged("the header", e))
}

/// Writes a state file atomically and durably: to a temporary file, synced, renamed, and the folder synced.
pub fn write_state(
    path: &Path,
    state: &State,
    scene: &str,
    time: f64,
    totals: Option<&Totals>,
) -> Result<(), RecordError> {
    durable::write(path, &encode(state, scene, time, totals).map_err(RecordError::state(path))?)
}

/// Reads a state file; of a file in another format, only the start.
pub fn read_state(path: &Path) -> Result<(Header, State), RecordError> {
    let fault = || RecordError::io(path, "read it");
    let mut file = File::open(path).map_err(fault())?;
    let mut bytes = Vec::new();
    file.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(fault())?;
    if bytes == MAGIC {
        file.read_to_end(&mut bytes).map_err(fault())?;
    }
    decode(&bytes).map_err(RecordError::state(path))
}
