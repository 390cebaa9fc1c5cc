//! The internals that this project's tests, benches and laboratory use. They are not public: any release may change
//! them.

/// What carries out the verbs of a step.
pub mod backend {
    pub use crate::backend::*;
}

/// Candidate pairs.
pub mod broad_phase {
    pub use crate::broad_phase::*;
}

/// Laws of motion, growth and division.
pub mod dynamics {
    pub use crate::dynamics::along::Root;
    pub use crate::dynamics::force::force_fields;
    pub use crate::dynamics::growth::{Cells, Species, grow, stretch};
    pub use crate::dynamics::law::law;
    pub use crate::dynamics::motion::{Ending, Factor, Law, Motion};
    pub use crate::dynamics::waiting::Waiting;
    pub use crate::motion::{Pose, Twist, advance};
}

/// The verbs that a backend carries out.
pub mod step {
    pub use crate::step::backend::{Keeper, Verbs};
    pub use crate::step::passing::passed;
}

/// What is derived from a scene.
pub mod scene {
    /// The thinnest starting body's thickness; infinite where there is no body.
    pub fn thinnest(scene: &crate::Scene) -> f64 {
        scene.thinnest()
    }
}

/// What figures are drawn with.
#[cfg(feature = "files")]
pub mod figure {
    pub use crate::figure::drawing::*;
    pub use crate::figure::head::{Head, Name};
}

/// What the programs have in common.
#[cfg(feature = "cli")]
pub mod program {
    pub use crate::program::*;
}

/// Pictures as files.
#[cfg(feature = "files")]
pub mod render {
    /// A picture as PNG.
    ///
    /// # Errors
    /// What goes wrong while it is packed.
    pub fn png(image: &crate::render::Image) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        image.encode(&mut bytes)?;
        Ok(bytes)
    }
}

/// The hash of files.
#[cfg(feature = "files")]
pub mod record {
    pub use crate::record::fnv::Fnv;
}

/// Rows.
pub mod constraint {
    pub use crate::constraint::*;
}

/// The unknowns of a body.
pub mod freedom {
    pub use crate::freedom::*;
}

/// The insides of the solvers.
pub mod lcp {
    /// The verbs of a solver as loops.
    pub mod cpu {
        pub use crate::lcp::cpu::*;
    }
    /// The verbs of a solver as a device's tape.
    #[cfg(feature = "gpu")]
    pub mod gpu {
        pub use crate::lcp::gpu::*;
    }
    /// The product with the matrix.
    pub mod product {
        pub use crate::lcp::product::*;
    }
    /// What a solver is written over.
    pub mod verbs {
        pub use crate::lcp::verbs::*;
    }
}

/// Simulations of states.
pub mod simulation {
    use crate::{Compute, Fault, Scene, Simulation, State};

    /// Steps a scene, which is not validated, from a state.
    ///
    /// # Errors
    /// A [`Fault`]: bodies that the scene's method or a device cannot do.
    pub fn start(compute: &Compute, scene: Scene, state: State) -> Result<Simulation, Fault> {
        Simulation::start(compute, scene, state)
    }
}

/// Walls.
pub mod walls {
    /// What a wall turns about, as the scene gives it.
    pub fn reference(wall: &crate::scene::Wall) -> glam::DVec3 {
        wall.reference()
    }
}

/// Branches of separations, surfaces of walls, separations on a device.
pub mod separation {
    pub use crate::separation::branches::branches;
    pub use crate::separation::planar::planar_separation;
    pub use crate::separation::surface::Surface;
    /// Their kernels and numbers.
    #[cfg(feature = "gpu")]
    pub mod gpu {
        pub use crate::separation::gpu::*;
    }
}

/// The runtime of devices.
#[cfg(feature = "gpu")]
pub mod gpu {
    pub use crate::gpu::buffer::*;
    pub use crate::gpu::kernel::*;
    pub use crate::gpu::lattice::*;
    pub use crate::gpu::periods::*;
    pub use crate::gpu::recorder::*;
    pub use crate::gpu::scan::*;
    pub use crate::gpu::sort::*;
    pub use crate::gpu::source::*;
}
