//! The distribution of bodies over processes: blocks of near bodies, about the same work for each process.

use super::members::{Known, Member, words};
use super::part::{Part, WARM, pack_warm, warm_of};
use super::{halo, order};
use crate::bisection;
use crate::bodies::Bodies;
use crate::periodic::Periods;
use crate::processes::Processes;
use crate::walls::surface_of;
use crate::warm::Warm;
use std::ops::Range;

/// How all bodies of a step are distributed.
pub(super) struct Sharing {
    pub all: usize,
    /// The edges of all blocks.
    pub edges: Vec<u32>,
    /// The blocks of each process.
    pub blocks: Vec<Range<usize>>,
    /// Of this process's former bodies: their positions in the block order and their new owners.
    place: Vec<u32>,
    owner: Vec<u32>,
}

impl Sharing {
    /// Distributes `all` bodies, of which this process has these, over the first `sharing` processes. `work` is the
    /// cost of each.
    pub fn new(
        processes: Processes,
        (numbers, bodies): (&[u32], &Bodies),
        periods: Periods,
        work: &[f64],
        (sharing, all): (usize, usize),
    ) -> Self {
        let centres: Vec<glam::DVec3> = bodies.position.iter().map(|x| periods.wrapped(*x).0).collect();
        let place = order::places(processes, &centres, numbers, all);
        let edges = bisection::edges(all, bisection::cuts(all));
        let block = |place: &u32| edges.partition_point(|edge| edge <= place) - 1;
        let mut of_blocks = std::collections::BTreeMap::new();
        for (place, work) in place.iter().zip(work) {
            *of_blocks.entry(block(place)).or_insert(0.0) += work;
        }
        let own: Vec<u64> =
            of_blocks.into_iter().flat_map(|(block, work): (usize, f64)| [block as u64, work.to_bits()]).collect();
        let mut work = vec![0.0; edges.len() - 1];
        // Work is counted in halves of a row, so that its sums are exact in any order.
        for [block, of_process] in processes.all_gather(&own).as_chunks::<2>().0 {
            work[*block as usize] += f64::from_bits(*of_process);
        }
        let blocks = share(&work, sharing, processes.size());
        let of_process = |(process, own): (u32, &Range<usize>)| own.clone().map(move |_| process);
        let whose: Vec<u32> = (0..).zip(&blocks).flat_map(of_process).collect();
        let owner = place.iter().map(|place| whose[block(place)]).collect();
        Sharing { all, edges, blocks, place, owner }
    }

    /// Sends the bodies of each process to it, with how far they may go and what slows their growth. Returns those of
    /// this one, and which process each came from.
    pub fn send(
        &self,
        processes: Processes,
        (numbers, bodies): (&[u32], &Bodies),
        way: &[f64],
        slowing: &[f64],
    ) -> (Vec<Member>, Vec<u32>) {
        let mut lists = vec![Vec::new(); processes.size()];
        for i in 0..numbers.len() {
            let slowing = slowing.get(i).copied().unwrap_or(0.0);
            let known = Known { number: numbers[i], place: self.place[i], way: way[i], slowing };
            lists[self.owner[i] as usize].extend(words(&known, bodies, i));
        }
        let come = processes.all_to_all(lists);
        let mut come: Vec<Member> = halo::arrived(&come).collect();
        come.sort_unstable_by_key(|(_, words)| words[0]);
        let from = come.iter().map(|(process, _)| *process).collect();
        let rank = processes.rank() as u32;
        (come.into_iter().map(|(_, words)| (rank, words)).collect(), from)
    }

    /// Collects the warm start of the pairs of this process's new bodies, with global indices, from the former owners
    /// in `part`. The distributed bodies begin with those of `part`.
    pub fn hand_over(&self, processes: Processes, part: &Part, warm: &[Warm]) -> Vec<Warm> {
        let rank = processes.rank() as u32;
        let mut owner = vec![u32::MAX; part.members.len()];
        part.own().zip(&self.owner).for_each(|(i, process)| owner[i] = *process);
        // Whose the copies are now.
        let of = |places: &Vec<u32>| places.iter().map(|i| u64::from(owner[*i as usize])).collect();
        let out: Vec<(usize, Vec<u64>)> = part.out.iter().map(|(to, places)| (*to, of(places))).collect();
        let mut into: Vec<(usize, Vec<u64>)> =
            part.into.iter().map(|(from, places)| (*from, vec![0; places.len()])).collect();
        processes.exchange(&out, &mut into, || {});
        for ((_, places), (_, owners)) in part.into.iter().zip(into) {
            places.iter().zip(owners).for_each(|(i, process)| owner[*i as usize] = process as u32);
        }
        let bodies = |warm: &Warm| {
            let [a, b] = warm.pair;
            [part.place(a), part.place(b).filter(|_| surface_of(b).is_none())].into_iter().flatten()
        };
        let mut own: Vec<Warm> = warm.iter().filter(|warm| bodies(warm).any(|i| owner[i] == rank)).copied().collect();
        let mut lists = vec![Vec::new(); processes.size()];
        for warm in warm.iter().filter(|warm| part.place(warm.pair[0]).is_some_and(|a| part.is_own(a))) {
            let has: Vec<u32> = bodies(warm).map(|i| part.owner[i]).collect();
            let mut needs: Vec<u32> = bodies(warm).map(|i| owner[i]).collect();
            needs.dedup();
            for process in needs.into_iter().filter(|process| !has.contains(process)) {
                lists[process as usize].extend(pack_warm(warm));
            }
        }
        let come = processes.all_to_all(lists).concat();
        own.extend(come.as_chunks::<WARM>().0.iter().map(warm_of));
        own.sort_unstable_by_key(|warm| (warm.pair, warm.feature));
        own
    }
}

/// The blocks of each process: consecutive ones, of about the same work, for the first `sharing` of all.
fn share(work: &[f64], sharing: usize, all: usize) -> Vec<Range<usize>> {
    let mut until = vec![0.0];
    for work in work {
        until.push(until[until.len() - 1] + work);
    }
    let (total, blocks) = (until[until.len() - 1], work.len());
    let edge = |process: usize| {
        if process >= sharing {
            return blocks;
        }
        let wanted = total * process as f64 / sharing as f64;
        let above = until.partition_point(|sum| *sum < wanted).clamp(1, blocks);
        let below = above - 1;
        let nearest = if until[above] - wanted < wanted - until[below] { above } else { below };
        // Each has a block at least.
        nearest.clamp(process, blocks - (sharing - process))
    };
    (0..all).map(|process| edge(process)..edge(process + 1)).collect()
}
