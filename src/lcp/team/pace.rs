//! Decides whether several threads are faster than one, by the measured times of iterations.
//!
//! Threads that wait for each other are slow if other programs use the cores: one that does not run delays all. So a
//! solve continues on one thread if a team was slower, and tries a team again at intervals. Both give the same bits.

use std::time::Duration;

/// Fewer iterations than this are no measurement.
const LEAST_ITERATIONS: u64 = 20;

/// Rounds on one thread after a team was slower: the first number and the largest; it doubles each time.
const ROUNDS_ALONE: u32 = 4;
const MOST_ROUNDS_ALONE: u32 = 256;

/// The measured times of iterations.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// Nanoseconds per iteration and row on one thread.
    alone: Option<f64>,
    /// The remaining rounds on one thread, and the number after the next slower team.
    rounds_alone: u32,
    next_rounds_alone: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { alone: None, rounds_alone: 0, next_rounds_alone: ROUNDS_ALONE }
    }
}

impl Pace {
    /// Whether a team takes the next round.
    pub fn chooses_team(&mut self) -> bool {
        let alone = self.alone.is_none() || self.rounds_alone > 0;
        self.rounds_alone = self.rounds_alone.saturating_sub(1);
        !alone
    }

    /// Takes the next rounds on one thread: a team was slower, or did not assemble.
    pub fn go_alone(&mut self) {
        self.rounds_alone = self.next_rounds_alone;
        self.next_rounds_alone = (2 * self.next_rounds_alone).min(MOST_ROUNDS_ALONE);
    }

    /// Records the time of a round.
    pub fn note(&mut self, team: bool, rows: usize, iterations: u64, time: Duration) {
        if iterations < LEAST_ITERATIONS || rows == 0 {
            return;
        }
        let now = time.as_nanos() as f64 / (iterations as f64 * rows as f64);
        match self.alone {
            Some(alone) if team && now > alone => self.go_alone(),
            _ if team => self.next_rounds_alone = ROUNDS_ALONE,
            _ => self.alone = Some(now),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_team_that_is_slower_is_tried_less_and_less_often() {
        let (slow, fast) = (Duration::from_millis(3), Duration::from_millis(1));
        let mut pace = Pace::default();
        assert!(!pace.chooses_team(), "nothing is known yet");
        pace.note(false, 1_000, 100, Duration::from_millis(2));
        let mut alone = Vec::new();
        for time in [slow, slow, slow, fast, slow] {
            let waited = (0..).take_while(|_| !pace.chooses_team()).count() as u32;
            alone.push(waited);
            pace.note(true, 1_000, 100, time);
        }
        assert_eq!(alone, [0, ROUNDS_ALONE, 2 * ROUNDS_ALONE, 4 * ROUNDS_ALONE, 0]);
        // The time of a few iterations is not significant.
        pace.note(true, 1_000, LEAST_ITERATIONS - 1, slow);
        assert_eq!(pace.rounds_alone, ROUNDS_ALONE);
    }
}
