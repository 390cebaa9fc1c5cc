//! GSD, the format of HOOMD-blue, which OVITO and the Python package `gsd` read: schema `hoomd` 1.4, one frame per
//! state.
//!
//! Positions, orientations and velocities are 32-bit floats, as in the schema. Shapes belong to types, which the first
//! frame defines for all frames. Data that the schema lacks is in `log/`:
//!
//! | chunk | rows | what |
//! | --- | --- | --- |
//! | `log/time` | 1 | the time |
//! | `log/particles/id`, `parent` | N, i64 | lineage; parent -1: none |
//! | `log/particles/birth`, `generation` | N | |
//! | `log/particles/group` | N, i32 | the scene's group; -1: none |
//! | `log/particles/size` | N x 3, f64 | a shape's exact sizes, in the order of a scene |
//! | `log/particles/exponents` | N x 2, f64 | exponents of superellipsoids, zero of other shapes; if there are any |
//! | `log/particles/angular_velocity` | N x 3 | |
//! | `log/particles/Aspherical Shape` | N x 3, f32 | shapes for OVITO, if the types are classes |
//!
//! Where a state has bonds, `bonds/N`, `bonds/typeid` (all of the type `bond`) and `bonds/group` (the two bodies) are
//! those that hold, and `log/bonds/force` (B x 3) is the force of each on its second body, where it is known.
//!
//! The box is centred on the origin, as the schema requires. Along a periodic axis its side is the period; positions
//! are wrapped into it, in a sheared cell into the tilted box, and `particles/image` (N x 3, i32) has the number of
//! periods to add. Along other axes it contains every body of every state, and has no other meaning (the schema's boxes
//! are periodic along all three axes).

use super::Exported;
use super::classes::{Classes, Survey};
use super::error::ExportError;
use super::file_layer::GsdFile;
use crate::bodies::NO_GROUP;
use crate::record::{RecordError, Snapshot, States, Watch, durable};
use crate::shape::{Centreline, Geometry, Shape};
use glam::DVec3;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

/// The name of the writing program in the file.
const APPLICATION: &str = concat!("relcp ", env!("CARGO_PKG_VERSION"));
/// The ratio of the box to the bodies' extent, so that no body touches the box after rounding to 32 bits.
pub(super) const BOX_MARGIN: f64 = 1.01;
/// Bytes that are buffered before they are written.
const BUFFER: usize = 1 << 20;

/// The data that all frames share.
struct Common {
    classes: Classes,
    /// Half the box.
    half: DVec3,
    bodies: usize,
    planar: bool,
    /// Whether any state has bonds.
    bonded: bool,
    /// Whether any state has superellipsoids.
    superellipsoids: bool,
}

/// Writes the states as the GSD file `path`, atomically.
///
/// All states are read twice, because types and box are the same in every frame. See [the module](self) for the layout.
///
/// ```
/// use relcp::export::gsd;
/// use relcp::record::States;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("capsules.gsd");
/// let done = gsd(&States::open("three-capsules")?, &path, &mut |_, _| true)?;
/// assert_eq!((done.states, done.bodies), (1, 3));
/// assert_eq!(std::fs::read(&path)?[..8], [0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65]);
/// # Ok::<(), relcp::Error>(())
/// ```
///
/// # Errors
/// A state that cannot be read; a number that is not finite, or too large for 32 bits; a file that cannot be written.
pub fn gsd(states: &States, path: &Path, watch: Watch) -> Result<Exported, ExportError> {
    let common = survey(states, watch)?;
    let fault = || RecordError::io(path, "write it");
    let bytes = durable::place_with(path, |part: &mut File| {
        let mut file = GsdFile::new(BufWriter::with_capacity(BUFFER, part)).map_err(fault())?;
        for i in 0..states.len() {
            watched(watch, states.len() + i, i, states.len())?;
            let state = states.read(i)?;
            frame(&mut file, &state, &common, i == 0).map_err(fault())?;
        }
        file.finish(APPLICATION, "hoomd", [1, 4]).map_err(fault()).map_err(ExportError::from)
    })?;
    durable::sync_folder(durable::folder_of(path))?;
    watch(2 * states.len(), 2 * states.len());
    let notes = states.notes().iter().cloned().chain(common.classes.notes()).collect();
    Ok(Exported { files: vec![path.into()], states: states.len(), bodies: common.bodies, bytes, notes })
}

/// Reports the number of finished reads, two per state; if stopped, the number of written states.
fn watched(watch: Watch, read: usize, done: usize, all: usize) -> Result<(), ExportError> {
    if watch(read, 2 * all) { Ok(()) } else { Err(ExportError::Stopped { done, all }) }
}

