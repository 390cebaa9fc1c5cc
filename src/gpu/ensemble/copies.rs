//! The writes, copies and clears of members between two dispatches, as one dispatch. Recorded one by one, the twenty
//! such operations of a member's step took longer than all its other work except the solves.
//!
//! Operations of one member may depend on each other, so one workgroup executes them in order. Operations of different
//! members are independent.

use super::pipeline::{ALIGNMENT, part};
use super::tables::Tables;
use super::work::Work;
use crate::gpu::kernel::{pipeline, validate};
use crate::gpu::lock::lock;
use crate::gpu::{Gpu, GpuError, Precision, Source, fragment};
use std::sync::Mutex;

/// Kinds of pieces.
const WRITE: u32 = 0;
const COPY: u32 = 1;
const CLEAR: u32 = 2;

/// The largest piece that one workgroup copies. Longer pieces, of arrays that move to larger ranges, are recorded
/// separately.
const MOST_BYTES: u64 = 1 << 14;

/// Invocations of a workgroup: a piece has some hundred words.
const WORKGROUP: u32 = 64;
/// The same on a software adapter: one vector.
const WORKGROUP_ON_SOFTWARE: u32 = 8;

pub(super) fn source(workgroup: u32) -> Source {
    Source::with_workgroup("copies", Precision::F32, workgroup)
        .constants("kinds of pieces", [("WRITE", WRITE), ("COPY", COPY), ("CLEAR", CLEAR)])
        .include(fragment!("common/copies.wgsl"))
}

/// The kernel and its bindings.
pub(super) struct Copies {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    group: Mutex<Option<([u64; 3], wgpu::BindGroup)>>,
}

