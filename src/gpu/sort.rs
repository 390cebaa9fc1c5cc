//! A stable sort of `u32` keys with `u32` values: radix sort by digits of 4 bits, the lowest first (N. Satish, M.
//! Harris, M. Garland, "Designing efficient sorting algorithms for manycore GPUs", 2009). The order is deterministic.

use super::{
    Buffer, Gpu, GpuError, Made, Precision, Recorder, Scan, Size, Source, WORKGROUP, fragment, functions, kernels,
};

/// Bits of a digit.
const DIGIT_BITS: u32 = 4;

/// Keys that one invocation sorts: as many as there are digits, so that counting per invocation costs as much as moving
/// keys.
const ITEMS: u32 = 16;

/// Keys of a block.
const BLOCK: u64 = WORKGROUP as u64 * ITEMS as u64;

functions! {
    Histogram = struct HistogramArgs<'a> {
        n: u64, blocks: u64, shift: u32, mask: u32, keys: &'a Buffer, counts: &'a Buffer,
    }
    Scatter = struct ScatterArgs<'a> {
        n: u64, blocks: u64, shift: u32, mask: u32, keys: &'a Buffer, values: &'a Buffer, starts: &'a Buffer,
        sorted_keys: &'a Buffer, sorted_values: &'a Buffer,
    }
}

kernels! {
    struct Kernels for _all: &() {
        histogram: Histogram = source("sort-histogram").include(fragment!("sort/histogram.wgsl")),
        scatter: Scatter =
            source("sort-scatter").include(fragment!("sort/sum_before.wgsl")).include(fragment!("sort/scatter.wgsl")),
    }
}

fn source(name: &str) -> Source {
    Source::new(name, Precision::F32).integer("ITEMS", ITEMS).integer("DIGITS", 1 << DIGIT_BITS)
}

/// A stable sort. It holds kernels and memory for reuse.
pub struct Sort {
    kernels: Kernels,
    scan: Scan,
    counts: Buffer,
    starts: Buffer,
    keys: Buffer,
    values: Buffer,
}

impl Sort {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError::Kernel`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let buffer = |label| Buffer::new(gpu, label, 4, 1);
        Ok(Sort {
            kernels: Kernels::make(gpu, &())?,
            scan: Scan::new(gpu)?,
            counts: buffer("sort-counts")?,
            starts: buffer("sort-starts")?,
            keys: buffer("sort-keys")?,
            values: buffer("sort-values")?,
        })
    }

    /// Records a sort of the first `n` keys and their values by the lowest `bits` bits of the keys. Keys with equal
    /// bits keep their order. The two buffers may be exchanged with internal buffers of at least the same size;
    /// elements after the first `n` are lost.
    ///
    /// # Errors
    /// [`GpuError::Limit`], [`GpuError::OutOfMemory`].
    pub fn by_key(
        &mut self,
        record: &mut Recorder<'_>,
        keys: &mut Buffer,
        values: &mut Buffer,
        n: u64,
        bits: u32,
    ) -> Result<(), GpuError> {
        debug_assert!(keys.element() == 4 && values.element() == 4, "a sort is of u32");
        debug_assert!(keys.capacity() >= n && values.capacity() >= n, "the buffers of a sort are too small");
        if n < 2 || bits == 0 {
            return Ok(());
        }
        let gpu = record.gpu();
        let blocks = n.div_ceil(BLOCK);
        let counts = blocks << DIGIT_BITS;
        self.counts.reserve(gpu, counts)?;
        self.starts.reserve(gpu, counts + 1)?;
        self.keys.reserve(gpu, n)?;
        self.values.reserve(gpu, n)?;
        for shift in (0..bits.min(32)).step_by(DIGIT_BITS as usize) {
            let mask = (1u32 << DIGIT_BITS.min(bits.min(32) - shift)) - 1;
            let counted = HistogramArgs { n, blocks, shift, mask, keys, counts: &self.counts };
            self.kernels.histogram.call(record, Size::Groups(blocks), counted);
            self.scan.exclusive(record, &self.counts, &self.starts, counts)?;
            let (starts, sorted_keys, sorted_values) = (&self.starts, &self.keys, &self.values);
            let sorted = ScatterArgs { n, blocks, shift, mask, keys, values, starts, sorted_keys, sorted_values };
            self.kernels.scatter.call(record, Size::Groups(blocks), sorted);
            std::mem::swap(keys, &mut self.keys);
            std::mem::swap(values, &mut self.values);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_valid() {
        for source in Kernels::sources(&()).iter().chain(&crate::gpu::scan::Kernels::sources(&())) {
            crate::gpu::validate(source).unwrap_or_else(|e| panic!("{}: {e}", source.name()));
        }
    }
}
