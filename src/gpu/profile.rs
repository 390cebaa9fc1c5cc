//! A profile of a device: counts of pipelines, buffers, dispatches and read-backs, and the time of each stage where the
//! adapter supports timestamps.

use super::Gpu;
use std::collections::BTreeMap;
use std::fmt;
use std::ops;

/// What a device did, and how long the host waited for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct Counters {
    /// Dispatches recorded, indirect ones too.
    pub dispatches: u64,
    /// Submissions.
    pub submissions: u64,
    /// Times that the host waited for data.
    pub reads: u64,
    /// Seconds that it waited for data.
    pub wait_seconds: f64,
    /// Bytes read back.
    pub bytes_read: u64,
    /// Bytes written to the device, with the parameters of dispatches.
    pub bytes_written: u64,
}

impl Counters {
    /// Counts a read-back of so many bytes.
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

    /// What was counted since `before`.
    fn sub(self, before: Counters) -> Counters {
        self.with(before, u64::saturating_sub, |a, b| (a - b).max(0.0))
    }
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

/// What a stage did.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize))]
pub struct StageUse {
    /// The stage.
    pub stage: &'static str,
    /// Seconds of its kernels on the device, in the passes that were timed; none where the adapter has no timestamps.
    /// Copies between passes are not in it.
    pub seconds: Option<f64>,
    /// Passes timed: dispatches of a stage that follow each other without a copy between them.
    pub passes: u64,
    /// Passes that could not be timed: the adapter wrote no time, or was lost.
    pub untimed_passes: u64,
    /// Its dispatches, read-backs and bytes. A submission or a read-back is that of the stage recorded last, bytes that
    /// the host wrote are those of the first stage of the submission that followed.
    #[cfg_attr(feature = "files", serde(flatten))]
    pub counters: Counters,
}

impl StageUse {
    /// Whether it did nothing.
    #[cfg(feature = "gpu")]
    pub(super) fn is_empty(&self) -> bool {
        self.counters == Counters::default() && self.passes + self.untimed_passes == 0
    }
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
    /// Steps profiled.
    pub steps: u64,
    /// Seconds of the clock since the profile was begun.
    pub wall_seconds: f64,
    /// Seconds of kernels on the device, of all stages; none where the adapter has no timestamps.
    pub device_seconds: Option<f64>,
    /// Passes that could not be timed.
    pub untimed_passes: u64,
    /// Dispatches, submissions, read-backs of all stages.
    pub counters: Counters,
    /// What each stage did, in the order in which stages were first met.
    pub stages: Vec<StageUse>,
}

impl Profile {
    /// The profile of a device that took `steps` steps since the profile was begun.
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
    /// A line a stage, one for all of them, and what of the clock they are.
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
