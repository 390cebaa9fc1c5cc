//! The whole state, gathered for steps that are not distributed and for output.

use super::Domain;
use super::part::{pack_warm, sorted_warm};
use crate::backend::cpu::setup::Setup;
use crate::bodies::Bodies;
use crate::processes::GATHER;
use crate::step::State;
use std::collections::BTreeMap;
use std::sync::OnceLock;

impl Domain {
    /// Gathers the whole state on all processes. Collective.
    pub(super) fn make_whole(&mut self, state: &mut State) {
        if !self.alone {
            self.lines_before = None;
        }
        if let Some(part) = self.part.take() {
            state.bodies = part.gather(self.processes, &state.bodies);
            state.warm = sorted_warm(&self.processes.all_gather(&words_of_warm(&part, state)));
            self.lines_before = Some(state.bodies.lineage.clone());
        }
        (self.step, self.divided) = (None, None);
        self.ways.clear();
        self.drop_gathered();
    }

    /// The state with all bodies and the warm start of all pairs, on rank 0. Collective.
    pub(super) fn gather_state<'a>(&'a self, setup: &Setup, state: &'a State) -> &'a State {
        let Some(part) = &self.part else { return state };
        self.whole_state.get_or_init(|| {
            if self.processes.rank() == 0 {
                self.processes.broadcast(&[GATHER]);
            }
            let mut bodies = part.gather_to_root(self.processes, &state.bodies);
            let warm = sorted_warm(&self.processes.gather_to_root(&words_of_warm(part, state)));
            if self.processes.rank() > 0 {
                return State::default();
            }
            bodies.bonds = setup.bonds.held(&bodies, &BTreeMap::new());
            let State { step, next_id, changed, ref removed, ref fields, .. } = *state;
            State {
                step,
                next_id,
                bodies,
                warm,
                removed: removed.clone(),
                changed,
                fields: fields.clone(),
                unrounded: None,
            }
        })
    }

    /// All bodies, on all processes. Collective.
    pub(super) fn gather_bodies<'a>(&'a self, bodies: &'a Bodies) -> &'a Bodies {
        let Some(part) = &self.part else { return bodies };
        self.all_bodies.get_or_init(|| part.gather(self.processes, bodies))
    }

    /// Drops the gathered copies of the state.
    pub(super) fn drop_gathered(&mut self) {
        (self.whole_state, self.all_bodies) = (OnceLock::new(), OnceLock::new());
    }

    /// Removes some of this process's bodies. Collective.
    pub(super) fn remove_local(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        self.drop_gathered();
        let Some(part) = &mut self.part else { return state.remove(keep, removed) };
        let own = part.own().filter(|i| !keep[*i]).map(|i| u64::from(part.members[i]));
        let mut gone: Vec<u32> =
            self.processes.all_gather(&own.collect::<Vec<u64>>()).into_iter().map(|n| n as u32).collect();
        gone.sort_unstable();
        part.remove(&gone, state);
        state.count_removed(removed);
    }
}

/// The warm start of the pairs whose first body is this process's.
fn words_of_warm(part: &super::Part, state: &State) -> Vec<u64> {
    let is_own = |body: u32| part.place(body).is_some_and(|i| part.is_own(i));
    state.warm.iter().filter(|warm| is_own(warm.pair[0])).flat_map(pack_warm).collect()
}
