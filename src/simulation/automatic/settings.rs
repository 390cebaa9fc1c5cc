//! When a machine is tried, and what that may cost.

/// When trials are made, and what they may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Fewer bodies than this are left to the CPU. A step of 1,024 cells takes one core 6 ms; a small colony was seen to
    /// take a large GPU some 15 times as long as one core, which is what it takes to hand over the work. Where the two
    /// are equal on hardware was not measured.
    pub least_bodies: usize,
    /// The part of the run's time that trials may cost.
    pub allowed_loss: f64,
    /// Seconds that opening a device and compiling its kernels is taken to last before it was done. A software adapter
    /// takes 0.8 s for a colony; drivers of hardware, which begin with empty caches, are expected to take longer.
    pub opening: f64,
    /// Steps of a trial that are not timed.
    pub warm_up: u32,
    /// Steps of a trial that are timed.
    pub trial_steps: u32,
    /// Steps of the machine in use that a trial is compared to: the last ones.
    pub reference_steps: usize,
    /// A machine goes on after its trial where its step takes at most this part of the other one's, so that equal ones
    /// do not take turns.
    pub pays: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            least_bodies: 1024,
            allowed_loss: 0.05,
            opening: 3.0,
            warm_up: 1,
            trial_steps: 8,
            reference_steps: 16,
            pays: 0.9,
        }
    }
}
