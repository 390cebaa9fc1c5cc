//! The motion of bodies without contact in a part of a step: loads, free velocities, mobilities and boxes at the
//! beginning of the part.

use super::Setup;
use super::bonds::BondBuffers;
use super::heat::Ids;
use super::part::Part;
use super::source::{damping, dragged, motion, turned, with_bodies};
use super::start::{Stages, Start};
use super::states::{Poses, Shapes};
use crate::bodies::Bodies;
use crate::dynamics::{Ending, Factor, Force, ForceField, Load, Motion, Root, Twist, force_fields};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, arrays, fragment, functions, kernels};
use crate::step::{Fault, Model};
use glam::{DMat3, DVec3};

functions! {
    pub(super) FreeMotion = struct FreeMotionArgs<'a> {
        in_middle: bool, stages: Stages<'a>, here: &'a Poses, shapes: &'a Shapes,
        groups_of: &'a Buffer, motions: &'a Motions,
    }
    pub(super) MiddleMotion = struct MiddleMotionArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, shapes: &'a Shapes, motions: &'a Motions,
    }
    pub(super) BodyBoxes = struct BodyBoxesArgs<'a> {
        stages: Stages<'a>, first: &'a Poses, shapes: &'a Shapes, motions: &'a Motions,
    }
}

kernels! {
    /// The kernels of motions.
    pub(super) struct MotionKernels for setup: &Setup {
        motion: FreeMotion = motion(setup, setup.makes_loads()),
        boxes: BodyBoxes = with_bodies(setup, "box").include(fragment!("broad_phase/box.wgsl")),
        /// The motion over the step from its middle, with inertia.
        middle: Option<MiddleMotion> =
            (setup.midpoint && setup.inertia()).then(|| match damping(setup) {
                Some(source) => {
                    dragged::of_middle(setup, source("middle").include(fragment!("dynamics/damped_middle.wgsl")))
                }
                None => turned(setup, "middle").include(fragment!("dynamics/middle.wgsl")),
            }),
    }
}

/// The relative rounding error of a body's reach, in roundings, allowed in the comparison with half a period: the reach
/// is the sum of a radius, half the cutoff and two products, each rounded. An image other than the nearest may then be
/// near by as much, but it cannot overlap: scenes with bodies of that length are rejected when they are read.
const ROUNDINGS: f64 = 8.0;

/// The root of the rotational mobility in a motion, as `rotation_root` of `shaders/dynamics/factor.wgsl` applies it.
fn rotation_root(motion: &[f64]) -> DMat3 {
    match motion.get(16..24) {
        Some(root) => symmetric(root),
        _ => DMat3::from_diagonal(DVec3::splat(motion[7])),
    }
}

/// The root of the translational mobility in a motion, as `translation_root` of `shaders/dynamics/along.wgsl` applies
/// it where drag depends on the direction.
fn translation_root(setup: &Setup, motion: &[f64]) -> Root {
    match setup.has_axes_of_drag() {
        true => Root::Axes(symmetric(&motion[motion.len() - 8..])),
        false => Root::Even(motion[3]),
    }
}

/// A symmetric matrix of its first six numbers.
fn symmetric(numbers: &[f64]) -> DMat3 {
    match *numbers {
        [xx, xy, xz, yy, yz, zz, ..] => DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]),
        _ => DMat3::ZERO,
    }
}

/// Loads, free velocities and mobilities, by body.
pub(super) struct Motions {
    /// User-defined forces of the library, computed on the host.
    pub plugged: Vec<Box<dyn ForceField>>,
    /// The scene's pulls of single bodies, computed on the host too.
    pulls: Vec<Box<dyn ForceField>>,
    /// Whether the kernel of forces reads loads from the host and from other kernels.
    pub takes_loads: bool,
    pub loads: Buffer,
    pub motions: Buffer,
    /// The boxes of the bodies in the state where first rows are made.
    pub boxes: Buffer,
    /// The bodies' ids, in scenes with Brownian motion.
    pub ids: Option<Ids>,
    pub bonds: Option<BondBuffers>,
    kernels: MotionKernels,
}

