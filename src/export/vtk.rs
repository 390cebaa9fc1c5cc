//! ParaView: collections (`.pvd`, with the physical times) of VTK's `.vtp` files, one of each per state, in 64-bit
//! floats.
//!
//! | collection | points | data |
//! | --- | --- | --- |
//! | `bodies.pvd` | the centres | `orientation` (`[w, x, y, z]`, a "Quaternion" of 3D glyphs), `shape` (0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid), `size` (as a scene gives them), `glyph` (the axes of a sphere or an ellipsoid, by which a glyph of unit diameter is scaled; 0 for other shapes), `exponents` (of superellipsoids, if there are any; 0 for other shapes), `id`, `parent` (-1: none), `birth`, `generation`, `group` (-1: none), `velocity`, `angular_velocity` |
//! | `axes.pvd` | a line a rod or ring | `radius` (of the tube), `cap` (the diameter of the sphere that closes a rod's end; 0 on rings), `body` (its row), `shape`, `id`, `generation`, `birth` |
//! | `surfaces.pvd`, only of states with superellipsoids | the surface of each, 600 quadrilaterals | `Normals`, `body` (its row), `shape`, `id`, `generation`, `birth` |
//! | `contacts.pvd` | half-way between the surfaces | `separation`, `normal` (from `a` to `b`), `a` and `b` (rows), `gamma` (the force along the normal) and `force` (of `a` on `b`, with friction; both are not a number where they are not known: only a checkpoint and states recorded with `output.forces` know) |
//! | `field-NAME.pvd`, one for each field: the grid, as image data (`.vti`) | | `concentration` of each cell |
//! | `bonds.pvd`, only of states with bonds | a line a bond, from end to end | `number` (in the scene), `a` and `b` (rows), `tension`, `force` and `torque` (on `b`, about the bond's end there; not a number where they are not known), `bending_energy` |
//!
//! In periodic space centres are wrapped into the cell about the origin, and bodies have `image`, the numbers of
//! periods to add; a contact refers to `a` and to the image of `b` that it touches.
//!
//! With tubes around the axes, spheres at their ends, glyphs at the bodies and the surfaces, the shapes are exact up to
//! facets: the corners are on the true surface. [`SCRIPT`], which is written beside them, sets this up.

mod surfaces;

use self::surfaces::surfaces;
use super::Exported;
use super::error::ExportError;
use super::vtp::{Array, Cells, ImageData, Numbers, PolyData};
use crate::bodies::NO_GROUP;
use crate::fields::Concentration;
use crate::record::{RecordError, Snapshot, States, Watch, contacts, durable};
use crate::shape::{Centreline, Geometry, Shape};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

/// A ParaView script that shows an export: `paraview --script=show.py`, or `pvpython show.py --picture PNG`.
pub const SCRIPT: &str = include_str!("../../assets/paraview.py");
/// The text in [`SCRIPT`] that the export's folder replaces.
const FOLDER_MARK: &str = "FOLDER = None";
/// The script's name.
const SCRIPT_NAME: &str = "show.py";
/// The folder of the states' files.
const STATES: &str = "states";
/// The collections.
const COLLECTIONS: [&str; 5] = ["bodies", "axes", "contacts", "bonds", "surfaces"];
/// The number of those that all states have; the others are of states with bonds and with superellipsoids.
const ALWAYS: usize = 3;

/// Segments of a ring's axis. Its corners are on the circle, the middles of its segments are inside by `R (1 -
/// cos(pi/64))`: 0.12 %.
const RING_SEGMENTS: usize = 64;

