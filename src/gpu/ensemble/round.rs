//! A round: the work of several members, recorded together and submitted at once, with one read-back for all of them.

use super::arena::Arena;
use super::copies::{self, Copies};
use super::order::{Together, ordered};
use super::pipeline::{ALIGNMENT, MOST_TOGETHER, Pipeline};
use super::tables::Tables;
use super::work::{Dispatch, Request, Work};
use crate::gpu::pending::INVOCATIONS;
use crate::gpu::{Gpu, GpuError};
use std::ops::Range;
use std::sync::Arc;

/// The tables of an ensemble, and the kernel of its short copies.
pub(super) struct Buffers {
    tables: Tables,
    copies: Copies,
}

impl Buffers {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Buffers { tables: Tables::new(gpu)?, copies: Copies::new(gpu)? })
    }
}

/// An operation of the round, recorded after all tables are filled.
enum Action {
    Dispatch {
        pipeline: Arc<Pipeline>,
        offsets: [u32; 2],
        grid: [u32; 3],
        invocations: u64,
    },
    /// The parameters at `offset` bytes have the start of the list.
    Pieces {
        offset: u32,
        members: u32,
    },
    Write {
        from: u64,
        to: u64,
        bytes: u64,
    },
    Copy {
        from: u64,
        to: u64,
        bytes: u64,
    },
    Clear(Range<u64>),
}

/// The contents of the tables, and the operations.
#[derive(Default)]
struct Recording {
    rows: Vec<u8>,
    parameters: Vec<u8>,
    upload: Vec<u8>,
    pieces: Vec<u32>,
    actions: Vec<Action>,
    left: Vec<Range<u64>>,
    /// The length of the longest copy.
    scratch: u64,
    /// The ends of the ranges of both tables that a dispatch binds.
    bound: [u64; 2],
    dispatches: u64,
}

/// The statistics of a round.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Done {
    /// Dispatches made; `asked` is the number that members requested.
    pub dispatches: u64,
    pub asked: u64,
}

/// The bytes read by each request.
pub(super) type Answers = Vec<Vec<Vec<u8>>>;

/// Executes the work of all requests, and reads the bytes that they request.
///
/// # Errors
/// The fault of the device, which concerns all requests.
pub(super) fn run(
    gpu: &Gpu,
    arena: &std::sync::Mutex<Arena>,
    Buffers { tables, copies }: &mut Buffers,
    requests: Vec<Request>,
) -> Result<(Answers, Done), GpuError> {
    let (lists, reads): (Vec<_>, Vec<_>) = requests.into_iter().map(|request| (request.work, request.read)).unzip();
    let mut recording = Recording::default();
    let asked = lists.iter().flatten().filter(|work| work.kernel().is_some()).count() as u64;
    for together in ordered(&lists, Work::kernel, MOST_TOGETHER) {
        recording.add(&lists, &together);
    }
    let total: u64 = reads.iter().flatten().map(size).sum();
    tables.rows.reserve(gpu, recording.bound[0])?;
    tables.parameters.reserve(gpu, recording.bound[1])?;
    tables.upload.reserve(gpu, recording.upload.len() as u64)?;
    tables.pieces.reserve(gpu, 4 * recording.pieces.len() as u64)?;
    tables.scratch.reserve(gpu, recording.scratch)?;
    tables.staging.reserve(gpu, total)?;
    for (table, bytes) in [
        (&tables.rows, recording.rows.as_slice()),
        (&tables.parameters, recording.parameters.as_slice()),
        (&tables.upload, recording.upload.as_slice()),
        (&tables.pieces, bytemuck::cast_slice(&recording.pieces)),
    ] {
        if !bytes.is_empty() {
            gpu.queue.write_buffer(table.raw(), 0, bytes);
        }
    }
    let done = Done { dispatches: recording.dispatches, asked };
    submit(gpu, arena, (tables, copies), recording, &reads);
    gpu.wait_for_submissions()?;
    if total == 0 {
        return Ok((reads.iter().map(|ranges| vec![Vec::new(); ranges.len()]).collect(), done));
    }
    let staging = tables.staging.raw();
    staging.map_async(wgpu::MapMode::Read, 0..total, |_| {});
    gpu.wait_for_submissions()?;
    let refused = |e: wgpu::MapRangeError| GpuError::Refused { message: e.to_string() };
    let view = staging.get_mapped_range(0..total).map_err(refused)?;
    let mut at = 0;
    let mut taken = |range: &Range<u64>| {
        let bytes = view[at..at + (range.end - range.start) as usize].to_vec();
        at += size(range) as usize;
        bytes
    };
    let answers = reads.iter().map(|ranges| ranges.iter().map(&mut taken).collect()).collect();
    drop(view);
    staging.unmap();
    Ok((answers, done))
}

