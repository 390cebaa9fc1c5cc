//! What both versions share: the arguments, the poses, the field, the clock and the frames.

use rustix::time::{ClockId, clock_gettime};
use std::collections::HashMap;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

/// A fault of the arguments, a file or the engine.
pub type Fault = Box<dyn Error>;

/// A centre, and an orientation as `w, x, y, z`.
pub type Pose = [f64; 7];

/// A version of the engine that holds the scene.
pub trait Engine {
    /// Gives each body the velocity of the field at its centre, or the force for it, and takes a step.
    fn step(&mut self);
    /// Where the bodies are.
    fn poses(&self) -> Vec<Pose>;
}

/// A run's arguments.
pub struct Run {
    arguments: HashMap<String, String>,
    /// Where the bodies start.
    pub start: Vec<Pose>,
    /// The time step.
    pub dt: f64,
    /// The radius of a rod.
    pub radius: f64,
    /// Half the length of its axis.
    pub half: f64,
}

impl Run {
    /// From `key=value` words: `poses`, `frames`, `dt`, `end`, `every`, `radius`, `half`, and settings.
    pub fn from_arguments() -> Result<Self, Fault> {
        let split = |word: String| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
        let words: Option<HashMap<_, _>> = std::env::args().skip(1).map(split).collect();
        let mut run = Run {
            arguments: words.ok_or("arguments are key=value")?,
            start: Vec::new(),
            dt: 0.0,
            radius: 0.0,
            half: 0.0,
        };
        (run.dt, run.radius, run.half) = (run.number("dt")?, run.number("radius")?, run.number("half")?);
        let bytes = std::fs::read(run.word("poses")?)?;
        let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|word| f64::from_le_bytes(*word)).collect();
        run.start = numbers.as_chunks::<7>().0.to_vec();
        Ok(run)
    }

    /// An argument.
    pub fn word(&self, key: &str) -> Result<&str, Fault> {
        Ok(self.arguments.get(key).ok_or_else(|| format!("{key} is missing"))?)
    }

    /// An argument that is a number.
    pub fn number(&self, key: &str) -> Result<f64, Fault> {
        Ok(self.word(key)?.parse().map_err(|fault| format!("{key}: {fault}"))?)
    }

    /// A setting, where it is given.
    pub fn setting(&self, key: &str) -> Result<Option<f64>, Fault> {
        self.arguments.contains_key(key).then(|| self.number(key)).transpose()
    }

    /// Steps to the end and writes frames; prints the processor's seconds of the steps.
    pub fn follow(&self, version: &str, mut engine: impl Engine) -> Result<(), Fault> {
        let (end, every) = (self.number("end")?, self.number("every")?);
        let steps = (end / self.dt).round() as u64;
        let stride = ((every / self.dt).round() as u64).max(1);
        let mut frames = BufWriter::new(File::create(self.word("frames")?)?);
        let mut seconds = 0.0;
        for step in 1..=steps {
            let from = cpu();
            engine.step();
            seconds += cpu() - from;
            if step % stride == 0 || step == steps {
                frames.write_all(&(step as f64 * self.dt).to_le_bytes())?;
                for number in engine.poses().iter().flatten() {
                    frames.write_all(&number.to_le_bytes())?;
                }
            }
        }
        frames.flush()?;
        println!("{{\"version\": \"{version}\", \"steps\": {steps}, \"cpu_s\": {seconds:.6}}}");
        Ok(())
    }
}

/// The processor's seconds of this process.
fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The field's speed inward over the distance from the centre: `(r - sin r) / r^2`.
pub fn inward(x: [f32; 3]) -> f64 {
    let r = x.map(f64::from).iter().map(|x| x * x).sum::<f64>().sqrt();
    if r > 1e-9 { (r - r.sin()) / (r * r) } else { 0.0 }
}

/// The principal inertia of a unit mass: `L^2 / 12`, so that equal damping of both motions is the drag of a slender rod.
pub fn inertia(run: &Run) -> f32 {
    ((2.0 * (run.half + run.radius)).powi(2) / 12.0) as f32
}
