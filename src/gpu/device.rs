//! An open device: its queue, its allocations, its profile, and the first fault that it reported.

use super::ensemble::Membership;
use super::kernel_cache::KernelCache;
use super::lock::lock;
use super::pending::Pending;
use super::recorder::Staging;
use super::tally::Tally;
use super::timing::Timer;
use super::{Choice, Counters, GpuError, PipelineReport, Precision, Recorder, StageUse, adapter, self_test};
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The longest time for one submission. The longest valid submission, a batch of iterations at a million rows on a
/// software adapter, takes some 10 s.
const PATIENCE: Duration = Duration::from_secs(120);

/// The largest number of bindings of one buffer. Few adapters have more than 32 bindings per kernel, and a kernel has
/// up to eight buffers.
const MOST_BANKS: u64 = 16;

/// The initial capacity of the buffers of an ensemble's members, in elements: a member has some hundred buffers.
const LEAST_CAPACITY_OF_MEMBERS: u64 = 32;

/// Every adapter accepts multiples of this as offsets of bindings.
const LEAST_BANK_BYTES: u64 = 256;

/// The existing buffers.
#[derive(Debug, Default)]
pub(super) struct Allocations {
    pub live: BTreeMap<u64, (String, u64)>,
    pub made: u64,
    pub bytes: u64,
    pub peak: u64,
}

/// Shared by buffers and the device.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub allocations: Mutex<Allocations>,
    /// Whether a buffer was dropped: bind groups that refer to it must be dropped too.
    pub stale: AtomicBool,
    fault: Mutex<Option<GpuError>>,
}

/// Keyed by the kernel, the buffer of its parameters, and its other buffers.
pub(super) type BindGroups = HashMap<(u64, Option<usize>, Vec<u64>), wgpu::BindGroup>;

/// An open device.
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    driver: String,
    software: bool,
    pub(super) limits: wgpu::Limits,
    features: wgpu::Features,
    next: AtomicU64,
    pub(super) shared: Arc<Shared>,
    pub(super) tally: Mutex<Tally>,
    /// The start of the profile, and the counts at that time.
    profiled_from: Mutex<(Instant, Tally)>,
    pub(super) pipelines: Mutex<Vec<PipelineReport>>,
    pub(super) kernels: KernelCache,
    pub(super) bind_groups: Mutex<BindGroups>,
    pub(super) pending: Mutex<Pending>,
    pub(super) staging: Mutex<Staging>,
    pub(super) reading: Mutex<()>,
    submissions: Mutex<Vec<wgpu::SubmissionIndex>>,
    pub(super) timer: Mutex<Option<Timer>>,
    warnings: Vec<String>,
    least_capacity: AtomicU64,
    most_bank_bytes: AtomicU64,
    patience_ms: AtomicU64,
    compile_at_once: AtomicBool,
    /// The membership, if the device is a member of an ensemble.
    pub(super) member: Option<Arc<Membership>>,
}

