//! The requested adapter and the properties of each adapter.

/// Which adapter is wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// A part of its name, in any case of letters.
    pub name: Option<String>,
    /// Whether a software adapter will do.
    pub software: bool,
    /// Ask for no more than every adapter has, so that the smallest limits are tried.
    pub default_limits: bool,
}

/// The [kind](AdapterReport::kind) of an adapter that is a program on the CPU.
pub(super) const SOFTWARE: &str = "software";

/// One adapter, as `relcp devices` shows it.
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
    /// Largest buffer, bytes.
    pub max_buffer: u64,
    /// Largest binding, bytes.
    pub max_binding: u64,
    /// Storage buffers a kernel may use.
    pub storage_buffers: u32,
    /// Invocations of a workgroup.
    pub workgroup: u32,
    /// What keeps it from being used; empty where nothing does.
    pub lacks: Vec<String>,
    /// Whether it is taken where a device is asked for: software will do, hardware comes first.
    pub taken: bool,
}

impl AdapterReport {
    /// Whether it is not a program on the CPU.
    pub fn is_hardware(&self) -> bool {
        self.kind != SOFTWARE
    }
}
