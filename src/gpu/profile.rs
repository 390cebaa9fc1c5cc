//! What a device was made to do: pipelines, buffers, dispatches, read-backs, and the time of each stage where the adapter tells it.

use super::Gpu;
use std::collections::BTreeMap;
use std::fmt;

/// What a device did since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Counters {
    /// Dispatches recorded, indirect ones too.
    pub dispatches: u64,
    /// Submissions.
    pub submissions: u64,
    /// Times that the host waited for data.
    pub reads: u64,
    /// Bytes read back.
    pub bytes_read: u64,
    /// Bytes written to the device.
    pub bytes_written: u64,
}

/// A pipeline that was made.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct PipelineReport {
    /// The kernel's name.
    pub name: String,
    /// Seconds to validate and translate it; drivers may compile later, at first use, unless told to at once.
    pub seconds: f64,
}

/// The time that a stage's kernels took.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct StageTime {
    /// The stage.
    pub stage: &'static str,
    /// Seconds on the device.
    pub seconds: f64,
    /// Passes timed.
    pub passes: u64,
}

/// All buffers of one label.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct BufferUse {
    /// What they hold.
    pub label: String,
    /// How many there are.
    pub count: usize,
    /// Bytes of all of them.
    pub bytes: u64,
}

/// What a device was made to do.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Profile {
    /// The adapter and its driver.
    pub adapter: String,
    /// The pipelines made, in order.
    pub pipelines: Vec<PipelineReport>,
    /// The buffers there are, the largest first.
    pub buffers: Vec<BufferUse>,
    /// Bytes of all buffers at once, at most.
    pub peak_bytes: u64,
    /// Steps since the device was opened.
    pub steps: u64,
    /// Dispatches, submissions, read-backs since then.
    pub counters: Counters,
    /// Device time by stage; empty where the adapter does not tell.
    pub stages: Vec<StageTime>,
}

impl Profile {
    /// The profile of a device that took `steps` steps.
    pub fn of(gpu: &Gpu, steps: u64) -> Profile {
        let mut by_label: BTreeMap<String, (usize, u64)> = BTreeMap::new();
        for (label, bytes) in gpu.buffers() {
            let entry = by_label.entry(label).or_default();
            *entry = (entry.0 + 1, entry.1 + bytes);
        }
        let mut buffers: Vec<BufferUse> =
            by_label.into_iter().map(|(label, (count, bytes))| BufferUse { label, count, bytes }).collect();
        buffers.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.label.cmp(&b.label)));
        Profile {
            adapter: format!("{} ({})", gpu.name(), gpu.driver()),
            pipelines: gpu.pipelines(),
            buffers,
            peak_bytes: gpu.peak_bytes(),
            steps,
            counters: gpu.counters(),
            stages: gpu.stage_times(),
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "  {}", self.adapter)?;
        let (c, steps) = (&self.counters, self.steps.max(1) as f64);
        let a_step = |count: u64| count as f64 / steps;
        writeln!(
            out,
            "  a step: {:.1} dispatches, {:.1} submissions, {:.1} read-backs of {:.0} bytes in all, {:.0} bytes written",
            a_step(c.dispatches),
            a_step(c.submissions),
            a_step(c.reads),
            a_step(c.bytes_read),
            a_step(c.bytes_written)
        )?;
        for stage in &self.stages {
            writeln!(out, "  {:<24} {:>10.3} s on the device", stage.stage, stage.seconds)?;
        }
        if self.stages.is_empty() {
            writeln!(out, "  the adapter has no timestamps: times of stages on the device are not known")?;
        }
        let total: u64 = self.buffers.iter().map(|b| b.bytes).sum();
        writeln!(out, "  {:.2} MiB in buffers, at most {:.2}:", mib(total), mib(self.peak_bytes))?;
        for buffer in &self.buffers {
            let times = if buffer.count > 1 { format!(" ({} of them)", buffer.count) } else { String::new() };
            writeln!(out, "    {:>12} bytes  {}{times}", buffer.bytes, buffer.label)?;
        }
        let seconds: f64 = self.pipelines.iter().map(|p| p.seconds).sum();
        writeln!(out, "  {} pipelines, made in {seconds:.2} s:", self.pipelines.len())?;
        for pipeline in &self.pipelines {
            writeln!(out, "    {:>10.3} s  {}", pipeline.seconds, pipeline.name)?;
        }
        Ok(())
    }
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