impl Gpu {
    /// Opens the adapter that fits the choice and tests that it computes correctly.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::SelfTest`], or an error of the driver.
    pub fn open(choice: &Choice) -> Result<Self, GpuError> {
        let instance = adapter::instance();
        let adapter = adapter::find(&instance, choice)?;
        let info = adapter.get_info();
        let mut limits = wgpu::Limits::default();
        if !choice.default_limits {
            let has = adapter.limits();
            limits.max_buffer_size = has.max_buffer_size;
            limits.max_storage_buffer_binding_size = has.max_storage_buffer_binding_size;
            limits.max_storage_buffers_per_shader_stage = has.max_storage_buffers_per_shader_stage;
        }
        let features = adapter.features() & (wgpu::Features::SHADER_F64 | wgpu::Features::TIMESTAMP_QUERY);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("relcp"),
            required_features: features,
            required_limits: limits.clone(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::Refused { message: e.to_string() })?;
        let shared = Arc::new(Shared::default());
        let (errors, losses) = (shared.clone(), shared.clone());
        device.on_uncaptured_error(Arc::new(move |error| errors.fail(refusal(&error))));
        device.set_device_lost_callback(move |reason, message| {
            losses.fail(GpuError::Lost { reason: format!("{reason:?} {message}").trim().to_owned() });
        });
        let mut gpu = Gpu {
            device,
            queue,
            name: info.name.clone(),
            driver: adapter::driver(&info),
            software: adapter::is_software(&info),
            limits,
            features,
            next: AtomicU64::new(1),
            shared,
            tally: Mutex::default(),
            profiled_from: Mutex::new((Instant::now(), Tally::default())),
            pipelines: Mutex::default(),
            kernels: KernelCache::default(),
            bind_groups: Mutex::default(),
            pending: Mutex::default(),
            staging: Mutex::default(),
            reading: Mutex::default(),
            submissions: Mutex::default(),
            timer: Mutex::default(),
            warnings: Vec::new(),
            least_capacity: AtomicU64::new(1024),
            most_bank_bytes: AtomicU64::new(u64::MAX),
            patience_ms: AtomicU64::new(PATIENCE.as_millis() as u64),
            compile_at_once: AtomicBool::new(false),
            member: None,
        };
        log::info!("opened {} ({}), {:?}", gpu.name, gpu.driver, gpu.features);
        gpu.warnings = self_test::run(&gpu)?;
        *lock(&gpu.tally) = Tally::default();
        lock(&gpu.pipelines).clear();
        Ok(gpu)
    }

    /// The same device for a member of an ensemble, with its own counters, buffers and faults.
    pub(super) fn of_member(&self, membership: Membership) -> Gpu {
        let of = |atomic: &AtomicU64| AtomicU64::new(atomic.load(Ordering::Relaxed));
        Gpu {
            device: self.device.clone(),
            queue: self.queue.clone(),
            name: self.name.clone(),
            driver: self.driver.clone(),
            software: self.software,
            limits: self.limits.clone(),
            features: self.features,
            next: AtomicU64::new(1),
            shared: Arc::default(),
            tally: Mutex::default(),
            profiled_from: Mutex::new((Instant::now(), Tally::default())),
            pipelines: Mutex::default(),
            kernels: KernelCache::default(),
            bind_groups: Mutex::default(),
            pending: Mutex::default(),
            staging: Mutex::default(),
            reading: Mutex::default(),
            submissions: Mutex::default(),
            timer: Mutex::default(),
            warnings: self.warnings.clone(),
            least_capacity: AtomicU64::new(LEAST_CAPACITY_OF_MEMBERS),
            most_bank_bytes: of(&self.most_bank_bytes),
            patience_ms: of(&self.patience_ms),
            compile_at_once: AtomicBool::new(false),
            member: Some(Arc::new(membership)),
        }
    }

    /// Marks the work recorded next as the beginning of a step. Members of an ensemble begin their steps together.
    pub fn begin_step(&self) {
        if let Some(member) = &self.member {
            member.begin_step();
        }
    }

