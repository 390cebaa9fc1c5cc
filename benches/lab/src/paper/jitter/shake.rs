//! How places shake from one step to the next.

use glam::DVec3;
use serde::Serialize;

/// The mean squares of first and second differences of the places of some points, by step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Shake {
    displacement: f64,
    displacements: u64,
    second: f64,
    seconds: u64,
}

impl Shake {
    /// The square of the displacement of the last two frames, and of the second difference of the last three where
    /// there are three.
    pub fn of(frames: &[Vec<DVec3>]) -> Shake {
        let mut shake = Shake::default();
        let Some([before, now]) = frames.last_chunk::<2>() else { return shake };
        shake.displacement = mean(before.iter().zip(now).map(|(a, b)| (b - a).length_squared()));
        shake.displacements = 1;
        if let Some([first, middle, last]) = frames.last_chunk::<3>() {
            let second = first.iter().zip(middle).zip(last).map(|((a, b), c)| (c - 2.0 * b + a).length_squared());
            shake.second = mean(second);
            shake.seconds = 1;
        }
        shake
    }

    /// Counts another in.
    pub fn add(&mut self, other: &Shake) {
        self.displacement += other.displacement;
        self.displacements += other.displacements;
        self.second += other.second;
        self.seconds += other.seconds;
    }

    /// Root mean square of the displacement of a step.
    pub fn displacement(&self) -> f64 {
        (self.displacement / self.displacements.max(1) as f64).sqrt()
    }

    /// Root mean square of the second difference.
    pub fn jitter(&self) -> f64 {
        (self.second / self.seconds.max(1) as f64).sqrt()
    }

    /// Jitter over displacement: 2 where every step undoes the last, near zero in smooth motion; `None` at rest.
    pub fn ratio(&self) -> Option<f64> {
        (self.displacement() > 0.0).then(|| self.jitter() / self.displacement())
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1);
    values.sum::<f64>() / count as f64
}
