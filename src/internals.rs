//! The internals that this project's tests and benches use. They are not public: any release may change them.

/// What carries out the verbs of a step.
pub mod backend {
    pub use crate::backend::*;
}

/// Candidate pairs.
pub mod broad_phase {
    pub use crate::broad_phase::*;
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
    /// The rows of each body.
    pub mod incidence {
        pub use crate::lcp::incidence::*;
    }
    /// The problems of single pairs.
    pub mod pair_blocks {
        pub use crate::lcp::pair_blocks::*;
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

/// Separations on a device.
#[cfg(feature = "gpu")]
pub mod separation {
    /// Their kernels and numbers.
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
