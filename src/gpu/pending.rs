//! Work that is recorded and not submitted yet. A submission takes some 20 to 50 us on a hardware adapter and wakes a
//! thread of a software one, so the work of several recorders is submitted together: when the host waits, when it
//! writes a buffer, and when much work is pending.

use super::lock::lock;
use super::timing::Set;
use super::{Gpu, GpuError};

/// The alignment of the parameters of a dispatch that every adapter allows.
pub(super) const ALIGNMENT: usize = 256;

/// The number of dispatches whose parameters fit in one region.
pub(super) const SLOTS: usize = 1024;

/// The size of a region in bytes. One recorder writes its parameters to a region.
const REGION: usize = SLOTS * ALIGNMENT;

/// Regions per buffer of parameters. Steps of every built-in scene submit their work before they need five.
const REGIONS: u32 = 8;

/// The largest number of pending command buffers.
const MOST_COMMANDS: usize = 32;

/// The approximate number of invocations of one submission, each with one row or body. Operating systems reset a device
/// if a submission lasts seconds, and only between submissions can a wait distinguish a hang from much work. With 5.2
/// million rows, a software adapter whose two cores were shared with six other programs took 18 s for an iteration of
/// 16 dispatches: some 4 s for this many invocations.
pub(super) const INVOCATIONS: u64 = 1 << 24;

/// A part of a buffer of parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    /// The index of the buffer.
    pub bank: usize,
    nth: u32,
}

impl Region {
    /// Its start in bytes.
    pub fn offset(self) -> u32 {
        self.nth * REGION as u32
    }
}

/// A buffer of parameters, and its used regions as bits.
struct Bank {
    buffer: wgpu::Buffer,
    taken: u32,
}

impl Bank {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let descriptor = wgpu::BufferDescriptor {
            label: Some("parameters"),
            // A kernel's binding extends beyond one slot from its offset.
            size: (REGIONS as usize * REGION + ALIGNMENT) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        };
        let buffer = gpu.scoped("parameters", || gpu.device.create_buffer(&descriptor))?;
        Ok(Bank { buffer, taken: 0 })
    }

    fn take(&mut self) -> Option<u32> {
        let nth = (0..REGIONS).find(|nth| self.taken & (1 << nth) == 0)?;
        self.taken |= 1 << nth;
        Some(nth)
    }

    fn leave(&mut self, nth: u32) {
        self.taken &= !(1 << nth);
    }
}

/// The result of a recorder.
pub(super) struct Recorded {
    pub commands: wgpu::CommandBuffer,
    pub parameters: Option<(Region, Vec<u8>)>,
    /// The timestamp queries of its passes.
    pub timed: Vec<Set>,
    pub invocations: u64,
    /// The last stage that it recorded.
    pub stage: &'static str,
}

/// Recorded work that was not yet submitted to the device.
#[derive(Default)]
pub(super) struct Pending {
    all: Vec<Recorded>,
    invocations: u64,
    banks: Vec<Bank>,
}

impl Pending {
    fn take(&mut self) -> Option<Region> {
        self.banks.iter_mut().enumerate().find_map(|(bank, of)| Some(Region { bank, nth: of.take()? }))
    }

    fn leave(&mut self, region: Region) {
        if let Some(bank) = self.banks.get_mut(region.bank) {
            bank.leave(region.nth);
        }
    }
}

impl Gpu {
    /// Allocates an unused region.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], or the fault that the device reported.
    pub(super) fn take_region(&self) -> Result<Region, GpuError> {
        if let Some(region) = lock(&self.pending).take() {
            return Ok(region);
        }
        self.hand_over();
        // Recorders of other threads may have taken all regions.
        let mut pending = lock(&self.pending);
        if let Some(region) = pending.take() {
            return Ok(region);
        }
        let mut bank = Bank::new(self)?;
        let nth = bank.take().unwrap_or(0);
        pending.banks.push(bank);
        Ok(Region { bank: pending.banks.len() - 1, nth })
    }

    /// Frees a region whose parameters are no longer needed.
    pub(super) fn leave_region(&self, region: Region) {
        lock(&self.pending).leave(region);
    }

    /// The buffer that a region is part of.
    pub(super) fn parameter_buffer(&self, bank: usize) -> Option<wgpu::Buffer> {
        lock(&self.pending).banks.get(bank).map(|bank| bank.buffer.clone())
    }

    /// Adds recorded work to the pending work, which is submitted if it is much.
    pub(super) fn append(&self, recorded: Recorded) {
        let invocations = recorded.invocations;
        if lock(&self.pending).invocations + invocations > INVOCATIONS {
            self.hand_over();
        }
        let mut pending = lock(&self.pending);
        pending.invocations += invocations;
        pending.all.push(recorded);
        let much = pending.invocations > INVOCATIONS || pending.all.len() >= MOST_COMMANDS;
        drop(pending);
        if much {
            self.hand_over();
        }
    }

    /// Submits all pending work to the device.
    pub(super) fn hand_over(&self) {
        let mut timed = Vec::new();
        let mut pending = lock(&self.pending);
        let Some(stage) = pending.all.last().map(|recorded| recorded.stage) else { return };
        let mut commands = Vec::with_capacity(pending.all.len());
        for recorded in std::mem::take(&mut pending.all) {
            commands.push(recorded.commands);
            timed.extend(recorded.timed);
            if let Some((region, bytes)) = recorded.parameters
                && let Some(bank) = pending.banks.get_mut(region.bank)
            {
                self.queue.write_buffer(&bank.buffer, u64::from(region.offset()), &bytes);
                bank.leave(region.nth);
            }
        }
        pending.invocations = 0;
        // No other thread may write these regions before this submission is in the queue.
        self.submitted(self.queue.submit(commands));
        drop(pending);
        lock(&self.tally).of(stage).submissions += 1;
        if !timed.is_empty()
            && let Some(timer) = lock(&self.timer).as_mut()
        {
            timer.submitted(self, timed);
        }
    }
}