arrays! { Motions { loads, motions, boxes } }

impl Motions {
    pub fn new(gpu: &Gpu, setup: &Setup, model: &Model, bodies: &Bodies) -> Result<Self, GpuError> {
        let pulls: Vec<Force> = model.forces.iter().filter(|force| force.is_pull()).cloned().collect();
        let (real, width) = (setup.precision.bytes(), setup.motion_width() as usize);
        Ok(Motions {
            plugged: Vec::new(),
            pulls: force_fields(&pulls, &model.groups, &model.dynamics),
            takes_loads: setup.makes_loads(),
            loads: Buffer::new(gpu, "loads", 8 * real, 1)?,
            motions: Buffer::new(gpu, "motions", 4 * width * real, bodies.len() as u64)?,
            boxes: Buffer::new(gpu, "boxes", 4 * real, bodies.len() as u64)?,
            ids: Ids::new(gpu, setup)?,
            bonds: BondBuffers::new(gpu, setup, &bodies.broken_bonds)?,
            kernels: MotionKernels::make(gpu, setup)?,
        })
    }

    /// Whether the host computes forces.
    pub fn has_plugged(&self) -> bool {
        !self.pulls.is_empty() || !self.plugged.is_empty()
    }

    /// From now on the kernel of forces reads loads.
    pub fn take_loads(&mut self, gpu: &Gpu, setup: &Setup) -> Result<(), GpuError> {
        if !std::mem::replace(&mut self.takes_loads, true) {
            self.kernels.motion = FreeMotion::make(gpu, motion(setup, true))?;
        }
        Ok(())
    }

    /// Writes user-defined forces, computed from the bodies at the beginning of the present part.
    pub fn write_loads(&mut self, gpu: &Gpu, setup: &Setup, start: &Start, bodies: &Bodies) -> Result<(), Fault> {
        let (time, span) = (start.time_of_loads(setup), start.span(setup));
        let acting = self.pulls.iter().chain(&self.plugged).map(|force| (force, force.share(span)));
        let acting: Vec<_> = acting.filter(|(_, share)| *share > 0.0).collect();
        for (force, _) in &acting {
            force.prepare(bodies, time).map_err(|what| Fault::Force { step: start.step, what })?;
        }
        let load = |i: usize| {
            let mut load = Load::default();
            for (force, share) in &acting {
                load += *share * force.load(bodies, i, time);
            }
            let (f, t) = (load.force, load.torque);
            [f.x, f.y, f.z, 0.0, t.x, t.y, t.z, 0.0]
        };
        let loads: Vec<f64> = (0..bodies.len()).flat_map(load).collect();
        self.loads.reserve(gpu, start.bodies)?;
        self.loads.write(gpu, 0, &setup.precision.encode(loads));
        Ok(())
    }

    /// Reserves memory for the bodies of the step, and writes their ids and bonds.
    pub fn write(&mut self, gpu: &Gpu, setup: &Setup, start: &Start) -> Result<(), GpuError> {
        if let Some(ids) = &mut self.ids {
            self.loads.reserve(gpu, start.bodies)?;
            ids.write(gpu, &start.ancestry.lineage)?;
        }
        if let Some(bonds) = &mut self.bonds {
            self.loads.reserve(gpu, start.bodies)?;
            bonds.write(gpu, setup, &start.ancestry.lineage)?;
        }
        Ok(())
    }

    /// Reserves memory for the motions of the bodies of the step.
    pub fn reserve(&mut self, gpu: &Gpu, bodies: u64) -> Result<(), GpuError> {
        self.motions.reserve(gpu, bodies)?;
        self.boxes.reserve(gpu, bodies)?;
        Ok(())
    }

