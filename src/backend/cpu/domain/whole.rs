//! All of a state: for steps that processes do not share, and for those who ask.

use super::Domain;
use super::part::{pack_warm, sorted_warm};
use crate::bodies::Bodies;
use crate::processes::GATHER;
use crate::step::State;
use std::sync::OnceLock;

impl Domain {
    /// Makes the state whole on all processes, which must do so together.
    pub(super) fn make_whole(&mut self, state: &mut State) {
        if !self.resting {
            self.lines_before = None;
        }
        if let Some(part) = self.part.take() {
            state.bodies = part.gather(self.processes, &state.bodies);
            state.warm = sorted_warm(&self.processes.gather(&words_of_warm(&part, state)));
            self.lines_before = Some(state.bodies.lineage.clone());
        }
        (self.step, self.divided) = (None, None);
        self.ways.clear();
        self.forget_gathered();
    }

    /// The state with all bodies and all that is remembered of pairs, on rank 0. All processes must ask together.
    pub(super) fn gather_state<'a>(&'a self, state: &'a State) -> &'a State {
        let Some(part) = &self.part else { return state };
        self.gathered.get_or_init(|| {
            if self.processes.rank() == 0 {
                self.processes.tell(&[GATHER]);
            }
            let bodies = part.gather_at_first(self.processes, &state.bodies);
            let warm = sorted_warm(&self.processes.gather_at_first(&words_of_warm(part, state)));
            if self.processes.rank() > 0 {
                return State::default();
            }
            let State { step, next_id, .. } = *state;
            State { step, next_id, bodies, warm, removed: state.removed.clone(), unrounded: None }
        })
    }

    /// All bodies, on all processes, which must ask together.
    pub(super) fn gather_bodies<'a>(&'a self, bodies: &'a Bodies) -> &'a Bodies {
        let Some(part) = &self.part else { return bodies };
        self.everywhere.get_or_init(|| part.gather(self.processes, bodies))
    }

    /// Forgets what was gathered.
    pub(super) fn forget_gathered(&mut self) {
        (self.gathered, self.everywhere) = (OnceLock::new(), OnceLock::new());
    }

    /// Goes on without some of the bodies that are here, as the other processes do.
    pub(super) fn remove_here(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        self.forget_gathered();
        let Some(part) = &mut self.part else { return state.remove(keep, removed) };
        let own = part.own().filter(|i| !keep[*i]).map(|i| u64::from(part.members[i]));
        let mut gone: Vec<u32> =
            self.processes.gather(&own.collect::<Vec<u64>>()).into_iter().map(|n| n as u32).collect();
        gone.sort_unstable();
        part.remove(&gone, state);
        state.count_removed(removed);
    }
}

/// What this process remembers for all: of pairs whose first body is its own.
fn words_of_warm(part: &super::Part, state: &State) -> Vec<u64> {
    let is_own = |body: u32| part.place(body).is_some_and(|i| part.is_own(i));
    state.warm.iter().filter(|warm| is_own(warm.pair[0])).flat_map(pack_warm).collect()
}
