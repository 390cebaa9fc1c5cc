//! Whether several threads are faster than one, by what iterations took so far.
//!
//! Threads that wait for each other lose where other programs use the cores: one that does not run holds up all. So a
//! solve goes on alone where a team was slower, and a team is tried again now and then. Both give the same bits.

use std::time::Duration;

/// Fewer iterations than this are no measurement.
const LEAST_ITERATIONS: u64 = 20;

/// Rounds alone after a team was slower, at first and at most; they double each time.
const ROUNDS_ALONE: u32 = 4;
const MOST_ROUNDS_ALONE: u32 = 256;

/// What iterations took.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// Nanoseconds of an iteration for each row, alone.
    alone: Option<f64>,
    /// Rounds that are still taken alone, and how many a slower team leads to.
    rounds_alone: u32,
    next_rounds_alone: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { alone: None, rounds_alone: 0, next_rounds_alone: ROUNDS_ALONE }
    }
}

impl Pace {
    /// Whether the next round is a team's.
    pub fn chooses_team(&mut self) -> bool {
        let alone = self.alone.is_none() || self.rounds_alone > 0;
        self.rounds_alone = self.rounds_alone.saturating_sub(1);
        !alone
    }

    /// Takes the next rounds alone: a team was slower, or did not come together.
    pub fn go_alone(&mut self) {
        self.rounds_alone = self.next_rounds_alone;
        self.next_rounds_alone = (2 * self.next_rounds_alone).min(MOST_ROUNDS_ALONE);
    }

    /// Notes what a round took.
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
        // What a few iterations took says nothing.
        pace.note(true, 1_000, LEAST_ITERATIONS - 1, slow);
        assert_eq!(pace.rounds_alone, ROUNDS_ALONE);
    }
}
