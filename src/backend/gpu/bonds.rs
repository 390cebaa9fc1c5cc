//! Bonds on the device. A kernel adds their loads to those of the host and to random loads; another one finds the bonds
//! that break. The host stores the bodies of each bond.

use super::Setup;
use super::source::{between, changing};
use super::start::Stages;
use super::states::Poses;
use crate::bodies::Lineage;
use crate::dynamics::{Bond, Incidence};
use crate::gpu::{Buffer, Gpu, GpuError, LatticePeriods, Made, Recorder, Source};
use crate::gpu::{arrays, fragment, functions, kernels};

functions! {
    pub(super) Pull = struct PullArgs<'a> {
        adds: bool, periods: LatticePeriods, stages: Stages<'a>, here: &'a Poses, own: &'a BondBuffers,
        loads: &'a Buffer,
    }
    pub(super) Snap = struct SnapArgs<'a> {
        bonds: usize, stages: Stages<'a>, at: &'a Poses, own: &'a BondBuffers,
    }
}

kernels! {
    /// The kernels of bonds.
    pub(super) struct BondKernels for setup: &Setup {
        pull: Pull = changing(setup, stretched(setup, "bonds").include(fragment!("dynamics/bonds.wgsl"))),
        /// Only if bonds can break.
        snap: Option<Snap> = setup.bonds.may_break()
            .then(|| changing(setup, stretched(setup, "breaking bonds").include(fragment!("dynamics/break.wgsl")))),
    }
}

/// A source with the extension of bonds.
fn stretched(setup: &Setup, name: &str) -> Source {
    between(setup, name).include(fragment!("dynamics/bond.wgsl"))
}

/// The strength of a bond that never breaks.
const NEVER: f64 = -1.0;

/// The bonds of a scene.
pub(super) struct BondBuffers {
    /// Two vectors per bond: the point on each body, with the stiffness and the length.
    bonds: Buffer,
    /// The tension at which each breaks, or [`NEVER`].
    strengths: Buffer,
    /// One word per bond: whether it is broken.
    broken: Buffer,
    /// The bodies of each bond.
    ends: Buffer,
    /// The bonds of each body.
    incident: Buffer,
    /// The contents of `ends` and `incident`.
    written: Incidence,
    kernels: BondKernels,
}

arrays! { BondBuffers { bonds, strengths, broken, ends, incident } }

impl BondBuffers {
    /// The buffers for a scene; `None` if it has no bonds.
    pub fn new(gpu: &Gpu, setup: &Setup, broken: &[u32]) -> Result<Option<Self>, GpuError> {
        if setup.bonds.is_empty() {
            return Ok(None);
        }
        let (list, precision) = (setup.bonds.list(), setup.precision);
        // The host has the pulls of implicit bonds, and finds those that break.
        let explicit = |bond: usize| !setup.bonds.is_implicit(bond);
        let numbers = |(bond, of): (usize, &Bond)| {
            let Bond { at: [[a, b, c], [d, e, f]], stiffness, length, .. } = of;
            [*a, *b, *c, if explicit(bond) { *stiffness } else { 0.0 }, *d, *e, *f, *length]
        };
        let strength = |(bond, of): (usize, &Bond)| of.break_force.filter(|_| explicit(bond)).unwrap_or(NEVER);
        let (real, count) = (precision.bytes(), list.len() as u64);
        let bonds = precision.encode(list.iter().enumerate().flat_map(numbers));
        let buffers = BondBuffers {
            bonds: Buffer::with(gpu, "bonds", 8 * real, &bonds)?,
            strengths: Buffer::with(
                gpu,
                "strengths of bonds",
                real,
                &precision.encode(list.iter().enumerate().map(strength)),
            )?,
            broken: Buffer::new(gpu, "broken bonds", 4, count)?,
            ends: Buffer::new(gpu, "bodies of bonds", 8, count)?,
            incident: Buffer::new(gpu, "bonds of bodies", 4, count)?,
            written: Incidence::default(),
            kernels: BondKernels::make(gpu, setup)?,
        };
        buffers.write_broken(gpu, setup, broken);
        Ok(Some(buffers))
    }

    /// Writes which bonds are broken.
    pub fn write_broken(&self, gpu: &Gpu, setup: &Setup, broken: &[u32]) {
        let is_broken = |bond: u32| u32::from(broken.binary_search(&bond).is_ok());
        let flags: Vec<u32> = (0..setup.bonds.list().len() as u32).map(is_broken).collect();
        self.broken.write(gpu, 0, bytemuck::cast_slice(&flags));
    }

    /// Marks more bonds as broken.
    pub fn add_broken(&self, gpu: &Gpu, found: &[u32]) {
        for bond in found {
            self.broken.write(gpu, 4 * u64::from(*bond), &1_u32.to_le_bytes());
        }
    }

    /// Reads which bonds are broken.
    pub fn read_broken(&self, gpu: &Gpu, setup: &Setup) -> Result<Vec<u32>, GpuError> {
        let bytes = 4 * setup.bonds.list().len() as u64;
        let read = gpu.record().read(&[(&self.broken, 0..bytes)])?;
        let flags: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
        Ok((0..).zip(flags).filter(|(_, broken)| *broken != 0).map(|(bond, _)| bond).collect())
    }

    /// Writes the bonds of each body and the bodies of each bond, if they have changed.
    pub fn write(&mut self, gpu: &Gpu, setup: &Setup, lineage: &[Lineage]) -> Result<(), GpuError> {
        // A bond that breaks on the device keeps its index; its flag disables it.
        let incidence = setup.bonds.incidence(lineage, &[]);
        if incidence != self.written {
            let incident = incidence.words();
            self.incident.reserve(gpu, incident.len() as u64)?;
            self.incident.write(gpu, 0, bytemuck::cast_slice(&incident));
            self.ends.write(gpu, 0, bytemuck::cast_slice(incidence.ends()));
            self.written = incidence;
        }
        Ok(())
    }

    /// Records the loads of bonds. With `adds`, they are added to existing loads.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>, loads: &Buffer, adds: bool) {
        let (periods, here) = (stages.start.periods_here, stages.here());
        self.kernels.pull.call(record, stages.start.bodies, PullArgs { adds, periods, stages, here, own: self, loads });
    }

    /// Records the test that breaks bonds with too much tension in the state `at`.
    pub fn record_breaking(&self, stages: Stages<'_>, record: &mut Recorder<'_>, at: &Poses) {
        let Some(snap) = &self.kernels.snap else { return };
        let bonds = stages.setup.bonds.list().len();
        snap.call(record, bonds as u64, SnapArgs { bonds, stages, at, own: self });
    }
}