/// Writes the states as collections for ParaView into `folder`: see [the module](self). Each file is written
/// atomically; the collections are written last, so that they name only existing files.
///
/// `cutoff` selects contacts: see [`contacts`].
///
/// # Errors
/// A state that cannot be read; a number that is not finite; a file that cannot be written.
///
/// ```
/// use relcp::export::vtk;
/// use relcp::record::States;
/// let folder = tempfile::tempdir()?;
/// let done = vtk(&States::open("two-ellipsoids")?, folder.path(), None, &mut |_, _| true)?;
/// assert_eq!(done.states, 1);
/// for name in ["bodies.pvd", "axes.pvd", "contacts.pvd", "show.py", "states/bodies_0000000000.vtp"] {
///     assert!(folder.path().join(name).exists(), "{name}");
/// }
/// # Ok::<(), relcp::Error>(())
/// ```
pub fn vtk(states: &States, folder: &Path, cutoff: Option<f64>, watch: Watch) -> Result<Exported, ExportError> {
    let inner = folder.join(STATES);
    fs::create_dir_all(&inner).map_err(RecordError::io(&inner, "create the folder"))?;
    let mut listed = [(); COLLECTIONS.len()].map(|()| Vec::new());
    let mut grids: BTreeMap<String, Vec<(u64, f64)>> = BTreeMap::new();
    let (mut most, mut bytes) = (0, 0);
    for i in 0..states.len() {
        if !watch(i, states.len()) {
            return Err(ExportError::Stopped { done: i, all: states.len() });
        }
        let state = states.read(i)?;
        finite(&state, || states.origin(i))?;
        state.refuse_custom(|| states.origin(i))?;
        let wrapped = state.wrapped();
        let held = (!state.bodies.bonds.is_empty()).then(|| bonds(&wrapped));
        let always = [bodies(&state), axes(&wrapped), touching(&wrapped, cutoff)].map(Some);
        let data = always.into_iter().chain([held, surfaces(&wrapped)]);
        for ((name, data), listed) in COLLECTIONS.into_iter().zip(data).zip(&mut listed) {
            let Some(data) = data else { continue };
            listed.push((state.step, state.time));
            let packed = data.into_bytes();
            bytes += packed.len() as u64;
            durable::place(&inner.join(file_name(name, state.step, "vtp")), &packed)?;
        }
        for field in &state.fields {
            let name = format!("field-{}", field.name);
            let packed = image(field, state.time).into_bytes();
            bytes += packed.len() as u64;
            durable::place(&inner.join(file_name(&name, state.step, "vti")), &packed)?;
            grids.entry(name).or_default().push((state.step, state.time));
        }
        most = most.max(state.bodies.len());
    }
    durable::sync_folder(&inner)?;
    let mut files = Vec::new();
    let collections = COLLECTIONS.into_iter().zip(&listed).enumerate();
    let written = collections.filter(|(k, (_, listed))| *k < ALWAYS || !listed.is_empty());
    for (name, text) in written
        .map(|(_, collection)| collection)
        .map(|(name, listed)| (format!("{name}.pvd"), collection(name, listed, "vtp")))
        .chain(grids.iter().map(|(name, listed)| (format!("{name}.pvd"), collection(name, listed, "vti"))))
        .chain([(SCRIPT_NAME.into(), script(folder))])
    {
        let path = folder.join(name);
        bytes += text.len() as u64;
        durable::write(&path, text.as_bytes())?;
        files.push(path);
    }
    watch(states.len(), states.len());
    Ok(Exported { files, states: states.len(), bodies: most, bytes, notes: states.notes().to_vec() })
}

fn file_name(name: &str, step: u64, kind: &str) -> String {
    format!("{name}_{step:010}.{kind}")
}

/// A field.
fn image(field: &Concentration, time: f64) -> ImageData {
    let grid = &field.grid;
    let corner = |axis: usize| grid.center[axis] - 0.5 * grid.spacing * f64::from(grid.cells[axis]);
    let cell_data = vec![Array::new("concentration", 1, Numbers::F64(field.values.clone()))];
    ImageData { cells: grid.cells, spacing: grid.spacing, origin: [0, 1, 2].map(corner), cell_data, time }
}

pub(super) fn finite(state: &Snapshot, origin: impl Fn() -> String) -> Result<(), ExportError> {
    let bodies = &state.bodies;
    for body in 0..bodies.len() {
        let quantities = [
            ("position", bodies.position[body].to_array()),
            ("velocity", bodies.velocity[body].to_array()),
            ("angular velocity", bodies.angular_velocity[body].to_array()),
        ];
        let turn = bodies.orientation[body].to_array().map(|x| ("orientation", x));
        let each = quantities.into_iter().flat_map(|(what, values)| values.map(|value| (what, value))).chain(turn);
        if let Some((what, value)) = each.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(ExportError::Unfit { origin: origin(), body, what, value, why: "is not finite" });
        }
    }
    Ok(())
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.to_array()).collect()
}