fn survey(states: &States, watch: Watch) -> Result<Common, ExportError> {
    let mut sizes = Survey::default();
    let (mut half, mut most, mut bonded, mut superellipsoids) = (DVec3::ZERO, 0, false, false);
    for i in 0..states.len() {
        watched(watch, i, 0, states.len())?;
        let state = states.read(i)?;
        state.refuse_custom(|| states.origin(i))?;
        let bodies = &state.bodies;
        most = most.max(bodies.len());
        bonded |= !bodies.bonds.is_empty();
        for k in 0..bodies.len() {
            fits(&state, k).map_err(|(what, value)| unfit(states.origin(i), k, what, value))?;
            let shape = &bodies.shape[k];
            sizes.add(shape);
            superellipsoids |= shape.exponents().is_some();
            let position = bodies.periods.wrapped(bodies.position[k]).0;
            half = half.max(position.abs() + shape.half_extents(bodies.orientation[k]));
        }
    }
    Ok(Common { classes: sizes.classes(), half, bodies: most, planar: states.planar()?, bonded, superellipsoids })
}

/// Checks that all numbers of a body fit into 32 bits, and that its lengths do not round to zero.
fn fits(state: &Snapshot, k: usize) -> Result<(), (&'static str, f64)> {
    let bodies = &state.bodies;
    let refuse = |what, value: f64| {
        // The box is larger than any position.
        if value.abs() <= f64::from(f32::MAX) / 4.0 { Ok(()) } else { Err((what, value)) }
    };
    bodies.position[k].to_array().into_iter().try_for_each(|x| refuse("position", x))?;
    let image = bodies.periods.wrapped_into_edges(bodies.position[k]).1;
    if let Some(far) = image.to_array().into_iter().find(|n| i32::try_from(*n).is_err()) {
        return Err(("image", far as f64));
    }
    bodies.orientation[k].to_array().into_iter().try_for_each(|x| refuse("orientation", x))?;
    bodies.velocity[k].to_array().into_iter().try_for_each(|x| refuse("velocity", x))?;
    let sizes = bodies.shape[k].code().1.into_iter().filter(|size| *size != 0.0);
    sizes.into_iter().try_for_each(|size| {
        refuse("size", size)?;
        if size >= f64::from(f32::MIN_POSITIVE) { Ok(()) } else { Err(("size", size)) }
    })
}

fn unfit(origin: String, body: usize, what: &'static str, value: f64) -> ExportError {
    let why = if value.is_finite() { "does not fit GSD's 32 bits" } else { "is not finite" };
    ExportError::Unfit { origin, body, what, value, why }
}

fn frame<W: io::Write + io::Seek>(
    file: &mut GsdFile<W>,
    state: &Snapshot,
    common: &Common,
    first: bool,
) -> io::Result<()> {
    let Snapshot { step, time, bodies, .. } = state;
    let classes = &common.classes;
    let length = bodies.periods.length();
    let sides = DVec3::select(length.cmpgt(DVec3::ZERO), length, common.half * 2.0 * BOX_MARGIN);
    // A planar box has zero height, which marks two dimensions in HOOMD.
    let sides = if common.planar { sides.with_z(0.0) } else { sides };
    let box_sides = sides.to_array().map(|x| x as f32);
    file.chunk("configuration/step", 1, [*step])?;
    if common.planar {
        file.chunk("configuration/dimensions", 1, [2_u8])?;
    }
    // The schema has the offsets divided by the side along the gradient.
    let [_, y, z] = sides.to_array();
    let leaning =
        |[xy, xz, yz]: [f64; 3]| [xy / y, if xz == 0.0 { 0.0 } else { xz / z }, if yz == 0.0 { 0.0 } else { yz / z }];
    let tilts = bodies.periods.tilts().map_or([0.0; 3], |tilts| leaning(tilts).map(|tilt| tilt as f32));
    file.chunk("configuration/box", 1, box_sides.into_iter().chain(tilts))?;
    file.chunk("particles/N", 1, [bodies.len() as u32])?;
    if common.bonded {
        bonds(file, state, first)?;
    }
    if first && classes.len() > 0 {
        table(file, "particles/types", &classes.names())?;
        table(file, "particles/type_shapes", &classes.shapes())?;
    }
    file.chunk("log/time", 1, [*time])?;
    if !bodies.is_empty() {
        let vectors = |vectors: &[DVec3]| -> Vec<f32> { vectors.iter().flat_map(|v| v.as_vec3().to_array()).collect() };
        file.chunk("particles/typeid", 1, bodies.shape.iter().map(|shape| classes.of(shape)))?;
        let placed = |x: &DVec3| bodies.periods.wrapped_into_edges(*x);
        file.chunk("particles/position", 3, vectors(&bodies.position.iter().map(|x| placed(x).0).collect::<Vec<_>>()))?;
        if !bodies.periods.is_none() {
            let images = bodies.position.iter().map(|x| placed(x).1.to_array());
            file.chunk("particles/image", 3, images.flatten().map(|n| n as i32))?;
        }
        let turns = bodies.orientation.iter().flat_map(|q| [q.w, q.x, q.y, q.z].map(|x| x as f32));
        file.chunk("particles/orientation", 4, turns)?;
        file.chunk("particles/velocity", 3, vectors(&bodies.velocity))?;
        log(file, state)?;
        if common.superellipsoids {
            let exponents = bodies.shape.iter().flat_map(|shape| shape.exponents().unwrap_or_default());
            file.chunk("log/particles/exponents", 2, exponents)?;
        }
        if !classes.exact() {
            // OVITO recognizes this name as its own property. It must have 32 bits.
            let sizes = bodies.shape.iter().flat_map(|shape| aspherical(shape).map(|x| x as f32));
            file.chunk("log/particles/Aspherical Shape", 3, sizes)?;
        }
    }
    file.end_frame();
    Ok(())
}