    /// Records forces, free velocities and mobilities at the beginning of the present part.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>) {
        let start = stages.start;
        let (bodies, in_middle) = (start.bodies, start.part == Part::FromMiddle);
        let plugged = self.has_plugged();
        if let Some(ids) = &self.ids {
            ids.record(stages, record, &self.loads, plugged);
        }
        if let Some(bonds) = &self.bonds {
            bonds.record(stages, record, &self.loads, self.ids.is_some() || plugged);
        }
        let (here, shapes, groups_of, motions) = (stages.here(), stages.here_shapes(), &start.groups_of, self);
        let propelled = FreeMotionArgs { in_middle, stages, here, shapes, groups_of, motions };
        self.kernels.motion.call(record, bodies, propelled);
        if let (true, Some(middle)) = (in_middle, &self.kernels.middle) {
            let start = stages.states.start();
            middle.call(record, bodies, MiddleMotionArgs { stages, start, shapes, motions });
        }
        if let Some(held) = &start.held {
            held.hold(record, &self.motions);
        }
    }

    /// Records the boxes of the bodies in the poses `first`, where first rows are made.
    pub fn record_boxes(&self, stages: Stages<'_>, record: &mut Recorder<'_>, first: &Poses) {
        let (shapes, motions) = (stages.here_shapes(), self);
        self.kernels.boxes.call(record, stages.start.bodies, BodyBoxesArgs { stages, first, shapes, motions });
    }

    /// Rejects bodies whose reach or free motion in this step is too large for the shortest period, so that images
    /// other than the nearest could come near. The fourth number of a box is the radius, plus half the cutoff, plus the
    /// distance moved; `largest` is the largest of them.
    pub fn check_periods(&self, Stages { gpu, setup, start, .. }: Stages<'_>, largest: f32) -> Result<(), Fault> {
        let Some(period) = start.periods.shortest() else { return Ok(()) };
        let precision = setup.precision;
        let most = 0.5 * period * (1.0 + ROUNDINGS * precision.epsilon());
        // The report has 32 bits.
        let largest = f64::from(largest) * (1.0 + f64::from(f32::EPSILON));
        if 2.0 * largest <= most {
            return Ok(());
        }
        let bytes = start.bodies * self.boxes.element() as u64;
        let read = gpu.record().read(&[(&self.boxes, 0..bytes)])?;
        let boxes = precision.decode(&read[0]);
        let spans = boxes.as_chunks::<4>().0.iter().map(|[_, _, _, radius]| 2.0 * radius);
        match spans.enumerate().find(|(_, span)| *span > most) {
            Some((body, span)) => Err(Fault::PeriodTooShort { step: start.step, body, span, period }),
            None => Ok(()),
        }
    }

    /// Free velocities and mobilities.
    pub fn read(&self, Stages { gpu, setup, start, .. }: Stages<'_>) -> Result<Vec<Motion>, GpuError> {
        let bytes = start.bodies * self.motions.element() as u64;
        let read = gpu.record().read(&[(&self.motions, 0..bytes)])?;
        let numbers = setup.precision.decode(&read[0]);
        let width = 4 * setup.motion_width() as usize;
        let motion = |of: &[f64]| Motion {
            free: Twist { linear: DVec3::from_slice(of), angular: DVec3::from_slice(&of[4..]) },
            factor: Factor { translation: translation_root(setup, of), rotation: rotation_root(of) },
            ending: Ending::default(),
        };
        Ok(numbers.chunks_exact(width).map(motion).collect())
    }

    /// The velocities from the start to the trial.
    pub fn trial_twists(&self, Stages { gpu, setup, start, .. }: Stages<'_>) -> Result<Vec<Twist>, GpuError> {
        let bytes = start.bodies * self.motions.element() as u64;
        let read = gpu.record().read(&[(&self.motions, 0..bytes)])?;
        let numbers = setup.precision.decode(&read[0]);
        let width = 4 * setup.motion_width() as usize;
        let twist = |motion: &[f64]| Twist {
            linear: DVec3::new(motion[8], motion[9], motion[10]),
            angular: DVec3::new(motion[12], motion[13], motion[14]),
        };
        Ok(numbers.chunks_exact(width).map(twist).collect())
    }
}
