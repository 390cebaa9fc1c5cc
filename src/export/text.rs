//! Shared by the text formats: all states in one file, with the same box in every frame.

use super::gsd::BOX_MARGIN;
use super::vtk::finite;
use super::{ExportError, Exported};
use crate::record::{RecordError, Snapshot, States, Watch, durable};
use glam::DVec3;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// The box of all frames, centred at the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// Its sides: the periods, and along the other axes the extent of all bodies of all states.
    pub sides: DVec3,
    /// The offsets xy, xz and yz of its edges, if the cell is sheared: then the edges are centred on the origin instead
    /// of the sides.
    pub tilts: Option<[f64; 3]>,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
    /// Whether the run is planar.
    pub planar: bool,
    /// Whether any state has superellipsoids, so that bodies have columns for their exponents.
    pub superellipsoids: bool,
}

/// Writes all states, which are read twice, as one text file, atomically. `frame` writes one state.
pub(super) fn write_frames(
    states: &States,
    path: &Path,
    watch: Watch,
    frame: impl Fn(&mut dyn Write, &Snapshot, &Space) -> io::Result<()>,
) -> Result<Exported, ExportError> {
    let all = states.len();
    let mut going = |read: usize, done: usize| match watch(read, 2 * all) {
        true => Ok(()),
        false => Err(ExportError::Stopped { done, all }),
    };
    let (mut half, mut most, mut superellipsoids) = (DVec3::ZERO, 0, false);
    let mut periods = crate::periodic::Periods::NONE;
    for i in 0..all {
        going(i, 0)?;
        let state = states.read(i)?;
        finite(&state, || states.origin(i))?;
        state.refuse_custom(|| states.origin(i))?;
        let bodies = state.bodies.wrapped();
        for (k, shape) in bodies.shape.iter().enumerate() {
            half = half.max(bodies.position[k].abs() + shape.half_extents(bodies.orientation[k]));
            superellipsoids |= shape.exponents().is_some();
        }
        (most, periods) = (most.max(bodies.len()), bodies.periods);
    }
    let periodic = periods.lengths().map(|length| length.is_some());
    let sides = DVec3::select(periods.length().cmpgt(DVec3::ZERO), periods.length(), 2.0 * BOX_MARGIN * half);
    let sides = sides.max(DVec3::splat(f64::MIN_POSITIVE));
    let space = Space { sides, tilts: None, periodic, planar: states.planar()?, superellipsoids };
    let fault = || RecordError::io(path, "write it");
    let bytes = durable::place_with(path, |part: &mut File| {
        let mut out = BufWriter::new(part);
        for i in 0..all {
            going(all + i, i)?;
            let state = states.read(i)?;
            // A cell may change its lengths.
            let length = state.bodies.periods.length();
            let sides = DVec3::select(length.cmpgt(DVec3::ZERO), length, space.sides);
            let tilts = state.bodies.periods.tilts();
            frame(&mut out, &state, &Space { sides, tilts, ..space }).map_err(fault())?;
        }
        let file = out.into_inner().map_err(|e| fault()(e.into_error()))?;
        Ok::<u64, ExportError>(file.metadata().map_err(fault())?.len())
    })?;
    durable::sync_folder(durable::folder_of(path))?;
    going(2 * all, all)?;
    Ok(Exported { files: vec![path.into()], states: all, bodies: most, bytes, notes: states.notes().to_vec() })
}
