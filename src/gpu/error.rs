//! The errors of a device and their remedies.

/// A fault of an adapter or a device.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The program was built without devices.
    #[error("built without the feature gpu; compute on the CPU")]
    NotBuilt,
    /// No adapter fits.
    #[error(
        "no usable adapter{wanted}; found: {found}. Install a Vulkan driver (a software one will do: Debian's mesa-vulkan-drivers), or compute on the CPU"
    )]
    NoAdapter {
        /// What was asked for, as ` named X`, or empty.
        wanted: String,
        /// What is there.
        found: String,
    },
    /// The adapter has no 64-bit floats.
    #[error("{adapter} has no 64-bit floats in shaders; use 32-bit floats, or compute on the CPU")]
    NoF64 {
        /// The adapter.
        adapter: String,
    },
    /// A limit of the adapter is too small.
    #[error(
        "{what} needs {needs} bytes and {adapter} allows {has} in one buffer; use a smaller scene, another adapter or the CPU"
    )]
    Limit {
        /// What does not fit.
        what: String,
        /// Bytes needed.
        needs: u64,
        /// Bytes allowed.
        has: u64,
        /// The adapter.
        adapter: String,
    },
    /// A kernel would need more bindings than the adapter has, because its buffers are larger than one binding may be.
    #[error(
        "the kernel {kernel} needs {needs} storage buffers at this size and {adapter} allows {has}; use a smaller scene, another adapter or the CPU"
    )]
    Bindings {
        /// The kernel.
        kernel: String,
        /// Bindings needed.
        needs: u32,
        /// Bindings allowed.
        has: u32,
        /// The adapter.
        adapter: String,
    },
    /// The device is out of memory.
    #[error("the device is out of memory ({what}); use a smaller scene, another adapter or the CPU")]
    OutOfMemory {
        /// What was being allocated.
        what: String,
    },
    /// The device is gone.
    #[error("the device was lost: {reason}. A run can be resumed from its last checkpoint")]
    Lost {
        /// What the driver says.
        reason: String,
    },
    /// The device did not answer.
    #[error("the device did not answer within {seconds} s; it may hang. A run can be resumed from its last checkpoint")]
    Hang {
        /// How long it was waited for.
        seconds: u64,
    },
    /// A kernel was refused.
    #[error("the kernel {kernel} was refused: {message}")]
    Kernel {
        /// Label of the kernel, as in a profile.
        kernel: String,
        /// Why.
        message: String,
    },
    /// The device computes wrongly.
    #[error("{adapter} failed the self-test {test}; update its driver, or compute on the CPU")]
    SelfTest {
        /// The adapter.
        adapter: String,
        /// Which test.
        test: &'static str,
    },
    /// Something that the GPU backend does not do.
    #[error("the GPU backend has no {what}; compute on the CPU")]
    Unsupported {
        /// What is missing.
        what: String,
    },
    /// The driver or wgpu refused something else.
    #[error("the device refused: {message}")]
    Refused {
        /// The whole message.
        message: String,
    },
}