/// The bonds; the number also where there are none, since a frame without it has those of the first one.
fn bonds<W: io::Write + io::Seek>(file: &mut GsdFile<W>, state: &Snapshot, first: bool) -> io::Result<()> {
    let bonds = &state.bodies.bonds;
    file.chunk("bonds/N", 1, [bonds.len() as u32])?;
    if first {
        table(file, "bonds/types", &["bond".into()])?;
    }
    if bonds.is_empty() {
        return Ok(());
    }
    file.chunk("bonds/typeid", 1, bonds.iter().map(|_| 0_u32))?;
    file.chunk("bonds/group", 2, bonds.iter().flat_map(|bond| bond.bodies))?;
    if bonds.iter().all(|bond| bond.force.is_finite()) {
        file.chunk("log/bonds/force", 3, bonds.iter().flat_map(|bond| bond.force.to_array()))?;
    }
    Ok(())
}

fn log<W: io::Write + io::Seek>(file: &mut GsdFile<W>, state: &Snapshot) -> io::Result<()> {
    let bodies = &state.bodies;
    let lineage = || bodies.lineage.iter();
    let group = |group: &u32| if *group == NO_GROUP { -1 } else { *group as i32 };
    file.chunk("log/particles/id", 1, lineage().map(|l| l.id as i64))?;
    file.chunk("log/particles/parent", 1, lineage().map(|l| l.parent.map_or(-1, |parent| parent as i64)))?;
    file.chunk("log/particles/birth", 1, lineage().map(|l| l.birth))?;
    file.chunk("log/particles/generation", 1, lineage().map(|l| l.generation))?;
    file.chunk("log/particles/group", 1, bodies.group.iter().map(group))?;
    file.chunk("log/particles/size", 3, bodies.shape.iter().flat_map(|shape| shape.code().1))?;
    let turns = bodies.angular_velocity.iter().flat_map(|w| w.to_array());
    file.chunk("log/particles/angular_velocity", 3, turns)
}

/// The three numbers with which OVITO draws a body with its own size: semi-axes, or for a spherocylinder the radius,
/// zero and the length of its cylinder. OVITO does not use them for a body that has a mesh. A superellipsoid without a
/// mesh is drawn as the ellipsoid of the same semi-axes.
pub(super) fn aspherical(shape: &Shape) -> [f64; 3] {
    if shape.exponents().is_some() {
        return shape.code().1;
    }
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Point, radius } => [radius; 3],
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } => [radius, 0.0, 2.0 * half],
        Geometry::Ellipsoid { radii } => radii.to_array(),
        Geometry::Centreline { curve: Centreline::Circle { .. }, .. } | Geometry::Convex(_) => [0.0; 3],
    }
}

/// A chunk of strings, one per row, each padded with zeros to the same length.
fn table<W: io::Write + io::Seek>(file: &mut GsdFile<W>, name: &'static str, texts: &[String]) -> io::Result<()> {
    let width = texts.iter().map(String::len).max().unwrap_or(0) + 1;
    let padded = texts.iter().flat_map(|text| {
        let zeros = std::iter::repeat_n(0_u8, width - text.len());
        text.bytes().chain(zeros).map(|byte| byte as i8)
    });
    file.chunk(name, width, padded)
}