impl Copies {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError::Kernel`], or the fault that the device reported.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let source = source(if gpu.is_software() { WORKGROUP_ON_SOFTWARE } else { WORKGROUP });
        let module =
            validate(&source).map_err(|message| GpuError::Kernel { kernel: source.name().to_owned(), message })?;
        let entry = |binding, read_only, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset,
                min_binding_size: None,
            },
            count: None,
        };
        let entries = [entry(0, true, true), entry(1, true, false), entry(2, false, false)];
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(source.name()), entries: &entries };
        let (pipeline, layout) = gpu.scoped("copies", || {
            let layout = gpu.device.create_bind_group_layout(&descriptor);
            (pipeline(gpu, source.name(), module, &layout), layout)
        })?;
        Ok(Copies { pipeline, layout, group: Mutex::default() })
    }

    /// Records the copies of a number of members. The parameters at `offset` bytes have the start of the list.
    pub fn record(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::ComputePass<'static>,
        (arena, tables): ((&wgpu::Buffer, u64), &Tables),
        (offset, members): (u32, u32),
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group(gpu, arena, tables), &[offset]);
        pass.dispatch_workgroups(members, 1, 1);
    }

    fn group(&self, gpu: &Gpu, arena: (&wgpu::Buffer, u64), tables: &Tables) -> wgpu::BindGroup {
        let version = [arena.1, tables.parameters.version(), tables.pieces.version()];
        let mut known = lock(&self.group);
        if let Some((_, group)) = known.as_ref().filter(|(of, _)| *of == version) {
            return group.clone();
        }
        let places = part(0, tables.parameters.raw(), Some(ALIGNMENT as u64));
        let entries = [places, part(1, tables.pieces.raw(), None), part(2, arena.0, None)];
        let descriptor = wgpu::BindGroupDescriptor { label: Some("copies"), layout: &self.layout, entries: &entries };
        let group = gpu.device.create_bind_group(&descriptor);
        *known = Some((version, group.clone()));
        group
    }
}

/// Whether the kernel copies this piece.
pub(super) fn is_short(work: &Work) -> bool {
    let (place, bytes) = match work {
        Work::Write { to, bytes } => (*to, bytes.len() as u64),
        Work::Copy { from, to, bytes } => (*from | *to, *bytes),
        Work::Clear(range) => (range.start, range.end - range.start),
        Work::Leave(_) | Work::Dispatch(_) => return true,
    };
    bytes <= MOST_BYTES && place.is_multiple_of(4) && bytes.is_multiple_of(4)
}

/// Appends the pieces of members, sorted by member, to a list of words. Returns their start in it, and the number of
/// members with pieces.
pub(super) fn add(list: &mut Vec<u32>, pieces: &[(usize, &Work)]) -> (u32, u32) {
    let mut members: Vec<&[(usize, &Work)]> = pieces.chunk_by(|a, b| a.0 == b.0).collect();
    members.retain(|pieces| pieces.iter().any(|(_, work)| !matches!(work, Work::Leave(_))));
    let begin = list.len();
    list.resize(begin + 2 * members.len(), 0);
    for (nth, pieces) in members.iter().enumerate() {
        list[begin + 2 * nth] = list.len() as u32;
        let count = pieces.iter().filter(|(_, work)| !matches!(work, Work::Leave(_))).count();
        // The words to write follow the pieces.
        let mut words: u32 = (list.len() + 4 * count) as u32;
        for (_, work) in *pieces {
            match work {
                Work::Write { to, bytes } => {
                    let count = (bytes.len() / 4) as u32;
                    list.extend([WRITE, words, (*to / 4) as u32, count]);
                    words += count;
                }
                Work::Copy { from, to, bytes } => {
                    list.extend([COPY, (*from / 4) as u32, (*to / 4) as u32, (*bytes / 4) as u32]);
                }
                Work::Clear(range) => {
                    list.extend([CLEAR, 0, (range.start / 4) as u32, ((range.end - range.start) / 4) as u32]);
                }
                Work::Leave(_) | Work::Dispatch(_) => {}
            }
        }
        list[begin + 2 * nth + 1] = list.len() as u32;
        for (_, work) in *pieces {
            if let Work::Write { bytes, .. } = work {
                list.extend(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)));
            }
        }
    }
    (begin as u32, members.len() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_valid() {
        for workgroup in [WORKGROUP, WORKGROUP_ON_SOFTWARE] {
            validate(&source(workgroup)).unwrap_or_else(|e| panic!("{e}"));
        }
    }

    /// Applies a list on the host, as the kernel does.
    fn apply(list: &[u32], (begin, members): (u32, u32), arena: &mut [u32]) {
        for member in 0..members {
            let span = (begin + 2 * member) as usize;
            for piece in (list[span] as usize..list[span + 1] as usize).step_by(4) {
                let [kind, from, to, words] = [0, 1, 2, 3].map(|k| list[piece + k] as usize);
                for word in 0..words {
                    arena[to + word] = match kind as u32 {
                        WRITE => list[from + word],
                        COPY => arena[from + word],
                        _ => 0,
                    };
                }
            }
        }
    }

    #[test]
    fn pieces_of_a_member_follow_from_each_other() {
        let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let work = [
            (0, Work::Write { to: 0, bytes: bytes(&[7, 8]) }),
            (0, Work::Copy { from: 0, to: 16, bytes: 8 }),
            (0, Work::Clear(0..4)),
            (2, Work::Leave(0..4)),
            (3, Work::Leave(0..4)),
            (3, Work::Write { to: 40, bytes: bytes(&[9]) }),
        ];
        let pieces: Vec<_> = work.iter().map(|(member, work)| (*member, work)).collect();
        let mut list = vec![1, 2, 3];
        let at = add(&mut list, &pieces);
        assert_eq!(at, (3, 2));
        let mut arena = [5; 12];
        apply(&list, at, &mut arena);
        assert_eq!(arena, [0, 8, 5, 5, 7, 8, 5, 5, 5, 5, 9, 5]);
    }

    #[test]
    fn long_pieces_and_parts_of_words_are_not_for_the_kernel() {
        assert!(is_short(&Work::Clear(0..MOST_BYTES)) && !is_short(&Work::Clear(0..MOST_BYTES + 4)));
        assert!(!is_short(&Work::Write { to: 0, bytes: vec![0; 6] }) && !is_short(&Work::Clear(2..6)));
    }
}
