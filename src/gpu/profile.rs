//! A profile of a device: counts of pipelines, buffers, dispatches and read-backs, and the time of each stage where the
//! adapter supports timestamps.

use super::Gpu;
use std::collections::BTreeMap;
use std::fmt;
use std::ops;

/// The counters of a device, and the time that the host waited for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Counters {
    /// Dispatches recorded, including indirect ones.
    pub dispatches: u64,
    /// Submissions.
    pub submissions: u64,
    /// The number of waits of the host for data.
    pub reads: u64,
    /// Seconds of these waits.
    pub wait_seconds: f64,
    /// Bytes read back.
    pub bytes_read: u64,
    /// Bytes written to the device, including the parameters of dispatches.
    pub bytes_written: u64,
}

impl Counters {
    /// Counts a read-back of this many bytes.
    #[cfg(feature = "gpu")]
    pub(super) fn read(&mut self, bytes: u64, waited: std::time::Duration) {
        self.reads += 1;
        self.bytes_read += bytes;
        self.wait_seconds += waited.as_secs_f64();
    }

    fn with(self, other: Counters, count: fn(u64, u64) -> u64, seconds: fn(f64, f64) -> f64) -> Counters {
        Counters {
            dispatches: count(self.dispatches, other.dispatches),
            submissions: count(self.submissions, other.submissions),
            reads: count(self.reads, other.reads),
            wait_seconds: seconds(self.wait_seconds, other.wait_seconds),
            bytes_read: count(self.bytes_read, other.bytes_read),
            bytes_written: count(self.bytes_written, other.bytes_written),
        }
    }
}

impl ops::AddAssign for Counters {
    fn add_assign(&mut self, more: Counters) {
        *self = self.with(more, |a, b| a + b, |a, b| a + b);
    }
}

impl ops::Sub for Counters {
    type Output = Counters;

    /// The counts since `before`.
    fn sub(self, before: Counters) -> Counters {
        self.with(before, u64::saturating_sub, |a, b| (a - b).max(0.0))
    }
}

/// A pipeline that was created.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct PipelineReport {
    /// The kernel's name.
    pub name: String,
    /// Seconds for validation and translation. Drivers may compile later, at first use, unless compilation at creation
    /// was requested.
    pub seconds: f64,
}

/// The work of a stage.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct StageUse {
    /// The name of the stage.
    pub stage: &'static str,
    /// Seconds of its kernels on the device, in the timed passes; `None` without timestamps. Copies between passes are
    /// not included.
    pub seconds: Option<f64>,
    /// Timed passes: dispatches of a stage that follow each other without a copy between them.
    pub passes: u64,
    /// Passes without a time: the adapter wrote no timestamp, or was lost.
    pub untimed_passes: u64,
    /// Its dispatches, read-backs and bytes. A submission or a read-back belongs to the stage recorded last. Bytes that
    /// the host wrote belong to the first stage of the next submission.
    #[cfg_attr(feature = "files", serde(flatten))]
    pub counters: Counters,
}

impl StageUse {
    /// Whether it did no work.
    #[cfg(feature = "gpu")]
    pub(super) fn is_empty(&self) -> bool {
        self.counters == Counters::default() && self.passes + self.untimed_passes == 0
    }
}

/// All buffers of one label.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct BufferUse {
    /// The label.
    pub label: String,
    /// The number of buffers.
    pub count: usize,
    /// The bytes of all of them.
    pub bytes: u64,
}

/// The profile of a device.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Profile {
    /// The adapter and its driver.
    pub adapter: String,
    /// The pipelines created, in order.
    pub pipelines: Vec<PipelineReport>,
    /// The existing buffers, the largest first.
    pub buffers: Vec<BufferUse>,
    /// The largest number of bytes of all buffers at once.
    pub peak_bytes: u64,
    /// Steps profiled.
    pub steps: u64,
    /// Wall-clock seconds since the start of the profile.
    pub wall_seconds: f64,
    /// Seconds of kernels on the device in all stages; `None` without timestamps.
    pub device_seconds: Option<f64>,
    /// Passes without a time.
    pub untimed_passes: u64,
    /// Dispatches, submissions and read-backs of all stages.
    pub counters: Counters,
    /// The work of each stage, in the order of their first use.
    pub stages: Vec<StageUse>,
}

impl Profile {
    /// The profile of a device that took `steps` steps since the start of the profile.
    pub fn of(gpu: &Gpu, steps: u64) -> Profile {
        let mut by_label: BTreeMap<String, (usize, u64)> = BTreeMap::new();
        for (label, bytes) in gpu.buffers() {
            let entry = by_label.entry(label).or_default();
            *entry = (entry.0 + 1, entry.1 + bytes);
        }
        let mut buffers: Vec<BufferUse> =
            by_label.into_iter().map(|(label, (count, bytes))| BufferUse { label, count, bytes }).collect();
        buffers.sort_by(|a, b| b.bytes.cmp(&a.bytes).then_with(|| a.label.cmp(&b.label)));
        let (wall_seconds, stages) = gpu.profiled();
        let mut counters = Counters::default();
        stages.iter().for_each(|stage| counters += stage.counters);
        Profile {
            adapter: format!("{} ({})", gpu.name(), gpu.driver()),
            pipelines: gpu.pipelines(),
            buffers,
            peak_bytes: gpu.peak_bytes(),
            steps,
            wall_seconds,
            device_seconds: stages.iter().map(|stage| stage.seconds).sum(),
            untimed_passes: stages.iter().map(|stage| stage.untimed_passes).sum(),
            counters,
            stages,
        }
    }
}

impl Profile {
    /// One line per stage, one for all of them, and their share of the wall-clock time.
    fn table(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "  {:<20} {:>9} {:>10} {:>11} {:>10} {:>9} {:>11} {:>13}",
            "stage", "device s", "dispatches", "submissions", "read-backs", "waited s", "bytes read", "bytes written"
        )?;
        let whole = ("all stages", self.device_seconds, &self.counters);
        let lines = self.stages.iter().map(|stage| (stage.stage, stage.seconds, &stage.counters));
        for (name, seconds, c) in lines.chain([whole]) {
            let seconds = seconds.map_or("-".into(), |seconds| format!("{seconds:.4}"));
            let (dispatches, submissions, reads) = (c.dispatches, c.submissions, c.reads);
            write!(out, "  {name:<20} {seconds:>9} {dispatches:>10} {submissions:>11} {reads:>10} ")?;
            writeln!(out, "{:>9.4} {:>11} {:>13}", c.wait_seconds, c.bytes_read, c.bytes_written)?;
        }
        let wall = self.wall_seconds;
        let part = |seconds: f64| 100.0 * seconds / wall.max(f64::MIN_POSITIVE);
        let waited = self.counters.wait_seconds;
        write!(out, "  of {wall:.3} s of the clock ")?;
        if let Some(seconds) = self.device_seconds {
            write!(out, "kernels took {seconds:.3} s ({:.1} %), and ", part(seconds))?;
        }
        writeln!(out, "the host waited {waited:.3} s ({:.1} %) for data", part(waited))?;
        let timed: u64 = self.stages.iter().map(|stage| stage.passes).sum();
        match (self.device_seconds, self.untimed_passes) {
            (None, _) => writeln!(out, "  the adapter has no timestamps: times of stages on the device are not known"),
            (Some(_), 0) => writeln!(out, "  all {timed} passes were timed"),
            (Some(_), untimed) => writeln!(out, "  {untimed} of {} passes could not be timed", timed + untimed),
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
        self.table(out)?;
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
