//! Records dispatches and copies, submits them together, and reads buffers back.

use super::ensemble::{Dispatch, Membership, Work};
use super::kernel::{Compiled, Runs};
use super::lock::lock;
use super::pending::{ALIGNMENT, INVOCATIONS, Recorded, Region, SLOTS};
use super::tally::{Tally, UNNAMED};
use super::timing::Set;
use super::{Buffer, Gpu, GpuError, Kernel};
use std::ops::Range;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// The largest number of workgroups along one dimension of a dispatch.
const MOST_GROUPS: u64 = 65_535;

/// The largest number of bind groups that are kept.
const MOST_BIND_GROUPS: usize = 4096;

/// The buffer for read-backs.
#[derive(Default)]
pub(super) struct Staging {
    read: Option<wgpu::Buffer>,
}

/// The size of a dispatch.
#[derive(Clone, Copy)]
pub enum Size<'a> {
    /// At least this many invocations; no dispatch for zero.
    Invocations(u64),
    /// This many workgroups, folded into two dimensions if they are many.
    Groups(u64),
    /// The number of workgroups in three words, read when the dispatch is executed.
    Indirect {
        /// The buffer that contains them.
        said: &'a Buffer,
        /// Their offset in bytes.
        offset: u64,
        /// The expected number of workgroups; it may also turn out to be zero.
        expected: u64,
    },
}

impl From<u64> for Size<'_> {
    fn from(invocations: u64) -> Self {
        Size::Invocations(invocations)
    }
}

/// Work being recorded. Operations are executed in order, and none before [`Recorder::submit`]. Submitted work may be
/// held back to be handed to the device together with other work.
pub struct Recorder<'g> {
    gpu: &'g Gpu,
    encoder: Option<wgpu::CommandEncoder>,
    pass: Option<wgpu::ComputePass<'static>>,
    parameters: Vec<u8>,
    /// The memory for the parameters, allocated with the first one.
    region: Option<Region>,
    /// The counters of the recorded work.
    tally: Tally,
    /// The timestamp queries of its passes.
    timed: Vec<Set>,
    invocations: u64,
    stage: &'static str,
    /// The work recorded for a member of an ensemble.
    work: Vec<Work>,
}

impl<'g> Recorder<'g> {
    pub(super) fn new(gpu: &'g Gpu) -> Self {
        Recorder {
            gpu,
            encoder: None,
            pass: None,
            parameters: Vec::new(),
            region: None,
            tally: Tally::default(),
            timed: Vec::new(),
            invocations: 0,
            stage: UNNAMED,
            work: Vec::new(),
        }
    }

    /// The device.
    pub fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    /// Names the stage of the work that follows, for a profile.
    pub fn stage(&mut self, name: &'static str) {
        if self.stage != name {
            self.stage = name;
            if lock(&self.gpu.timer).is_some() {
                self.pass = None;
            }
        }
    }