    /// Tells the ensemble that this member makes no requests for a while, so that other members need not wait for it.
    pub fn rest(&self) {
        if let Some(member) = &self.member {
            member.rest();
        }
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The driver and its version.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// Whether the adapter is software that runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// Whether kernels can use 64-bit floats.
    pub fn has_f64(&self) -> bool {
        self.features.contains(wgpu::Features::SHADER_F64)
    }

    /// The default precision: f64 on software adapters that support it, where it takes as long as f32; f32 on hardware,
    /// where f64 takes 2 to 64 times as long.
    pub fn default_precision(&self) -> Precision {
        if self.is_software() && self.has_f64() { Precision::F64 } else { Precision::F32 }
    }

    /// Whether kernels can be timed.
    pub fn has_timestamps(&self) -> bool {
        self.features.contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Checks that the adapter supports a precision.
    ///
    /// # Errors
    /// [`GpuError::NoF64`].
    pub fn check(&self, precision: Precision) -> Result<(), GpuError> {
        if precision == Precision::F64 && !self.has_f64() {
            return Err(GpuError::NoF64 { adapter: self.name.clone() });
        }
        Ok(())
    }

    /// Warnings about this adapter.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The counters of the device so far.
    pub fn counters(&self) -> Counters {
        lock(&self.tally).total()
    }

    /// The pipelines created so far.
    pub fn pipelines(&self) -> Vec<PipelineReport> {
        lock(&self.pipelines).clone()
    }

    /// The existing buffers: label and bytes.
    pub fn buffers(&self) -> Vec<(String, u64)> {
        lock(&self.shared.allocations).live.values().cloned().collect()
    }

    /// The number of buffers created so far. For each new one, the device must bind kernels again.
    pub fn buffers_made(&self) -> u64 {
        lock(&self.shared.allocations).made
    }

    /// The largest number of bytes that buffers held at once.
    pub fn peak_bytes(&self) -> u64 {
        lock(&self.shared.allocations).peak
    }

    /// The largest number of elements of `bytes` each that fit in one buffer.
    pub fn most_elements(&self, bytes: usize) -> u64 {
        // The arena of an ensemble is one binding.
        let banks = if self.member.is_some() { 1 } else { MOST_BANKS };
        self.limits.max_buffer_size.min(banks * self.bank_bytes()) / bytes as u64
    }

    /// Makes drivers compile every kernel when it is created, not at its first use, by running one workgroup of it on
    /// zeros. The seconds in [`PipelineReport`] are then the whole cost of a kernel.
    pub fn compile_at_once(&self) {
        self.compile_at_once.store(true, Ordering::Relaxed);
    }

    pub(super) fn compiles_at_once(&self) -> bool {
        self.compile_at_once.load(Ordering::Relaxed)
    }

    /// The largest number of bytes that one binding covers: larger buffers are bound in several banks. A power of two.
    pub fn bank_bytes(&self) -> u64 {
        let most = self.limits.max_storage_buffer_binding_size.min(self.most_bank_bytes.load(Ordering::Relaxed));
        1 << most.max(LEAST_BANK_BYTES).ilog2()
    }

    /// Limits a binding to this many bytes from now on, rounded down to a power of two, at least 256. For tests.
    /// Kernels that were compiled for several banks do not fit afterwards, so call it before any work.
    pub fn set_bank_bytes(&self, most: u64) {
        self.most_bank_bytes.store(most, Ordering::Relaxed);
    }

    /// The smallest initial capacity of growing buffers. Tests make it small, so that every buffer must grow.
    pub fn set_least_capacity(&self, elements: u64) {
        self.least_capacity.store(elements.max(1), Ordering::Relaxed);
    }

    pub(super) fn least_capacity(&self) -> u64 {
        self.least_capacity.load(Ordering::Relaxed)
    }

    /// The longest wait for a submission, instead of two minutes.
    pub fn set_patience(&self, patience: Duration) {
        self.patience_ms.store(patience.as_millis() as u64, Ordering::Relaxed);
    }

    /// Destroys the device: all later requests return [`GpuError::Lost`].
    pub fn destroy(&self) {
        self.device.destroy();
        self.shared.fail(GpuError::Lost { reason: "it was given up".into() });
    }

    /// Begins to record work.
    pub fn record(&self) -> Recorder<'_> {
        Recorder::new(self)
    }

    /// Starts a profile: counts from now on, and times kernels by stage if the adapter supports it.
    pub fn start_timing(&self) {
        *lock(&self.profiled_from) = (Instant::now(), lock(&self.tally).clone());
        // The work of a member is timed with that of the others.
        if self.has_timestamps() && self.member.is_none() {
            *lock(&self.timer) = Some(Timer::new(self));
        }
    }

    /// Stops timing kernels, and drops the times.
    pub fn stop_timing(&self) {
        *lock(&self.timer) = None;
    }

    /// Seconds since the start of the profile, and the work of each stage since then; without a profile, all work since
    /// the device was opened. If kernels are timed, this waits for all submitted work.
    pub(super) fn profiled(&self) -> (f64, Vec<StageUse>) {
        self.hand_over();
        let mut timer = lock(&self.timer);
        if let Some(timer) = timer.as_mut() {
            timer.collect(self);
        }
        let (begun, before) = &*lock(&self.profiled_from);
        let mut before = before.clone();
        let used = |(stage, counters): (&'static str, Counters)| {
            let passes = timer.as_ref().map(|timer| timer.passes(stage));
            StageUse {
                stage,
                seconds: passes.map(|passes| passes.seconds),
                passes: passes.map_or(0, |passes| passes.timed),
                untimed_passes: passes.map_or(0, |passes| passes.untimed),
                counters: counters - *before.of(stage),
            }
        };
        let stages = lock(&self.tally).stages().into_iter().map(used);
        (begun.elapsed().as_secs_f64(), stages.filter(|stage| !stage.is_empty()).collect())
    }

    pub(super) fn new_id(&self) -> u64 {
        self.next.fetch_add(1, Ordering::Relaxed)
    }

    /// The first fault that the device reported. It persists.
    ///
    /// # Errors
    /// That fault.
    pub fn health(&self) -> Result<(), GpuError> {
        lock(&self.shared.fault).clone().map_or(Ok(()), Err)?;
        self.member.as_ref().map_or(Ok(()), |member| member.device().health())
    }

    /// Stores a submission for [`Gpu::wait`].
    pub(super) fn submitted(&self, index: wgpu::SubmissionIndex) {
        lock(&self.submissions).push(index);
    }

    /// Waits until all submitted work is done, one submission at a time: a device that makes progress does not count as
    /// hanging, however much work there is.
    ///
    /// # Errors
    /// [`GpuError::Hang`] if a submission takes two minutes, or the fault that the device reported.
    pub fn wait(&self) -> Result<(), GpuError> {
        if let Some(member) = &self.member {
            return member.ask(Vec::new()).map(|_| ());
        }
        self.hand_over();
        self.wait_for_submissions()
    }

    /// Waits for all submissions of the device.
    pub(super) fn wait_for_submissions(&self) -> Result<(), GpuError> {
        let submissions = std::mem::take(&mut *lock(&self.submissions));
        for index in submissions.into_iter().map(Some).chain([None]) {
            self.wait_for(index)?;
        }
        Ok(())
    }

    fn wait_for(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        let begun = Instant::now();
        let timeout = Some(Duration::from_millis(self.patience_ms.load(Ordering::Relaxed)));
        let polled = self.device.poll(wgpu::PollType::Wait { submission_index, timeout });
        self.health()?;
        match polled {
            Ok(_) => Ok(()),
            Err(_) => {
                // Dropping a device that hangs would wait for it, so it is leaked.
                std::mem::forget((self.device.clone(), self.queue.clone()));
                let fault = GpuError::Hang { seconds: begun.elapsed().as_secs() };
                self.shared.fail(fault.clone());
                Err(fault)
            }
        }
    }

    /// Runs `make` and returns its result, or the error that the device reported.
    pub(super) fn scoped<T>(&self, what: &str, make: impl FnOnce() -> T) -> Result<T, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = make();
        let invalid = pollster::block_on(validation.pop());
        let out_of_memory = pollster::block_on(memory.pop());
        if out_of_memory.is_some() {
            return Err(GpuError::OutOfMemory { what: what.to_owned() });
        }
        match invalid {
            Some(error) => Err(refusal(&error)),
            None => Ok(made),
        }
    }
}

impl Shared {
    /// Stores the first fault.
    pub(super) fn fail(&self, fault: GpuError) {
        lock(&self.fault).get_or_insert(fault);
    }
}

fn refusal(error: &wgpu::Error) -> GpuError {
    match error {
        wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory { what: "a buffer".into() },
        other => GpuError::Refused { message: other.to_string() },
    }
}
