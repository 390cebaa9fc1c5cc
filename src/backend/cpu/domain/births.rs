//! Births on several processes: each divides its own cells, and the daughters are numbered as one process would.

use super::Domain;
use crate::backend::cpu::start::Start;
use crate::step::{Divided, State};

/// The bodies that an attempt begins with.
#[derive(Default)]
pub(super) struct Births {
    /// The global indices of the own ones, ascending: daughters come last.
    pub numbers: Vec<u32>,
    /// How many there are on all processes.
    pub all: usize,
}

impl Domain {
    /// Gives the daughters of own cells their global indices and ids. `mothers` are indices of the own bodies of
    /// `start` that divided; one daughter of each is at the end of `start`.
    pub(super) fn number_daughters(&mut self, start: &mut Start, state: &State, mothers: &[usize]) {
        let Some(part) = &self.part else { return };
        let own: Vec<usize> = part.own().collect();
        let mut numbers: Vec<u32> = own.iter().map(|i| part.members[*i]).collect();
        let dividing: Vec<u64> = mothers.iter().map(|mother| u64::from(numbers[*mother])).collect();
        let mut births = self.processes.all_gather(&dividing);
        births.sort_unstable();
        for (k, mother) in mothers.iter().enumerate() {
            let rank = births.partition_point(|other| *other < u64::from(numbers[*mother]));
            let first = state.next_id + 2 * rank as u64;
            start.bodies.lineage[*mother].id = first;
            start.bodies.lineage[own.len() + k].id = first + 1;
            numbers.push((part.all + rank) as u32);
        }
        start.next_id = state.next_id + 2 * births.len() as u64;
        let mother = |place: &usize| {
            let (number, line) = (numbers[*place], state.bodies.lineage[own[*place]]);
            Divided { number, line, group: state.bodies.group[own[*place]], time: start.time }
        };
        self.dividing = mothers.iter().map(mother).collect();
        self.births = Births { numbers, all: part.all + births.len() };
    }
}
