//! All of a state: for steps that processes do not share, and for those who ask.

use super::Domain;
use super::part::{pack_warm, sorted_warm};
use crate::bodies::{Bodies, Lineage};
use crate::step::{Divided, State};
use std::sync::OnceLock;

impl Domain {
    /// Makes the state whole on all processes, which must do so together.
    pub(in crate::backend::cpu) fn make_whole(&mut self, state: &mut State) {
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
        (self.gathered, self.everywhere) = (OnceLock::new(), OnceLock::new());
    }

    /// Whether all processes must be asked for the state.
    pub(in crate::backend::cpu) fn is_partial(&self) -> bool {
        self.part.is_some() && self.gathered.get().is_none()
    }

    /// The state with all bodies and all that is remembered of pairs, on rank 0. All processes must ask together.
    pub(in crate::backend::cpu) fn gathered<'a>(&'a self, state: &'a State) -> &'a State {
        let Some(part) = &self.part else { return state };
        self.gathered.get_or_init(|| {
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
    pub(in crate::backend::cpu) fn everywhere<'a>(&'a self, bodies: &'a Bodies) -> &'a Bodies {
        let Some(part) = &self.part else { return bodies };
        self.everywhere.get_or_init(|| part.gather(self.processes, bodies))
    }

    /// How many bodies there are on all processes.
    pub(in crate::backend::cpu) fn bodies(&self, here: usize) -> usize {
        self.part.as_ref().map_or(here, |part| part.all)
    }

    /// The number of a body that is here between two steps; none where it is a copy.
    pub(in crate::backend::cpu) fn own_number(&self, i: usize) -> Option<u32> {
        match &self.part {
            Some(part) => part.is_own(i).then(|| part.members[i]),
            None => Some(i as u32),
        }
    }

    /// What all processes have, in order; what each has by itself, where it has all bodies.
    pub(in crate::backend::cpu) fn join<const N: usize>(&self, own: Vec<[u64; N]>) -> Vec<[u64; N]> {
        if self.part.is_none() {
            return own;
        }
        let mut all = self.processes.gather(own.as_flattened()).as_chunks::<N>().0.to_vec();
        all.sort_unstable();
        all
    }

    /// The mothers that divided in the last step, by their owners; none where all processes know.
    pub(in crate::backend::cpu) fn divided(&mut self) -> Option<Vec<Divided>> {
        self.divided.take()
    }

    /// The lines of all bodies before the last step, where processes did not have them.
    pub(in crate::backend::cpu) fn lines_before(&mut self) -> Option<Vec<Lineage>> {
        self.lines_before.take()
    }

    /// Forgets what is known: a state has come from elsewhere, and all have all of it.
    pub(in crate::backend::cpu) fn forget(&mut self) {
        (self.part, self.step, self.anew, self.divided) = (None, None, false, None);
        self.ways.clear();
        (self.gathered, self.everywhere) = (OnceLock::new(), OnceLock::new());
    }

    /// Goes on without some of the bodies that are here, as the other processes do.
    pub(in crate::backend::cpu) fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        (self.gathered, self.everywhere) = (OnceLock::new(), OnceLock::new());
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
