//! A buffer on the device that grows as needed.

use super::device::Shared;
use super::ensemble::{Membership, Work};
use super::lock::lock;
use super::{Gpu, GpuError, Precision, Recorder};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// A buffer grows by at least this factor, so that n elements cost O(n) copies in total.
const GROWTH: f64 = 1.5;

/// The memory of an array.
pub(super) enum Place {
    /// A separate buffer.
    Own(wgpu::Buffer),
    /// A part of the arena of an ensemble.
    Part { of: Arc<Membership>, range: Range<u64> },
}

/// An array on the device.
pub struct Buffer {
    pub(super) place: Place,
    size: u64,
    pub(super) id: u64,
    label: &'static str,
    /// Bytes of one element.
    element: usize,
    capacity: u64,
    shared: Arc<Shared>,
}

impl Buffer {
    /// An array of at least `capacity` elements of `element` bytes each. Its contents are zero.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where one buffer cannot be that large, [`GpuError::OutOfMemory`].
    pub fn new(gpu: &Gpu, label: &'static str, element: usize, capacity: u64) -> Result<Self, GpuError> {
        let most = gpu.most_elements(element);
        if capacity > most {
            let (needs, has) = (capacity * element as u64, most * element as u64);
            return Err(GpuError::Limit { what: label.into(), needs, has, adapter: gpu.name().into() });
        }
        let capacity = capacity.max(gpu.least_capacity()).min(most);
        let size = (capacity * element as u64).next_multiple_of(16);
        let place = Place::new(gpu, label, size)?;
        let id = gpu.new_id();
        let mut allocations = lock(&gpu.shared.allocations);
        allocations.live.insert(id, (label.to_owned(), size));
        allocations.made += 1;
        allocations.bytes += size;
        allocations.peak = allocations.peak.max(allocations.bytes);
        drop(allocations);
        Ok(Buffer { place, size, id, label, element, capacity, shared: gpu.shared.clone() })
    }

    /// An array that holds these bytes.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn with(gpu: &Gpu, label: &'static str, element: usize, bytes: &[u8]) -> Result<Self, GpuError> {
        let buffer = Buffer::new(gpu, label, element, (bytes.len() / element) as u64)?;
        buffer.write(gpu, 0, bytes);
        Ok(buffer)
    }

    /// An array that holds these numbers, rounded to `precision`; `width` of them make one element.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn reals(
        gpu: &Gpu,
        label: &'static str,
        precision: Precision,
        width: usize,
        numbers: impl IntoIterator<Item = f64>,
    ) -> Result<Self, GpuError> {
        Buffer::with(gpu, label, width * precision.bytes(), &precision.encode(numbers))
    }

    /// Its label, as in `--profile`.
    pub fn label(&self) -> &'static str {
        self.label
    }

    /// Its size in bytes.
    pub fn bytes(&self) -> u64 {
        self.size
    }

    /// The number of elements that fit.
    pub fn capacity(&self) -> u64 {
        self.capacity
    }

    /// Bytes of one element.
    pub fn element(&self) -> usize {
        self.element
    }

    /// Reserves memory for `needed` elements; the contents are lost if it grows. Returns whether it grew.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn reserve(&mut self, gpu: &Gpu, needed: u64) -> Result<bool, GpuError> {
        if needed <= self.capacity {
            return Ok(false);
        }
        *self = Buffer::new(gpu, self.label, self.element, self.grown(gpu, needed))?;
        Ok(true)
    }

    /// Reserves memory for `needed` elements and keeps the contents.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn reserve_and_keep(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, needed: u64) -> Result<bool, GpuError> {
        if needed <= self.capacity {
            return Ok(false);
        }
        let larger = Buffer::new(gpu, self.label, self.element, self.grown(gpu, needed))?;
        record.copy(self, 0, &larger, 0, self.capacity * self.element as u64);
        *self = larger;
        Ok(true)
    }

    /// The capacity to grow to; growth beyond `needed` stays within one binding.
    fn grown(&self, gpu: &Gpu, needed: u64) -> u64 {
        let more = (needed as f64 * GROWTH) as u64;
        let grown = needed.max(more.min(gpu.bank_bytes() / self.element as u64));
        log::debug!("buffer {}: from {} to {grown} elements of {} bytes", self.label, self.capacity, self.element);
        grown
    }

    /// The parts in which the buffer is bound: offset and bytes of each. One part, except for a buffer larger than a
    /// binding.
    pub(super) fn banks(&self, bank_bytes: u64) -> impl Iterator<Item = (u64, u64)> {
        let size = self.size;
        (0..size.div_ceil(bank_bytes)).map(move |bank| {
            let offset = bank * bank_bytes;
            (offset, bank_bytes.min(size - offset))
        })
    }

    /// Writes bytes before the work that is submitted next.
    pub fn write(&self, gpu: &Gpu, offset: u64, bytes: &[u8]) {
        lock(&gpu.tally).write(bytes.len() as u64);
        match &self.place {
            _ if bytes.is_empty() => {}
            Place::Own(raw) => {
                // Work that was submitted earlier may still read the present contents.
                gpu.hand_over();
                gpu.queue.write_buffer(raw, offset, bytes);
            }
            Place::Part { of, range } => of.append([Work::Write { to: range.start + offset, bytes: bytes.to_vec() }]),
        }
    }

    /// A range of its bytes as a range of the arena; `None` for a separate buffer.
    pub(super) fn part(&self, bytes: Range<u64>) -> Option<Range<u64>> {
        match &self.place {
            Place::Own(_) => None,
            Place::Part { range, .. } => Some(range.start + bytes.start..range.start + bytes.end),
        }
    }

    /// The separate buffer; `None` for a part of an arena.
    pub(super) fn own(&self) -> Option<&wgpu::Buffer> {
        match &self.place {
            Place::Own(raw) => Some(raw),
            Place::Part { .. } => None,
        }
    }
}

impl Place {
    fn new(gpu: &Gpu, label: &'static str, size: u64) -> Result<Self, GpuError> {
        if let Some(member) = &gpu.member {
            return Ok(Place::Part { of: member.clone(), range: member.take(label, size)? });
        }
        let descriptor = wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::INDIRECT,
            mapped_at_creation: false,
        };
        Ok(Place::Own(gpu.scoped(label, || gpu.device.create_buffer(&descriptor))?))
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        let mut allocations = lock(&self.shared.allocations);
        if let Some((_, size)) = allocations.live.remove(&self.id) {
            allocations.bytes -= size;
        }
        self.shared.stale.store(true, Ordering::Relaxed);
        if let Place::Part { of, range } = &self.place {
            // Pending work may still use this range.
            of.append([Work::Leave(range.clone())]);
        }
    }
}
