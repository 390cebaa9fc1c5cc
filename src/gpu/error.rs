//! The errors of a device and their remedies.

/// A fault of an adapter or a device.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The program was built without the feature `gpu`.
    #[error("built without the feature gpu; compute on the CPU")]
    NotBuilt,
    /// No adapter fits.
    #[error(
        "no usable adapter{wanted}; found: {found}. Install a Vulkan driver (a software one will do: Debian's mesa-vulkan-drivers), or compute on the CPU"
    )]
    NoAdapter {
        /// The request, as ` named X`, or empty.
        wanted: String,
        /// The existing adapters.
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
        /// The object that does not fit.
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
        /// The object that was being allocated.
        what: String,
    },
    /// The device was lost.
    #[error("the device was lost: {reason}. A run can be resumed from its last checkpoint")]
    Lost {
        /// The reason given by the driver.
        reason: String,
    },
    /// The device did not answer.
    #[error("the device did not answer within {seconds} s; it may hang. A run can be resumed from its last checkpoint")]
    Hang {
        /// The length of the wait in seconds.
        seconds: u64,
    },
    /// A kernel was rejected.
    #[error("the kernel {kernel} was refused: {message}")]
    Kernel {
        /// Label of the kernel, as in a profile.
        kernel: String,
        /// The reason.
        message: String,
    },
    /// The device computes incorrectly.
    #[error("{adapter} failed the self-test {test}; update its driver, or compute on the CPU")]
    SelfTest {
        /// The adapter.
        adapter: String,
        /// The test that failed.
        test: &'static str,
    },
    /// A feature that the GPU backend does not support.
    #[error("the GPU backend has no {what}; compute on the CPU")]
    Unsupported {
        /// The missing feature.
        what: String,
    },
    /// The driver or wgpu reported another error.
    #[error("the device refused: {message}")]
    Refused {
        /// The whole message.
        message: String,
    },
}