    /// Dispatches a kernel, with buffers in the order of its bindings. A missing buffer, elements of another size, a
    /// buffer that is too small, and parameters of another length are faults of the device, which the next
    /// [`Recorder::submit`] returns.
    pub fn run<'s>(&mut self, kernel: &Kernel, parameters: &[u8], buffers: &[&Buffer], size: impl Into<Size<'s>>) {
        let (groups, said) = match size.into() {
            Size::Invocations(threads) => (threads.div_ceil(u64::from(kernel.workgroup)), None),
            Size::Groups(groups) => (groups, None),
            Size::Indirect { said, offset, expected } => (expected, Some((said, offset))),
        };
        if groups == 0 {
            return;
        }
        let rows = groups.div_ceil(MOST_GROUPS);
        let grid = [groups.div_ceil(rows) as u32, rows as u32];
        let dispatched = kernel.check_counts(parameters, buffers).and_then(|()| {
            if self.gpu.member.is_some() {
                return self.run_as_member(kernel, parameters, buffers, (grid, said));
            }
            self.bind(kernel, parameters, buffers)?;
            match said {
                None => self.pass().dispatch_workgroups(grid[0], grid[1], 1),
                Some((said, offset)) => {
                    let Some(said) = said.own() else { return Ok(()) };
                    self.pass().dispatch_workgroups_indirect(said, offset);
                }
            }
            self.divide(kernel, groups);
            Ok(())
        });
        if let Err(fault) = dispatched {
            self.gpu.shared.fail(fault);
        }
    }

    /// Counts additional work of the dispatch recorded next, beyond one row or body per invocation.
    pub fn weigh(&mut self, invocations: u64) {
        self.invocations += invocations;
    }

    /// Submits the recorded work if it is much.
    fn divide(&mut self, kernel: &Kernel, groups: u64) {
        self.invocations += groups * u64::from(kernel.workgroup);
        if self.invocations > INVOCATIONS {
            // The next submission or read returns the fault.
            let _ = self.submit();
        }
    }

    /// Copies bytes between buffers.
    pub fn copy(&mut self, from: &Buffer, from_offset: u64, to: &Buffer, to_offset: u64, bytes: u64) {
        if bytes == 0 {
            return;
        }
        let parts = (from.part(from_offset..from_offset + bytes), to.part(to_offset..to_offset + bytes));
        match (from.own(), to.own(), parts) {
            (Some(from), Some(to), _) => self.encoder().copy_buffer_to_buffer(from, from_offset, to, to_offset, bytes),
            (_, _, (Some(from), Some(to))) => {
                self.work.push(Work::Copy { from: from.start, to: to.start, bytes });
            }
            _ => self.gpu.shared.fail(GpuError::Refused { message: "a copy between an ensemble and others".into() }),
        }
    }

    /// Zeroes a range of bytes.
    pub fn clear(&mut self, buffer: &Buffer, bytes: Range<u64>) {
        match (buffer.own(), buffer.part(bytes.clone())) {
            _ if bytes.is_empty() => {}
            (Some(raw), _) => self.encoder().clear_buffer(raw, bytes.start, Some(bytes.end - bytes.start)),
            (_, part) => self.work.extend(part.map(Work::Clear)),
        }
    }

    /// Submits the recorded work. It is executed after all work submitted before, and before writes that follow.
    ///
    /// # Errors
    /// The fault that the device reported, if any.
    pub fn submit(&mut self) -> Result<(), GpuError> {
        self.pass = None;
        if let Some(member) = &self.gpu.member {
            member.append(self.work.drain(..));
            lock(&self.gpu.tally).add(&mut self.tally, self.stage);
        }
        let Some(mut encoder) = self.encoder.take() else { return self.gpu.health() };
        self.timed.iter().for_each(|set| set.resolve(&mut encoder));
        lock(&self.gpu.tally).add(&mut self.tally, self.stage);
        let parameters = std::mem::take(&mut self.parameters);
        self.gpu.append(Recorded {
            commands: encoder.finish(),
            parameters: self.region.take().map(|region| (region, parameters)),
            timed: std::mem::take(&mut self.timed),
            invocations: std::mem::take(&mut self.invocations),
            stage: self.stage,
        });
        self.gpu.health()
    }

    /// Submits, waits once, and returns the bytes of these ranges.
    ///
    /// # Errors
    /// [`GpuError::Hang`], [`GpuError::Lost`], or another error of the device.
    pub fn read(&mut self, ranges: &[(&Buffer, Range<u64>)]) -> Result<Vec<Vec<u8>>, GpuError> {
        // Copies consist of whole words.
        let size = |range: &Range<u64>| (range.end - range.start).next_multiple_of(4);
        let total: u64 = ranges.iter().map(|(_, range)| size(range)).sum();
        if total == 0 {
            self.submit()?;
            return Ok(ranges.iter().map(|_| Vec::new()).collect());
        }
        if let Some(member) = &self.gpu.member {
            return self.read_as_member(member, ranges, total);
        }
        // One read-back at a time, because all share a buffer.
        let reading = lock(&self.gpu.reading);
        let staging = self.staging(total)?;
        let mut at = 0;
        for (buffer, range) in ranges {
            if let Some(raw) = buffer.own().filter(|_| !range.is_empty()) {
                self.encoder().copy_buffer_to_buffer(raw, range.start, &staging, at, size(range));
            }
            at += size(range);
        }
        self.submit()?;
        self.gpu.hand_over();
        staging.map_async(wgpu::MapMode::Read, 0..total, |_| {});
        let begun = Instant::now();
        self.gpu.wait()?;
        let waited = begun.elapsed();
        let refused = |e: wgpu::MapRangeError| GpuError::Refused { message: e.to_string() };
        let view = staging.get_mapped_range(0..total).map_err(refused)?;
        let mut at = 0;
        let mut out = Vec::with_capacity(ranges.len());
        for (_, range) in ranges {
            let bytes = (range.end - range.start) as usize;
            out.push(view[at..at + bytes].to_vec());
            at += size(range) as usize;
        }
        drop(view);
        staging.unmap();
        drop(reading);
        if let Some(timer) = lock(&self.gpu.timer).as_mut() {
            timer.collect(self.gpu);
        }
        lock(&self.gpu.tally).of(self.stage).read(total, waited);
        Ok(out)
    }

    /// Stores a dispatch of a member. Words of the arena may contain its numbers of workgroups.
    fn run_as_member(
        &mut self,
        kernel: &Kernel,
        parameters: &[u8],
        buffers: &[&Buffer],
        (groups, said): ([u32; 2], Option<(&Buffer, u64)>),
    ) -> Result<(), GpuError> {
        let counters = self.tally.of(self.stage);
        counters.dispatches += 1;
        counters.bytes_written += parameters.len() as u64;
        let invocations = u64::from(groups[0]) * u64::from(groups[1]) * u64::from(kernel.workgroup);
        let invocations = invocations + std::mem::take(&mut self.invocations);
        kernel.check_sizes(buffers)?;
        let Runs::Together(pipeline) = &kernel.runs else {
            return Err(GpuError::Refused { message: format!("{} is no kernel of an ensemble", kernel.name) });
        };
        let begins = pipeline.begins(buffers.iter().filter_map(|b| b.part(0..0)).map(|part| part.start))?;
        let said_at = said.and_then(|(said, offset)| said.part(offset..offset)).map(|said| (said.start / 4) as u32);
        let (pipeline, parameters) = (pipeline.clone(), parameters.to_vec());
        self.work.push(Work::Dispatch(Dispatch { pipeline, parameters, begins, groups, said_at, invocations }));
        Ok(())
    }

    /// Executes all recorded work of a member, together with the work of others, and reads.
    fn read_as_member(
        &mut self,
        member: &Membership,
        ranges: &[(&Buffer, Range<u64>)],
        total: u64,
    ) -> Result<Vec<Vec<u8>>, GpuError> {
        self.submit()?;
        let begun = Instant::now();
        let parts = ranges.iter().filter_map(|(buffer, range)| buffer.part(range.clone()));
        let read = member.ask(parts.collect())?;
        lock(&self.gpu.tally).of(self.stage).read(total, begun.elapsed());
        Ok(read)
    }

    fn staging(&self, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        let mut staging = lock(&self.gpu.staging);
        if let Some(buffer) = staging.read.as_ref().filter(|b| b.size() >= bytes) {
            return Ok(buffer.clone());
        }
        let descriptor = wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: bytes.next_power_of_two().max(4096),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        };
        let buffer = self.gpu.scoped("read-back", || self.gpu.device.create_buffer(&descriptor))?;
        staging.read = Some(buffer.clone());
        Ok(buffer)
    }

    fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        self.pass = None;
        self.encoder.get_or_insert_with(|| self.gpu.device.create_command_encoder(&Default::default()))
    }

    fn pass(&mut self) -> &mut wgpu::ComputePass<'static> {
        let encoder = self.encoder.get_or_insert_with(|| self.gpu.device.create_command_encoder(&Default::default()));
        self.pass.get_or_insert_with(|| {
            let mut timer = lock(&self.gpu.timer);
            let timestamps = timer.as_mut().and_then(|timer| timer.next(self.gpu, &mut self.timed, self.stage));
            let timestamp_writes = timestamps.as_ref().map(|(set, begin, end)| wgpu::ComputePassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(*begin),
                end_of_pass_write_index: Some(*end),
            });
            let descriptor = wgpu::ComputePassDescriptor { label: Some(self.stage), timestamp_writes };
            encoder.begin_compute_pass(&descriptor).forget_lifetime()
        })
    }

    /// Binds buffers for the next dispatch.
    fn bind(&mut self, kernel: &Kernel, parameters: &[u8], buffers: &[&Buffer]) -> Result<(), GpuError> {
        if self.parameters.len() >= SLOTS * ALIGNMENT {
            // The next submission or read returns the fault.
            let _ = self.submit();
        }
        let before = self.parameters.len();
        let (mut offset, mut bank) = (0, None);
        if kernel.parameters > 0 {
            let region = self.region()?;
            (offset, bank) = (region.offset() + before as u32, Some(region.bank));
            self.parameters.extend_from_slice(parameters);
            self.parameters.resize(self.parameters.len().next_multiple_of(ALIGNMENT), 0);
        }
        let parameter_bytes = (self.parameters.len() - before) as u64;
        let bank_bytes = self.gpu.bank_bytes();
        let banks: Vec<u32> = buffers.iter().map(|b| b.banks(bank_bytes).count() as u32).collect();
        let compiled = kernel.compiled(self.gpu, &banks)?;
        let group = self.bind_group(kernel, &compiled, bank, buffers)?;
        let counters = self.tally.of(self.stage);
        counters.dispatches += 1;
        counters.bytes_written += parameter_bytes;
        let offsets: &[u32] = if kernel.parameters > 0 { &[offset] } else { &[] };
        let pass = self.pass();
        pass.set_pipeline(&compiled.pipeline);
        pass.set_bind_group(0, &group, offsets);
        Ok(())
    }

    /// The bind group of these buffers, from the cache if possible. Sizes are checked when it is created; the size of a
    /// buffer never changes.
    fn bind_group(
        &self,
        kernel: &Kernel,
        compiled: &Compiled,
        bank: Option<usize>,
        buffers: &[&Buffer],
    ) -> Result<wgpu::BindGroup, GpuError> {
        let mut groups = lock(&self.gpu.bind_groups);
        if self.gpu.shared.stale.swap(false, Ordering::Relaxed) || groups.len() > MOST_BIND_GROUPS {
            groups.clear();
        }
        let key = (compiled.id, bank, buffers.iter().map(|b| b.id).collect());
        if let Some(group) = groups.get(&key) {
            return Ok(group.clone());
        }
        kernel.check_sizes(buffers)?;
        let group = self.make_bind_group(kernel, compiled, bank, buffers);
        groups.insert(key, group.clone());
        Ok(group)
    }

    fn make_bind_group(
        &self,
        kernel: &Kernel,
        compiled: &Compiled,
        bank: Option<usize>,
        buffers: &[&Buffer],
    ) -> wgpu::BindGroup {
        let parameters = bank.and_then(|bank| self.gpu.parameter_buffer(bank));
        let part = |binding, buffer, offset, size| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset,
                size: std::num::NonZeroU64::new(size),
            }),
        };
        let uniform = parameters.as_ref().map(|buffer| part(0, buffer, 0, kernel.parameters));
        let first = u32::from(kernel.parameters > 0);
        let bank_bytes = self.gpu.bank_bytes();
        let banks = buffers
            .iter()
            .filter_map(|b| b.own().map(|raw| (raw, b)))
            .flat_map(|(raw, b)| b.banks(bank_bytes).map(move |(offset, size)| (raw, offset, size)));
        let storages = (first..).zip(banks).map(|(binding, (raw, offset, size))| part(binding, raw, offset, size));
        let entries: Vec<_> = uniform.into_iter().chain(storages).collect();
        let descriptor =
            wgpu::BindGroupDescriptor { label: Some(&kernel.name), layout: &compiled.layout, entries: &entries };
        self.gpu.device.create_bind_group(&descriptor)
    }

    /// The memory for the parameters.
    fn region(&mut self) -> Result<Region, GpuError> {
        if let Some(region) = self.region {
            return Ok(region);
        }
        let region = self.gpu.take_region()?;
        self.region = Some(region);
        Ok(region)
    }
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        if let Some(region) = self.region.take() {
            self.gpu.leave_region(region);
        }
    }
}
