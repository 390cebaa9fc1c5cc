//! Extended XYZ, for OVITO, ASE and scripts.
//!
//! One frame per state: the number of bodies, a line of `key=value` with the box, its periodic axes, the time and the
//! names of the columns, then one line per body:
//!
//! | column | what |
//! | --- | --- |
//! | `species` | `X`, because ASE has no other name for a particle that is not an atom |
//! | `pos`, `velo` | the centre, in the box along periodic axes, and its velocity |
//! | `orientation` | the rotation from the body's axes, `x y z w` |
//! | `aspherical_shape` | for OVITO: semi-axes; radius, 0, cylinder length of a rod; zeros of a ring |
//! | `shape`, `size` | the shape's name and its sizes in the order of a scene |
//! | `omega` | the angular velocity |
//! | `id`, `parent`, `birth`, `generation`, `group` | lineage and group; -1 is none |
//! | `exponents` | only of runs with superellipsoids: their `n1` and `n2`, 2 of others |
//! | `superquadric_roundness` | only of these: `2 / n2` and `2 / n1`, OVITO's phi and theta |
//!
//! Numbers have all their digits. The box of a sheared cell is tilted, and bodies are in it.
//!
//! OVITO does not take the last column as its own property, and draws superellipsoids as ellipsoids until you choose
//! *Superquadric Roundness* for it among the columns of the file, or in a script:
//! `ComputePropertyModifier(output_property="Superquadric Roundness", expressions=["superquadric_roundness.1",
//! "superquadric_roundness.2"])`.

use super::gsd::aspherical;
use super::text::{Space, write_frames};
use super::{ExportError, Exported};
use crate::bodies::{Bodies, NO_GROUP};
use crate::record::{Snapshot, States, Watch};
use glam::DVec3;
use std::io::{self, Write};
use std::path::Path;

/// The names, types and widths of the columns.
const COLUMNS: &str = "species:S:1:pos:R:3:velo:R:3:orientation:R:4:aspherical_shape:R:3:shape:S:1:size:R:3:omega:R:3:\
                       id:I:1:parent:I:1:birth:R:1:generation:I:1:group:I:1";

/// The columns of runs with superellipsoids.
const EXPONENTS: &str = ":exponents:R:2:superquadric_roundness:R:2";
/// Writes the states as the extended XYZ file `path`, atomically: see [the module](self).
///
/// # Errors
/// A state that cannot be read; a number that is not finite; a file that cannot be written.
///
/// ```
/// use relcp::export::xyz;
/// use relcp::record::States;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("two.xyz");
/// xyz(&States::open("two-ellipsoids")?, &path, &mut |_, _| true)?;
/// assert!(std::fs::read_to_string(&path)?.starts_with("2\nLattice="));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn xyz(states: &States, path: &Path, watch: Watch) -> Result<Exported, ExportError> {
    write_frames(states, path, watch, frame)
}

fn frame(out: &mut dyn Write, state: &Snapshot, space: &Space) -> io::Result<()> {
    let bodies = &state.bodies;
    let [x, y, z] = space.sides.to_array();
    let corner = |edges: DVec3| (-0.5 * edges).to_array();
    let [px, py, pz] = space.periodic.map(|periodic| if periodic { 'T' } else { 'F' });
    writeln!(out, "{}", bodies.len())?;
    let [cx, cy, cz] = match space.tilts {
        None => {
            write!(out, "Lattice=\"{x:?} 0 0 0 {y:?} 0 0 0 {z:?}\" ")?;
            corner(space.sides)
        }
        Some([xy, xz, yz]) => {
            write!(out, "Lattice=\"{x:?} 0 0 {xy:?} {y:?} 0 {xz:?} {yz:?} {z:?}\" ")?;
            corner(space.sides + DVec3::new(xy + xz, yz, 0.0))
        }
    };
    write!(out, "Origin=\"{cx:?} {cy:?} {cz:?}\" pbc=\"{px} {py} {pz}\" ")?;
    let more = if space.superellipsoids { EXPONENTS } else { "" };
    writeln!(out, "Time={:?} Step={} Properties={COLUMNS}{more}", state.time, state.step)?;
    (0..bodies.len()).try_for_each(|k| line(out, bodies, k, space.superellipsoids))
}

fn line(out: &mut dyn Write, bodies: &Bodies, k: usize, with_exponents: bool) -> io::Result<()> {
    let (shape, lineage, q) = (&bodies.shape[k], &bodies.lineage[k], bodies.orientation[k]);
    let position = bodies.periods.wrapped_into_edges(bodies.position[k]).0;
    write!(out, "X")?;
    numbers(out, &position.to_array())?;
    numbers(out, &bodies.velocity[k].to_array())?;
    numbers(out, &[q.x, q.y, q.z, q.w])?;
    numbers(out, &aspherical(shape))?;
    write!(out, " {}", shape.name())?;
    numbers(out, &shape.code().1)?;
    numbers(out, &bodies.angular_velocity[k].to_array())?;
    let parent = lineage.parent.map_or(-1, |parent| parent as i64);
    let group = if bodies.group[k] == NO_GROUP { -1 } else { i64::from(bodies.group[k]) };
    write!(out, " {} {parent} {:?} {} {group}", lineage.id, lineage.birth, lineage.generation)?;
    if with_exponents {
        let [n1, n2] = shape.exponents().unwrap_or(super::ELLIPSOID);
        numbers(out, &[n1, n2, 2.0 / n2, 2.0 / n1])?;
    }
    writeln!(out)
}

fn numbers(out: &mut dyn Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|x| write!(out, " {x:?}"))
}