/// Copies consist of whole words.
fn size(range: &Range<u64>) -> u64 {
    (range.end - range.start).next_multiple_of(4)
}

impl Recording {
    fn add(&mut self, lists: &[Vec<Work>], together: &Together) {
        let parts = together.parts.iter().map(|(member, place)| &lists[*member][*place]);
        if !together.dispatches {
            if parts.clone().all(copies::is_short) {
                let members = together.parts.iter().map(|(member, _)| *member);
                return self.pieces(&members.zip(parts).collect::<Vec<_>>());
            }
            return parts.for_each(|work| self.copy(work));
        }
        let parts: Vec<&Dispatch> = parts
            .filter_map(|work| match work {
                Work::Dispatch(dispatch) => Some(dispatch),
                _ => None,
            })
            .collect();
        self.dispatch(&parts);
    }

    /// Adds short copies, which a kernel executes.
    fn pieces(&mut self, pieces: &[(usize, &Work)]) {
        for (_, work) in pieces {
            if let Work::Leave(range) = work {
                self.left.push(range.clone());
            }
        }
        let (begin, members) = copies::add(&mut self.pieces, pieces);
        if members > 0 {
            let offset = self.parameters.len();
            self.parameters.extend([begin, 0, 0, 0].into_iter().flat_map(u32::to_le_bytes));
            self.parameters.resize(offset + ALIGNMENT, 0);
            self.bound[1] = self.bound[1].max(self.parameters.len() as u64);
            self.actions.push(Action::Pieces { offset: offset as u32, members });
        }
    }

    fn copy(&mut self, work: &Work) {
        match work {
            Work::Dispatch(_) => {}
            Work::Copy { from, to, bytes } => {
                self.scratch = self.scratch.max(*bytes);
                self.actions.push(Action::Copy { from: *from, to: *to, bytes: *bytes });
            }
            Work::Clear(range) => self.actions.push(Action::Clear(range.clone())),
            Work::Write { to, bytes } => {
                let from = self.upload.len() as u64;
                self.upload.extend_from_slice(bytes);
                self.upload.resize(self.upload.len().next_multiple_of(4), 0);
                self.actions.push(Action::Write { from, to: *to, bytes: self.upload.len() as u64 - from });
            }
            Work::Leave(range) => self.left.push(range.clone()),
        }
    }

