//! Times of passes by stage, from timestamp queries.

use super::{Gpu, StageTime};
use std::collections::BTreeMap;

/// Passes that one submission can time; later ones in it are not timed.
const MOST_PASSES: u32 = 512;

pub(super) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
    period: f64,
    pending: Vec<&'static str>,
    /// Stages of the submission whose results are in `read`.
    submitted: Vec<&'static str>,
    stages: BTreeMap<&'static str, (f64, u64)>,
}

impl Timer {
    pub fn new(gpu: &Gpu) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: u64::from(2 * MOST_PASSES) * 8,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Timer {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MOST_PASSES,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read: buffer(wgpu::BufferUsages::MAP_READ),
            period: f64::from(gpu.queue.get_timestamp_period()) * 1e-9,
            pending: Vec::new(),
            submitted: Vec::new(),
            stages: BTreeMap::new(),
        }
    }

    /// The queries of the next pass: its first and its last.
    pub fn next(&mut self, stage: &'static str) -> Option<(wgpu::QuerySet, u32, u32)> {
        let first = 2 * self.pending.len() as u32;
        if first >= 2 * MOST_PASSES {
            return None;
        }
        self.pending.push(stage);
        Some((self.queries.clone(), first, first + 1))
    }

    /// Brings the queries of what was recorded into a buffer. A submission that is not waited for is not timed.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.submitted = std::mem::take(&mut self.pending);
        let count = 2 * self.submitted.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read, 0, u64::from(count) * 8);
        }
    }

    /// Adds the times of the last submission, which is done.
    pub fn collect(&mut self, gpu: &Gpu) {
        let submitted = std::mem::take(&mut self.submitted);
        if submitted.is_empty() {
            return;
        }
        let bytes = submitted.len() as u64 * 16;
        self.read.map_async(wgpu::MapMode::Read, 0..bytes, |_| {});
        if gpu.wait().is_err() {
            return;
        }
        let Ok(view) = self.read.get_mapped_range(0..bytes) else { return };
        for (stage, ticks) in submitted.iter().zip(view.as_chunks::<16>().0) {
            let [begin, end] = [0, 8].map(|at| u64::from_le_bytes(std::array::from_fn(|i| ticks[at + i])));
            let (seconds, passes) = self.stages.entry(stage).or_default();
            *seconds += end.saturating_sub(begin) as f64 * self.period;
            *passes += 1;
        }
        drop(view);
        self.read.unmap();
    }

    pub fn report(&self) -> Vec<StageTime> {
        let stage = |(stage, (seconds, passes)): (&&'static str, &(f64, u64))| StageTime {
            stage,
            seconds: *seconds,
            passes: *passes,
        };
        self.stages.iter().map(stage).collect()
    }
}
