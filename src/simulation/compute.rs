//! The backend of the steps: the CPU or a device.

#[cfg(feature = "mpi")]
use super::Together;
use crate::backend::cpu::Cpu;
#[cfg(feature = "gpu")]
use crate::backend::cpu::hosted::is_hosted;
#[cfg(feature = "gpu")]
use crate::backend::gpu::{self as on_device, Device};
use crate::bodies::Bodies;
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::{Choice, Gpu, GpuError, Precision};
#[cfg(feature = "gpu")]
use crate::lcp;
use crate::scene::Scene;
#[cfg(feature = "gpu")]
use crate::separation::gpu::unsupported;
use crate::step::{Contact, Fault, State, Stepper, contacts};
use crate::walls::{WallContact, Walls};
use std::sync::Arc;

/// The backend of the steps.
#[derive(Clone, Default)]
#[non_exhaustive]
pub enum Compute {
    /// The CPU, in f64.
    #[default]
    Cpu,
    /// A device.
    Gpu {
        /// The device.
        gpu: Arc<Gpu>,
        /// The precision of its kernels.
        precision: Precision,
    },
    /// The CPUs of several processes, which share the work. The bits are those of [`Compute::Cpu`].
    #[cfg(feature = "mpi")]
    Together(Together),
}

impl Compute {
    /// The backend that steps a scene from a state.
    pub(super) fn backend(&self, scene: &Scene, state: State) -> Result<Box<dyn Stepper>, Fault> {
        let model = scene.model();
        Ok(match self {
            Compute::Cpu if scene.planar => Box::new(Cpu::<PLANAR>::new(&model, state)?),
            Compute::Cpu => Box::new(Cpu::<SPATIAL>::new(&model, state)?),
            #[cfg(feature = "mpi")]
            Compute::Together(together) => together.backend(scene, state, None)?,
            #[cfg(not(feature = "gpu"))]
            Compute::Gpu { gpu, .. } => match **gpu {},
            #[cfg(feature = "gpu")]
            Compute::Gpu { gpu, precision } => {
                let mut model = model;
                model.friction.elastic_slip = scene.elastic_slip_in(*precision);
                Box::new(Device::new(gpu.clone(), *precision, &model, state)?)
            }
        })
    }

    /// Whether several processes share the state.
    pub(super) fn is_shared(&self) -> bool {
        match self {
            Compute::Cpu | Compute::Gpu { .. } => false,
            #[cfg(feature = "mpi")]
            Compute::Together(_) => true,
        }
    }

    /// Checks that devices support a scene.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU supports; [`GpuError::NotBuilt`] without the feature `gpu`.
    #[cfg(feature = "gpu")]
    pub fn check(scene: &Scene) -> Result<(), GpuError> {
        if let Some(what) = unsupported(scene.all_shapes(), scene.planar) {
            return Err(GpuError::Unsupported { what });
        }
        let check = |scene: &Scene| {
            Device::check(&scene.model())?;
            lcp::gpu::Solver::check(scene.solver.kind)
        };
        #[cfg(feature = "files")]
        scene.changed_scenes().try_for_each(|scene| check(&scene))?;
        check(scene)
    }

    /// Checks that devices support a scene; without the feature there are none.
    ///
    /// # Errors
    /// [`GpuError::NotBuilt`], always.
    #[cfg(not(feature = "gpu"))]
    pub fn check(_scene: &Scene) -> Result<(), GpuError> {
        Err(GpuError::NotBuilt)
    }

    /// Whether a device leaves the solves of a scene to the CPU.
    #[cfg(feature = "gpu")]
    pub(super) fn host_solves(scene: &Scene) -> bool {
        is_hosted(&scene.model())
    }

    /// The same; without the feature there are no devices.
    #[cfg(not(feature = "gpu"))]
    pub(super) fn host_solves(_scene: &Scene) -> bool {
        true
    }

    /// Opens the first device that matches the choice, to compute a scene in a precision. A scene that devices do not
    /// support is refused first.
    ///
    /// # Errors
    /// A [`GpuError`]: no device matches, or it does not support the scene.
    pub fn open(choice: &Choice, precision: Precision, scene: &Scene) -> Result<Self, GpuError> {
        Compute::open_in(choice, Some(precision), scene)
    }

    /// [`Compute::open`], by default in the device's own precision, [`Gpu::default_precision`].
    ///
    /// # Errors
    /// As [`Compute::open`].
    pub fn open_in(choice: &Choice, precision: Option<Precision>, scene: &Scene) -> Result<Self, GpuError> {
        Compute::check(scene)?;
        let gpu = Arc::new(Gpu::open(choice)?);
        let precision = precision.unwrap_or_else(|| gpu.default_precision());
        gpu.check(precision)?;
        Ok(Compute::Gpu { gpu, precision })
    }

    /// Every pair of bodies whose separation is at most `cutoff`, as [`contacts`] lists them, computed by the CPU in
    /// f64, or by the device in its precision.
    ///
    /// ```
    /// # #[cfg(feature = "files")] {
    /// use relcp::{Scene, simulation::Compute};
    /// let bodies = Scene::built_in("three-capsules")?.build()?;
    /// assert_eq!(Compute::Cpu.contacts(&bodies, 0.0)?, relcp::contacts(&bodies, 0.0));
    /// # }
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] if the device does not support a shape, or a body is too far out.
    pub fn contacts(&self, bodies: &Bodies, cutoff: f64) -> Result<Vec<Contact>, GpuError> {
        match self {
            Compute::Cpu => Ok(contacts(bodies, cutoff)),
            #[cfg(feature = "mpi")]
            Compute::Together(_) => Ok(contacts(bodies, cutoff)),
            #[cfg(not(feature = "gpu"))]
            Compute::Gpu { gpu, .. } => match **gpu {},
            #[cfg(feature = "gpu")]
            Compute::Gpu { gpu, precision } => on_device::contacts(gpu, *precision, bodies, cutoff),
        }
    }

    /// Every body and surface of a wall whose separation is at most `cutoff`, as [`Walls::contacts`] lists them.
    ///
    /// # Errors
    /// As [`Compute::contacts`].
    pub fn wall_contacts(&self, bodies: &Bodies, walls: &Walls, cutoff: f64) -> Result<Vec<WallContact>, GpuError> {
        match self {
            Compute::Cpu => Ok(walls.contacts(bodies, cutoff)),
            #[cfg(feature = "mpi")]
            Compute::Together(_) => Ok(walls.contacts(bodies, cutoff)),
            #[cfg(not(feature = "gpu"))]
            Compute::Gpu { gpu, .. } => match **gpu {},
            #[cfg(feature = "gpu")]
            Compute::Gpu { gpu, precision } => on_device::wall_contacts(gpu, *precision, (bodies, walls), cutoff),
        }
    }
}

#[cfg(feature = "mpi")]
impl From<Together> for Compute {
    fn from(together: Together) -> Compute {
        Compute::Together(together)
    }
}
