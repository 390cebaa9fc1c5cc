//! The kernels of a device, or of an ensemble, by their sources: each source is compiled once.

use super::kernel::Kernel;
use super::lock::lock;
use super::{GpuError, Source};
use std::collections::HashMap;
use std::sync::Mutex;

/// The largest number of unused kernels that are kept: those of four scenes (a colony has 54). The next scene often
/// uses most of them.
const MOST_IDLE: usize = 256;

/// Compiled kernels by the text of their sources.
#[derive(Default)]
pub(super) struct KernelCache(Mutex<HashMap<String, Kernel>>);

impl KernelCache {
    /// The kernel of a source; `make` compiles it if there is none yet.
    pub fn kernel(&self, source: &Source, make: impl FnOnce() -> Result<Kernel, GpuError>) -> Result<Kernel, GpuError> {
        let mut kernels = lock(&self.0);
        if let Some(kernel) = kernels.get(source.code()) {
            return Ok(kernel.clone());
        }
        if kernels.values().filter(|kernel| kernel.is_idle()).count() > MOST_IDLE {
            kernels.retain(|_, kernel| !kernel.is_idle());
        }
        let kernel = make()?;
        kernels.insert(source.code().to_owned(), kernel.clone());
        Ok(kernel)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_device::test_device;
    use super::super::{Kernel, Precision, Source};

    #[test]
    fn a_source_is_compiled_once() {
        let Some(gpu) = test_device() else { return };
        let text = "@group(0) @binding(0) var<storage, read_write> twice: array<u32>;\n\
                    @compute @workgroup_size(64) fn main() { twice[0] = 2u * twice[0]; }";
        let source = Source::new("compiled_once", Precision::F32).text(text);
        let kernels = [0, 1].map(|_| Kernel::new(gpu, &source).unwrap());
        let made = gpu.pipelines().iter().filter(|pipeline| pipeline.name == "compiled_once").count();
        assert_eq!((kernels.len(), made), (2, 1));
    }
}
