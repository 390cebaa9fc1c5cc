//! Prefix sums of `u32` counts: blocks are summed in workgroup memory, their totals likewise, level by level, and added
//! back (G. E. Blelloch, "Prefix sums and their applications", 1990).

use super::{Buffer, Gpu, GpuError, Made, Precision, Recorder, Size, Source, WORKGROUP, fragment, functions, kernels};

/// Entries that one invocation sums.
const ITEMS: u32 = 8;

/// Entries of a block.
const BLOCK: u64 = WORKGROUP as u64 * ITEMS as u64;

functions! {
    pub(super) Blocks = struct BlocksArgs<'a> {
        counted: u64, entries: u64, blocks: u64, counts: &'a Buffer, out: &'a Buffer, totals: &'a Buffer,
    }
    pub(super) Add = struct AddArgs<'a> { entries: u64, before: &'a Buffer, out: &'a Buffer }
}

kernels! {
    pub(super) struct Kernels for _all: &() {
        blocks: Blocks =
            source("scan").include(fragment!("sort/sum_before.wgsl")).include(fragment!("sort/scan.wgsl")),
        add: Add = source("scan-add").include(fragment!("sort/scan_add.wgsl")),
    }
}

fn source(name: &str) -> Source {
    Source::new(name, Precision::F32).integer("ITEMS", ITEMS)
}

/// Exclusive prefix sums. It holds kernels and memory for reuse.
pub struct Scan {
    kernels: Kernels,
    /// For each level: the totals of its blocks, and the sum before each block.
    levels: Vec<[Buffer; 2]>,
    /// The total of a level with one block.
    total: Buffer,
}

impl Scan {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError::Kernel`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Scan { kernels: Kernels::make(gpu, &())?, levels: Vec::new(), total: Buffer::new(gpu, "scan-total", 4, 1)? })
    }

    /// Records `out[i] = counts[0] + ... + counts[i - 1]` for `i` in `0..=n`: `out` needs room for `n + 1` numbers, and
    /// the last one is the sum of all. `counts` and `out` are different buffers. Sums are modulo 2^32.
    ///
    /// # Errors
    /// [`GpuError::Limit`], [`GpuError::OutOfMemory`].
    pub fn exclusive(
        &mut self,
        record: &mut Recorder<'_>,
        counts: &Buffer,
        out: &Buffer,
        n: u64,
    ) -> Result<(), GpuError> {
        debug_assert!(counts.capacity() >= n && out.capacity() > n, "the buffers of a scan are too small");
        // The entries of each level. The first level has one additional entry of zero, for the sum of all.
        let mut entries = vec![n + 1];
        while let Some(blocks) = entries.last().map(|n| n.div_ceil(BLOCK)).filter(|blocks| *blocks > 1) {
            entries.push(blocks);
        }
        self.reserve(record.gpu(), &entries[1..])?;
        for (level, &entries) in entries.iter().enumerate() {
            let (counts, out, counted) = match level {
                0 => (counts, out, n),
                _ => (&self.levels[level - 1][0], &self.levels[level - 1][1], entries),
            };
            let blocks = entries.div_ceil(BLOCK);
            let totals = if blocks > 1 { &self.levels[level][0] } else { &self.total };
            let summed = BlocksArgs { counted, entries, blocks, counts, out, totals };
            self.kernels.blocks.call(record, Size::Groups(blocks), summed);
        }
        for level in (0..entries.len() - 1).rev() {
            let out = if level == 0 { out } else { &self.levels[level - 1][1] };
            let (entries, before) = (entries[level], &self.levels[level][1]);
            self.kernels.add.call(record, entries, AddArgs { entries, before, out });
        }
        Ok(())
    }

    fn reserve(&mut self, gpu: &Gpu, blocks: &[u64]) -> Result<(), GpuError> {
        for (level, &blocks) in blocks.iter().enumerate() {
            if level == self.levels.len() {
                self.levels
                    .push([Buffer::new(gpu, "scan-totals", 4, blocks)?, Buffer::new(gpu, "scan-before", 4, blocks)?]);
            }
            for buffer in &mut self.levels[level] {
                buffer.reserve(gpu, blocks)?;
            }
        }
        Ok(())
    }
}
