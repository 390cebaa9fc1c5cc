//! What both versions share: the arguments, the poses, the field, the clock and the frames.

use rustix::time::{ClockId, clock_gettime};
use std::collections::HashMap;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::time::Instant;

/// A fault of the arguments, a file or the engine.
pub type Fault = Box<dyn Error>;

/// A centre, and an orientation as `w, x, y, z`.
pub type Pose = [f64; 7];

/// A version of the engine that holds the scene.
pub trait Engine {
    /// Gives each body the velocity of the field at its centre, or the force for it, and takes a step.
    fn step(&mut self, run: &Run);
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
    /// The radius of each rod, and half the length of its axis.
    pub sizes: Vec<[f64; 2]>,
    /// Where the field draws to.
    pub centre: [f64; 3],
    /// The stiffness of a trap in place of the field.
    pub trap: Option<f64>,
    /// A force a body in place of the field; empty where it is not given.
    pub forces: Vec<[f64; 3]>,
}

/// A rod's mass, principal inertia, and speed in a field of unit speed. The first rod's mass is 1; a mass goes with the
/// length `L` and an inertia with `L^3 / 12`, as the drag of a slender rod.
pub struct Rod {
    /// Its mass.
    pub mass: f64,
    /// Its inertia about any axis.
    pub inertia: f64,
    /// Its speed.
    pub speed: f64,
}

impl Run {
    /// The arguments alone, of a scene that is another program's.
    pub fn of_settings() -> Result<Self, Fault> {
        let split = |word: String| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned()));
        let words: Option<HashMap<_, _>> = std::env::args().skip(1).map(split).collect();
        let arguments = words.ok_or("arguments are key=value")?;
        let (dt, centre) = (0.0, [0.0; 3]);
        Ok(Run { arguments, start: Vec::new(), dt, sizes: Vec::new(), centre, trap: None, forces: Vec::new() })
    }

    /// From `key=value` words: `poses`, `frames`, `dt`, `end`, `every`, `sizes` (a file of radii and half
    /// lengths) or `radius` and `half`, `centre` along x, `trap`, `forces` (a file), `repeats`, and settings.
    pub fn from_arguments() -> Result<Self, Fault> {
        let mut run = Run::of_settings()?;
        run.dt = run.number("dt")?;
        run.centre[0] = run.setting("centre")?.unwrap_or(0.0);
        run.trap = run.setting("trap")?;
        run.start = numbers(run.word("poses")?)?.as_chunks::<7>().0.to_vec();
        run.sizes = match run.word("sizes") {
            Ok(file) => numbers(file)?.as_chunks::<2>().0.to_vec(),
            Err(_) => vec![[run.number("radius")?, run.number("half")?]; run.start.len()],
        };
        if run.sizes.len() != run.start.len() || run.sizes.is_empty() {
            return Err("as many sizes as poses, one or more".into());
        }
        if let Ok(file) = run.word("forces") {
            run.forces = numbers(file)?.as_chunks::<3>().0.to_vec();
            if run.forces.len() != run.start.len() {
                return Err("as many forces as poses".into());
            }
        }
        Ok(run)
    }

    /// What a rod of this size is.
    pub fn rod(&self, [radius, half]: [f64; 2]) -> Rod {
        let length = |[radius, half]: [f64; 2]| 2.0 * (half + radius);
        let (own, first) = (length([radius, half]), length(self.sizes[0]));
        let mass = own / first;
        Rod { mass, inertia: mass * own * own / 12.0, speed: 1.0 / mass }
    }

    /// The field's velocity at the place of a body: inward with the speed `1 - sin r / r`, in a trap its stiffness
    /// times `r`, or the force on the body, which moves the first rod with its own size.
    pub fn velocity(&self, body: usize, x: [f64; 3]) -> [f64; 3] {
        if let Some(force) = self.forces.get(body) {
            return *force;
        }
        let from = [0, 1, 2].map(|k| x[k] - self.centre[k]);
        let r = from.iter().map(|x| x * x).sum::<f64>().sqrt();
        let pull = match self.trap {
            Some(stiffness) => stiffness,
            None if r > 1e-9 => (r - r.sin()) / (r * r),
            None => 0.0,
        };
        from.map(|x| -pull * x)
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

    /// Runs the scene, as often as `repeats` says, and prints the least seconds of the steps.
    pub fn follow<E: Engine>(&self, version: &str, begin: impl Fn(&Run) -> Result<E, Fault>) -> Result<(), Fault> {
        let repeats = self.setting("repeats")?.unwrap_or(1.0).max(1.0) as u64;
        let (mut steps, mut least) = (0, f64::INFINITY);
        for _ in 0..repeats {
            let (taken, seconds) = self.once(begin(self)?)?;
            (steps, least) = (taken, least.min(seconds));
        }
        println!("{{\"version\": \"{version}\", \"steps\": {steps}, \"cpu_s\": {least:.9}}}");
        Ok(())
    }

    /// Steps to the end and writes frames; gives the steps and their seconds. Clocks are read between frames: reading
    /// the processor's takes half as long as a step of three rods. Of the steps between two frames the less of two
    /// clocks counts: the processor's counts its own reading, and the other one other programs.
    fn once(&self, mut engine: impl Engine) -> Result<(u64, f64), Fault> {
        let (end, every) = (self.number("end")?, self.number("every")?);
        let steps = (end / self.dt).round() as u64;
        let stride = ((every / self.dt).round() as u64).max(1);
        let mut frames = BufWriter::new(File::create(self.word("frames")?)?);
        let (mut step, mut seconds) = (0, 0.0);
        while step < steps {
            let block = stride.min(steps - step);
            let (from, by_clock) = (cpu(), Instant::now());
            for _ in 0..block {
                engine.step(self);
            }
            let by_clock = by_clock.elapsed().as_secs_f64();
            seconds += by_clock.min(cpu() - from);
            step += block;
            frames.write_all(&(step as f64 * self.dt).to_le_bytes())?;
            for number in engine.poses().iter().flatten() {
                frames.write_all(&number.to_le_bytes())?;
            }
        }
        frames.flush()?;
        Ok((steps, seconds))
    }
}

/// The processor's seconds of this process.
pub fn cpu() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// The numbers of a file, little-endian and of 8 bytes.
pub fn numbers(file: &str) -> Result<Vec<f64>, Fault> {
    let bytes = std::fs::read(file)?;
    Ok(bytes.as_chunks::<8>().0.iter().map(|word| f64::from_le_bytes(*word)).collect())
}