fn bodies(state: &Snapshot) -> PolyData {
    let bodies = &state.bodies;
    let lineage = || bodies.lineage.iter();
    let group = |group: &u32| if *group == NO_GROUP { -1 } else { *group as i32 };
    let mut point_data = vec![
        Array::rows("orientation", bodies.orientation.iter().map(|q| [q.w, q.x, q.y, q.z])),
        Array::new("shape", 1, Numbers::U8(bodies.shape.iter().map(|shape| shape.code().0 as u8).collect())),
        Array::rows("size", bodies.shape.iter().map(|shape| shape.code().1)),
        Array::rows("glyph", bodies.shape.iter().map(glyph)),
        Array::new("id", 1, Numbers::I64(lineage().map(|l| l.id as i64).collect())),
        Array::new("parent", 1, Numbers::I64(lineage().map(|l| l.parent.map_or(-1, |id| id as i64)).collect())),
        Array::rows("birth", lineage().map(|l| [l.birth])),
        Array::new("generation", 1, Numbers::U32(lineage().map(|l| l.generation).collect())),
        Array::new("group", 1, Numbers::I32(bodies.group.iter().map(group).collect())),
        Array::new("velocity", 3, Numbers::F64(flat(&bodies.velocity))),
        Array::new("angular_velocity", 3, Numbers::F64(flat(&bodies.angular_velocity))),
    ];
    if bodies.shape.iter().any(|shape| shape.exponents().is_some()) {
        let exponents = bodies.shape.iter().map(|shape| shape.exponents().unwrap_or_default());
        point_data.push(Array::rows("exponents", exponents));
    }
    if !bodies.periods.is_none() {
        let images = bodies.position.iter().flat_map(|x| bodies.periods.wrapped(*x).1.to_array());
        point_data.push(Array::new("image", 3, Numbers::I64(images.collect())));
    }
    PolyData {
        points: flat(&bodies.wrapped().position),
        vertices: Cells::each(bodies.len()),
        point_data,
        time: state.time,
        ..PolyData::default()
    }
}

/// The scale of a sphere of unit diameter that gives the body.
fn glyph(shape: &Shape) -> [f64; 3] {
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Point, radius } => [2.0 * radius; 3],
        Geometry::Ellipsoid { radii } => (2.0 * radii).to_array(),
        Geometry::Centreline { curve: Centreline::Segment { .. } | Centreline::Circle { .. }, .. }
        | Geometry::Convex(_) => [0.0; 3],
    }
}

/// The axes of rods and rings, with the data of their points.
#[derive(Default)]
struct Axes {
    points: Vec<DVec3>,
    /// The body of each point.
    body: Vec<u32>,
    radius: Vec<f64>,
    cap: Vec<f64>,
    vertices: Cells,
    lines: Cells,
    /// The body of each vertex, and of each line.
    bodies: [Vec<u32>; 2],
}

impl Axes {
    fn add(&mut self, body: usize, axis: impl Iterator<Item = DVec3>, radius: f64, cap: f64) {
        let first = self.points.len();
        self.points.extend(axis);
        let count = self.points.len() - first;
        let here = first..self.points.len();
        self.body.resize(here.end, body as u32);
        self.radius.resize(here.end, radius);
        self.cap.resize(here.end, cap);
        // A rod of zero length is a point: a line of zero length has no direction for a tube.
        if count == 1 {
            self.vertices.push(here);
            self.bodies[0].push(body as u32);
        } else {
            self.lines.push(here);
            self.bodies[1].push(body as u32);
        }
    }
}

