//! LAMMPS' text dump, for its `read_dump`, OVITO, ASE and many scripts.
//!
//! One frame per state, with its time, and one line per body:
//!
//! | columns | what |
//! | --- | --- |
//! | `id` | the body's id, counted from 1 |
//! | `type` | 1 sphere, 2 spherocylinder, 3 ellipsoid, 4 torus, 6 superellipsoid |
//! | `x y z ix iy iz` | the centre, in the box, and the periods to add to it |
//! | `vx vy vz omegax omegay omegaz` | velocities |
//! | `quatw quati quatj quatk` | the rotation from the body's axes |
//! | `shapex shapey shapez` | the full extents along the body's axes, as for LAMMPS' ellipsoids |
//! | `d_size1 d_size2 d_size3` | the shape's sizes in the order of a scene |
//! | `i_parent d_birth i_generation i_group` | lineage and group; a parent is counted from 1 and 0 is none, a group -1 |
//! | `block1 block2` | only of runs with superellipsoids: their exponents `n1` and `n2` by the names of LAMMPS, 2 of others |
//!
//! Where a state has bonds, a second file, `NAME.bonds.lammpstrj`, has them as LAMMPS' `dump local` writes it, one line
//! per bond: its number in the scene from 1, the ids of its bodies in the dump, its type, 1, its length, its tension,
//! and the force on its second body, `nan` where that is not known. OVITO reads it by *Load trajectory*.
//!
//! The box of a sheared cell is triclinic, with the tilts xy, xz and yz, and bodies are in it.
//!
//! Numbers have all their digits. LAMMPS and OVITO draw types 2, 4 and 6 as ellipsoids of the same extents.

use super::text::{Space, write_frames};
use super::{ExportError, Exported};
use crate::bodies::{Bodies, NO_GROUP};
use crate::record::{Snapshot, States, Watch};
use glam::DQuat;
use std::io::{self, Write};
use std::path::Path;

/// The names of the columns.
const COLUMNS: &str = "id type x y z ix iy iz vx vy vz omegax omegay omegaz quatw quati quatj quatk shapex shapey shapez \
                       d_size1 d_size2 d_size3 i_parent d_birth i_generation i_group";

/// Half the height of a planar box; LAMMPS requires a height.
const HALF_HEIGHT: f64 = 0.5;

/// Writes the states as the LAMMPS dump `path`, atomically: see [the module](self).
///
/// # Errors
/// A state that cannot be read; a number that is not finite; a file that cannot be written.
///
/// ```
/// use relcp::export::lammps;
/// use relcp::record::States;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("two.lammpstrj");
/// lammps(&States::open("two-ellipsoids")?, &path, &mut |_, _| true)?;
/// assert!(std::fs::read_to_string(&path)?.contains("ITEM: NUMBER OF ATOMS\n2\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn lammps(states: &States, path: &Path, watch: Watch) -> Result<Exported, ExportError> {
    let mut done = write_frames(states, path, &mut *watch, frame)?;
    if any_bonds(states)? {
        let bonds = path.with_extension("bonds.lammpstrj");
        let of_bonds = write_frames(states, &bonds, watch, bond_frame)?;
        done.files.extend(of_bonds.files);
        done.bytes += of_bonds.bytes;
    }
    Ok(done)
}

