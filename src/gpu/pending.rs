//! Work that is recorded and not submitted yet. A submission takes some 20 to 50 us on a hardware adapter and wakes a
//! thread of a software one, so the work of several recorders is submitted together: when the host waits, when it
//! writes a buffer, and when much work is pending.

use super::device::lock;
use super::timing::Set;
use super::{Gpu, GpuError};

/// Alignment of the parameters of a dispatch: what every adapter allows.
pub(super) const ALIGNMENT: usize = 256;

/// Parameters of this many dispatches fit one region.
pub(super) const SLOTS: usize = 1024;

/// Bytes of a region, which is what one recorder writes parameters to.
const REGION: usize = SLOTS * ALIGNMENT;

/// Regions of one buffer of parameters. Steps of every built-in scene wait before they need five.
const REGIONS: u32 = 8;

/// Command buffers that wait at most.
const MOST_COMMANDS: usize = 32;

/// Invocations of one submission, about, each with one row or body. Systems take a device away from a program whose
/// submission lasts seconds, and waiting tells a hang from much work only between submissions. With 5.2 million rows a
/// software adapter whose two cores were shared by six other programs took 18 s for an iteration of 16 dispatches: some
/// 4 s for so many.
pub(super) const INVOCATIONS: u64 = 1 << 24;

/// A part of a buffer of parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    /// Which buffer.
    pub bank: usize,
    nth: u32,
}

impl Region {
    /// Where it begins, in bytes.
    pub fn offset(self) -> u32 {
        self.nth * REGION as u32
    }
}

/// A buffer of parameters, and which of its regions are taken, as bits.
struct Bank {
    buffer: wgpu::Buffer,
    taken: u32,
}

impl Bank {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let descriptor = wgpu::BufferDescriptor {
            label: Some("parameters"),
            // A kernel binds more than one slot from its offset on.
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

/// What a recorder made.
pub(super) struct Recorded {
    pub commands: wgpu::CommandBuffer,
    pub parameters: Option<(Region, Vec<u8>)>,
    /// Queries of its passes.
    pub timed: Vec<Set>,
    pub invocations: u64,
    /// The stage that it ended in.
    pub stage: &'static str,
}

/// What waits to be handed over.
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
    /// A region that nothing else uses.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], or the fault that the device reported.
    pub(super) fn take_region(&self) -> Result<Region, GpuError> {
        if let Some(region) = lock(&self.pending).take() {
            return Ok(region);
        }
        self.hand_over();
        // Recorders of other threads may have all of them.
        let mut pending = lock(&self.pending);
        if let Some(region) = pending.take() {
            return Ok(region);
        }
        let mut bank = Bank::new(self)?;
        let nth = bank.take().unwrap_or(0);
        pending.banks.push(bank);
        Ok(Region { bank: pending.banks.len() - 1, nth })
    }

    /// Gives a region back whose parameters nothing needs.
    pub(super) fn leave_region(&self, region: Region) {
        lock(&self.pending).leave(region);
    }

    /// The buffer that a region is part of.
    pub(super) fn parameter_buffer(&self, bank: usize) -> Option<wgpu::Buffer> {
        lock(&self.pending).banks.get(bank).map(|bank| bank.buffer.clone())
    }

    /// Adds what was recorded to what waits, which is handed over if it is much.
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

    /// Hands all that waits to the device.
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