fn axes(state: &Snapshot) -> PolyData {
    let bodies = &state.bodies;
    let mut axes = Axes::default();
    for i in 0..bodies.len() {
        let (at, turn) = (bodies.position[i], bodies.orientation[i]);
        match bodies.shape[i].geometry() {
            Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
                let along = turn * DVec3::Z * half;
                let ends = [at - along, at + along];
                let count = if ends[0] == ends[1] { 1 } else { 2 };
                axes.add(i, ends.into_iter().take(count), radius, 2.0 * radius);
            }
            Geometry::Centreline { curve: Centreline::Circle { radius: ring }, radius } => {
                let point = |k: i32| {
                    let (sin, cos) = (TAU * f64::from(k) / RING_SEGMENTS as f64).sin_cos();
                    at + turn * DVec3::new(ring * cos, ring * sin, 0.0)
                };
                // One additional segment at each end: a tube is cut at right angles to its first and last segment,
                // which are then inside it.
                axes.add(i, (-1..=RING_SEGMENTS as i32 + 1).map(point), radius, 0.0);
            }
            Geometry::Centreline { curve: Centreline::Point, .. }
            | Geometry::Ellipsoid { .. }
            | Geometry::Convex(_) => {}
        }
    }
    let lineage = |i: &u32| bodies.lineage[*i as usize];
    let point_data = vec![
        Array::new(
            "shape",
            1,
            Numbers::U8(axes.body.iter().map(|i| bodies.shape[*i as usize].code().0 as u8).collect()),
        ),
        Array::new("radius", 1, Numbers::F64(axes.radius)),
        Array::new("cap", 1, Numbers::F64(axes.cap)),
        Array::new("id", 1, Numbers::I64(axes.body.iter().map(|i| lineage(i).id as i64).collect())),
        Array::new("generation", 1, Numbers::U32(axes.body.iter().map(|i| lineage(i).generation).collect())),
        Array::rows("birth", axes.body.iter().map(|i| [lineage(i).birth])),
        Array::new("body", 1, Numbers::U32(axes.body)),
    ];
    let cell_data = vec![Array::new("axis_of", 1, Numbers::U32(axes.bodies.concat()))];
    let (points, vertices, lines) = (flat(&axes.points), axes.vertices, axes.lines);
    PolyData { points, vertices, lines, point_data, cell_data, time: state.time, ..PolyData::default() }
}

fn touching(state: &Snapshot, cutoff: Option<f64>) -> PolyData {
    let found = contacts(state, cutoff);
    let row = |which: usize| Numbers::U32(found.iter().map(|contact| contact.pair[which] as u32).collect());
    let point_data = vec![
        Array::rows("separation", found.iter().map(|contact| [contact.separation])),
        Array::rows("normal", found.iter().map(|contact| contact.normal.to_array())),
        Array::rows("gamma", found.iter().map(|contact| [contact.gamma])),
        Array::rows("force", found.iter().map(|contact| contact.force().to_array())),
        Array::new("a", 1, row(0)),
        Array::new("b", 1, row(1)),
    ];
    PolyData {
        points: found.iter().flat_map(|contact| contact.point.to_array()).collect(),
        vertices: Cells::each(found.len()),
        point_data,
        time: state.time,
        ..PolyData::default()
    }
}

fn bonds(state: &Snapshot) -> PolyData {
    let (all, bonds) = (&state.bodies, &state.bodies.bonds);
    let mut lines = Cells::default();
    let mut points = Vec::new();
    for (i, bond) in bonds.iter().enumerate() {
        let (way, from) = bond.way(all);
        points.extend([from, from + way]);
        lines.push(2 * i..2 * i + 2);
    }
    let row = |which: usize| Numbers::U32(bonds.iter().map(|bond| bond.bodies[which]).collect());
    let cell_data = vec![
        Array::new("number", 1, Numbers::U32(bonds.iter().map(|bond| bond.number).collect())),
        Array::new("a", 1, row(0)),
        Array::new("b", 1, row(1)),
        Array::rows("tension", bonds.iter().map(|bond| [bond.tension(all)])),
        Array::rows("force", bonds.iter().map(|bond| bond.force.to_array())),
        Array::rows("torque", bonds.iter().map(|bond| bond.torque.to_array())),
        Array::rows("bending_energy", bonds.iter().map(|bond| [bond.bending_energy])),
    ];
    PolyData { points: flat(&points), lines, cell_data, time: state.time, ..PolyData::default() }
}

/// A collection: the files of each state, with its time.
fn collection(name: &str, listed: &[(u64, f64)], kind: &str) -> String {
    let entries = listed.iter().map(|(step, time)| {
        format!("<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{STATES}/{}\"/>\n", file_name(name, *step, kind))
    });
    let entries: String = entries.collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n{entries}</Collection>\n</VTKFile>\n"
    )
}

/// The script with its folder, for versions of ParaView that do not provide it.
fn script(folder: &Path) -> String {
    let folder: PathBuf = folder.canonicalize().unwrap_or_else(|_| folder.into());
    // A JSON string is also a Python string.
    let text = serde_json::Value::from(folder.to_string_lossy()).to_string();
    SCRIPT.replacen(FOLDER_MARK, &format!("FOLDER = {text}"), 1)
}