/// Whether a state has bonds.
fn any_bonds(states: &States) -> Result<bool, ExportError> {
    for i in 0..states.len() {
        if !states.read(i)?.bodies.bonds.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

fn frame(out: &mut dyn Write, state: &Snapshot, space: &Space) -> io::Result<()> {
    let bodies = &state.bodies;
    head(out, state, space, ("ATOMS", bodies.len()))?;
    let more = if space.superellipsoids { " block1 block2" } else { "" };
    writeln!(out, "ITEM: ATOMS {COLUMNS}{more}")?;
    (0..bodies.len()).try_for_each(|k| line(out, bodies, k, space.superellipsoids))
}

/// The bonds of a state.
fn bond_frame(out: &mut dyn Write, state: &Snapshot, space: &Space) -> io::Result<()> {
    let bodies = &state.bodies;
    head(out, state, space, ("ENTRIES", bodies.bonds.len()))?;
    writeln!(out, "ITEM: ENTRIES index batom1 batom2 btype dist tension fx fy fz")?;
    for bond in &bodies.bonds {
        let [a, b] = bond.bodies.map(|body| bodies.lineage[body as usize].id + 1);
        let (way, [x, y, z]) = (bond.way(bodies).0.length(), bond.force.to_array());
        let tension = bond.tension(bodies);
        writeln!(out, "{} {a} {b} 1 {way:?} {tension:?} {x:?} {y:?} {z:?}", bond.number + 1)?;
    }
    Ok(())
}

/// The head of a frame: its time, the number of its entries, and its box.
fn head(out: &mut dyn Write, state: &Snapshot, space: &Space, (entries, count): (&str, usize)) -> io::Result<()> {
    let sign = |axis: usize| if space.periodic[axis] { "pp" } else { "ff" };
    let bounds = [sign(0), sign(1), if space.planar { "pp" } else { sign(2) }].join(" ");
    let tilted = if space.tilts.is_some() { "xy xz yz " } else { "" };
    writeln!(out, "ITEM: TIME\n{:?}\nITEM: TIMESTEP\n{}", state.time, state.step)?;
    writeln!(out, "ITEM: NUMBER OF {entries}\n{count}\nITEM: BOX BOUNDS {tilted}{bounds}")?;
    for (axis, side) in space.sides.to_array().into_iter().enumerate() {
        let half = if space.planar && axis == 2 { HALF_HEIGHT } else { 0.5 * side };
        match space.tilts {
            None => writeln!(out, "{:?} {half:?}", -half)?,
            Some(tilts) => {
                let [low, high] = bounds_of(half, tilts, axis);
                writeln!(out, "{low:?} {high:?} {:?}", tilts[axis])?;
            }
        }
    }
    Ok(())
}

/// The sides of the bounding box of a triclinic box with edges centred on the origin, as the format requires.
fn bounds_of(half: f64, [xy, xz, yz]: [f64; 3], axis: usize) -> [f64; 2] {
    let leanings: [f64; 2] = [[xy, xz], [yz, 0.0], [0.0; 2]][axis];
    let [least, most] = [f64::min, f64::max].map(|of| leanings.into_iter().map(|x| of(x, 0.0)).sum::<f64>());
    let low = -half - 0.5 * leanings.into_iter().sum::<f64>();
    [low + least, low + 2.0 * half + most]
}

fn line(out: &mut dyn Write, bodies: &Bodies, k: usize, with_exponents: bool) -> io::Result<()> {
    let (shape, lineage, q) = (&bodies.shape[k], &bodies.lineage[k], bodies.orientation[k]);
    let (position, image) = bodies.periods.wrapped_into_edges(bodies.position[k]);
    let (tag, sizes) = shape.code();
    write!(out, "{} {}", lineage.id + 1, tag + 1)?;
    position.to_array().iter().try_for_each(|x| write!(out, " {x:?}"))?;
    image.to_array().iter().try_for_each(|n| write!(out, " {n}"))?;
    let extents = 2.0 * shape.half_extents(DQuat::IDENTITY);
    let numbers = bodies.velocity[k].to_array().into_iter().chain(bodies.angular_velocity[k].to_array());
    let numbers = numbers.chain([q.w, q.x, q.y, q.z]).chain(extents.to_array()).chain(sizes);
    numbers.into_iter().try_for_each(|x| write!(out, " {x:?}"))?;
    let parent = lineage.parent.map_or(0, |parent| parent + 1);
    let group = if bodies.group[k] == NO_GROUP { -1 } else { i64::from(bodies.group[k]) };
    write!(out, " {parent} {:?} {} {group}", lineage.birth, lineage.generation)?;
    if with_exponents {
        let [n1, n2] = shape.exponents().unwrap_or(super::ELLIPSOID);
        write!(out, " {n1:?} {n2:?}")?;
    }
    writeln!(out)
}
