//! Times of passes by stage, from timestamp queries.
//!
//! Every submission has its own query sets. They keep their results until the host waits for the device for another
//! reason. So timing adds no wait, unless very many submissions follow each other without one.

use super::Gpu;
use std::mem::take;

/// Passes that one set of queries times; a submission uses as many sets as it needs. An adapter's query set holds at
/// least 4,096 queries, and a pass needs two.
const PASSES: usize = 512;

/// The largest number of sets that wait to be read, 16 KiB each; beyond, the host waits for them.
const MOST_WAITING: usize = 256;

/// Bytes of the two timestamps of a pass.
const PASS_BYTES: u64 = 16;

/// Queries of up to [`PASSES`] passes, and the buffers for their results.
pub(super) struct Set {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    /// The stage of each pass.
    stages: Vec<&'static str>,
}

/// The passes of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Passes {
    pub seconds: f64,
    pub timed: u64,
    pub untimed: u64,
}

pub(super) struct Timer {
    /// Seconds per tick.
    period: f64,
    free: Vec<Set>,
    /// Sets whose passes were submitted.
    submitted: Vec<Set>,
    stages: Vec<(&'static str, Passes)>,
}

impl Set {
    fn new(gpu: &Gpu) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: PASSES as u64 * PASS_BYTES,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Set {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES as u32,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read: buffer(wgpu::BufferUsages::MAP_READ),
            stages: Vec::new(),
        }
    }

    fn bytes(&self) -> u64 {
        self.stages.len() as u64 * PASS_BYTES
    }

    /// Copies the results into a buffer that the host can read.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.stages.len() as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, self.bytes());
    }

    /// The ticks of each pass, if the adapter wrote two valid timestamps.
    fn ticks(&self) -> Vec<Option<u64>> {
        let unknown = || vec![None; self.stages.len()];
        let Ok(view) = self.read.get_mapped_range(0..self.bytes()) else { return unknown() };
        let ticks = |bytes: &[u8; 16]| {
            let [begin, end] = [0, 8].map(|at| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i])));
            end.checked_sub(begin).filter(|_| begin > 0)
        };
        view.as_chunks::<16>().0.iter().map(ticks).collect()
    }
}

impl Timer {
    pub fn new(gpu: &Gpu) -> Self {
        let period = f64::from(gpu.queue.get_timestamp_period()) * 1e-9;
        Timer { period, free: Vec::new(), submitted: Vec::new(), stages: Vec::new() }
    }

    /// The queries of the next pass of a submission with `sets` so far: its first and its last query.
    pub fn next(&mut self, gpu: &Gpu, sets: &mut Vec<Set>, stage: &'static str) -> Option<(wgpu::QuerySet, u32, u32)> {
        if sets.last().is_none_or(|set| set.stages.len() == PASSES) {
            sets.push(self.free.pop().unwrap_or_else(|| Set::new(gpu)));
        }
        let set = sets.last_mut()?;
        let first = 2 * set.stages.len() as u32;
        set.stages.push(stage);
        Some((set.queries.clone(), first, first + 1))
    }

    /// Stores the sets of a submission until they are read.
    pub fn submitted(&mut self, gpu: &Gpu, sets: Vec<Set>) {
        self.submitted.extend(sets);
        if self.submitted.len() > MOST_WAITING {
            self.collect(gpu);
        }
    }

    /// Adds the times of all submitted work, for which it waits.
    pub fn collect(&mut self, gpu: &Gpu) {
        let mut sets = take(&mut self.submitted);
        if sets.is_empty() {
            return;
        }
        for set in &sets {
            set.read.map_async(wgpu::MapMode::Read, 0..set.bytes(), |_| {});
        }
        // After a fault the device is not queried again.
        let done = gpu.wait_for_submissions().is_ok();
        for set in &mut sets {
            let ticks = if done { set.ticks() } else { vec![None; set.stages.len()] };
            for (stage, ticks) in take(&mut set.stages).into_iter().zip(ticks) {
                self.add(stage, ticks);
            }
            set.read.unmap();
        }
        if done {
            self.free.append(&mut sets);
        }
    }

    fn add(&mut self, stage: &'static str, ticks: Option<u64>) {
        let at = self.stages.iter().position(|(name, _)| *name == stage).unwrap_or_else(|| {
            self.stages.push((stage, Passes::default()));
            self.stages.len() - 1
        });
        let passes = &mut self.stages[at].1;
        match ticks {
            Some(ticks) => {
                passes.seconds += ticks as f64 * self.period;
                passes.timed += 1;
            }
            None => passes.untimed += 1,
        }
    }

    /// The passes of a stage so far.
    pub fn passes(&self, stage: &str) -> Passes {
        self.stages.iter().find(|(name, _)| *name == stage).map_or_else(Passes::default, |(_, passes)| *passes)
    }
}