    fn dispatch(&mut self, parts: &[&Dispatch]) {
        let Some(first) = parts.first() else { return };
        let pipeline = first.pipeline.clone();
        let offsets = [self.rows.len() as u32, self.parameters.len() as u32];
        let mut grid = [0, 0, parts.len() as u32];
        for part in parts {
            let said_at = part.said_at.map_or(0, |word| word + 1);
            let row = part.groups.into_iter().chain([said_at]).chain(part.begins.iter().copied());
            self.rows.extend(row.flat_map(u32::to_le_bytes));
            grid = [grid[0].max(part.groups[0]), grid[1].max(part.groups[1]), grid[2]];
            if let Some(stride) = pipeline.parameters {
                let begin = self.parameters.len();
                self.parameters.extend_from_slice(&part.parameters);
                self.parameters.resize(begin + stride as usize, 0);
            }
        }
        let rows = u64::from(offsets[0]) + (4 * pipeline.row_words() * MOST_TOGETHER) as u64;
        let parameters = u64::from(offsets[1]) + pipeline.parameters.unwrap_or(0) * MOST_TOGETHER as u64;
        self.bound = [self.bound[0].max(rows), self.bound[1].max(parameters)];
        for table in [&mut self.rows, &mut self.parameters] {
            table.resize(table.len().next_multiple_of(ALIGNMENT), 0);
        }
        let invocations = parts.iter().map(|part| part.invocations).sum();
        self.dispatches += 1;
        self.actions.push(Action::Dispatch { pipeline, offsets, grid, invocations });
    }
}

/// Records and submits all operations, and the copies to the host.
fn submit(
    gpu: &Gpu,
    arena: &std::sync::Mutex<Arena>,
    (tables, copies): (&Tables, &Copies),
    recording: Recording,
    reads: &[Vec<Range<u64>>],
) {
    // While work that uses the arena is recorded, no other thread may move the arena or write to it.
    let mut arena = crate::gpu::lock::lock(arena);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass: Option<wgpu::ComputePass<'static>> = None;
    let mut invocations = 0;
    for action in recording.actions {
        match action {
            Action::Dispatch { pipeline, offsets, grid, invocations: added } => {
                invocations += added;
                let group = pipeline.group(gpu, (&arena.raw, arena.version), tables);
                let pass =
                    pass.get_or_insert_with(|| encoder.begin_compute_pass(&Default::default()).forget_lifetime());
                pass.set_pipeline(&pipeline.pipeline);
                let offsets = if pipeline.parameters.is_some() { &offsets[..] } else { &offsets[..1] };
                pass.set_bind_group(0, &group, offsets);
                pass.dispatch_workgroups(grid[0], grid[1], grid[2]);
            }
            Action::Pieces { offset, members } => {
                let pass =
                    pass.get_or_insert_with(|| encoder.begin_compute_pass(&Default::default()).forget_lifetime());
                let bound = ((&arena.raw, arena.version), tables);
                copies.record(gpu, pass, bound, (offset, members));
            }
            other => {
                pass = None;
                record_copy(&mut encoder, &arena.raw, tables, &other);
            }
        }
        if invocations > INVOCATIONS {
            (pass, invocations) = (None, 0);
            let full = std::mem::replace(&mut encoder, gpu.device.create_command_encoder(&Default::default()));
            gpu.submitted(gpu.queue.submit([full.finish()]));
        }
    }
    drop(pass);
    let mut at = 0;
    for range in reads.iter().flatten().filter(|range| !range.is_empty()) {
        encoder.copy_buffer_to_buffer(&arena.raw, range.start, tables.staging.raw(), at, size(range));
        at += size(range);
    }
    gpu.submitted(gpu.queue.submit([encoder.finish()]));
    recording.left.into_iter().for_each(|range| arena.leave(range));
}

fn record_copy(encoder: &mut wgpu::CommandEncoder, arena: &wgpu::Buffer, tables: &Tables, action: &Action) {
    match action {
        Action::Write { from, to, bytes } => {
            encoder.copy_buffer_to_buffer(tables.upload.raw(), *from, arena, *to, *bytes);
        }
        Action::Copy { from, to, bytes } => {
            encoder.copy_buffer_to_buffer(arena, *from, tables.scratch.raw(), 0, *bytes);
            encoder.copy_buffer_to_buffer(tables.scratch.raw(), 0, arena, *to, *bytes);
        }
        Action::Clear(range) => encoder.clear_buffer(arena, range.start, Some(range.end - range.start)),
        Action::Dispatch { .. } | Action::Pieces { .. } => {}
    }
}
