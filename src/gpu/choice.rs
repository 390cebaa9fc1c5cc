//! The requested adapter and the properties of each adapter.

/// The requested adapter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// A part of its name; case is ignored.
    pub name: Option<String>,
    /// Whether a software adapter is acceptable.
    pub software: bool,
    /// Requests only the limits that every adapter has, to test the smallest limits.
    pub default_limits: bool,
}

/// The [kind](AdapterReport::kind) of an adapter that is a program on the CPU.
pub(super) const SOFTWARE: &str = "software";

/// An adapter in the output of `relcp devices`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct AdapterReport {
    /// The adapter's name.
    pub name: String,
    /// Discrete, integrated, virtual, software or other.
    pub kind: &'static str,
    /// Vulkan, Metal or another interface.
    pub interface: String,
    /// The driver and its version.
    pub driver: String,
    /// Whether 64-bit floats work in kernels.
    pub f64: bool,
    /// Whether kernels can be timed.
    pub timestamps: bool,
    /// The largest buffer in bytes.
    pub max_buffer: u64,
    /// The largest binding in bytes.
    pub max_binding: u64,
    /// The number of storage buffers that a kernel may use.
    pub storage_buffers: u32,
    /// The number of invocations of a workgroup.
    pub workgroup: u32,
    /// The reasons why it cannot be used; empty if it can.
    pub lacks: Vec<String>,
    /// Whether this choice selects it: a software adapter only if it is acceptable and no hardware adapter fits.
    pub taken: bool,
}

impl AdapterReport {
    /// Whether the adapter is hardware.
    pub fn is_hardware(&self) -> bool {
        self.kind != SOFTWARE
    }
}
