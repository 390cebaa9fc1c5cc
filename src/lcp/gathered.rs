//! What methods that look at all rows at once need of a problem that several processes share: the whole of it on each
//! of them, or what of it others know. Where one process has all rows, that is nothing.

use super::cpu::Cpu;
use super::drive::Drive;
use super::{Places, Problem};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

impl<const D: usize> Cpu<D> {
    /// The whole problem, with its rows in their order among all: this one where no other process has a part of it. All
    /// processes must ask together.
    pub(super) fn gathered(&self) -> &Cpu<D> {
        if self.border.is_none() { self } else { self.all.get_or_init(|| Box::new(self.gather())) }
    }

    fn gather(&self) -> Cpu<D> {
        let mut all = Cpu::default();
        let Some(border) = &self.border else { return all };
        let domain = &border.domain;
        let rows = self.rows();
        let mut words = Vec::with_capacity((2 + 2 * D) * border.rows.len());
        for row in border.rows.clone() {
            let [a, b] = rows.pair[row].map(|place| u64::from(domain.among_all[place as usize]));
            words.push(a << 32 | b);
            words.extend(rows.jacobian[row].as_flattened().iter().map(|number| number.to_bits()));
            words.push(rows.q[row].to_bits());
        }
        let mut problem = Problem::<D> { bodies: domain.bodies, ..Problem::default() };
        for words in border.gather(&words).chunks_exact(2 + 2 * D) {
            let block = |first: usize| std::array::from_fn(|k| f64::from_bits(words[first + k]));
            problem.pair.push([(words[0] >> 32) as u32, words[0] as u32]);
            problem.jacobian.push([block(1), block(1 + D)]);
            problem.q.push(f64::from_bits(words[1 + 2 * D]));
        }
        let place = (0..domain.bodies as u32).collect();
        all.place(Some(Places { place, blocks: domain.edges.clone(), domain: None }));
        all.rebuild(&problem);
        all
    }

    /// The numbers of all rows in their order among all, from those of the rows here.
    pub(super) fn gather_numbers(&self, numbers: &[f64]) -> Vec<f64> {
        let Some(border) = &self.border else { return numbers.to_vec() };
        let own: Vec<u64> = numbers[border.rows.clone()].iter().map(|number| number.to_bits()).collect();
        border.gather(&own).into_iter().map(f64::from_bits).collect()
    }

    /// Those of the rows here, from the numbers of all rows.
    pub(super) fn numbers_here(&self, all: &[f64]) -> Vec<f64> {
        match &self.border {
            Some(border) => (0..self.order.len()).map(|row| all[border.number(row) as usize]).collect(),
            None => all.to_vec(),
        }
    }

    /// Whether a row is counted here: each is by one process.
    pub(super) fn counts(&self, row: usize) -> bool {
        self.border.as_ref().is_none_or(|border| border.rows.contains(&row))
    }

    /// The number of a row among all.
    pub(super) fn number(&self, row: usize) -> u32 {
        self.border.as_ref().map_or(row as u32, |border| border.number(row))
    }

    /// The row that has this number among all, if it is here.
    pub(super) fn row(&self, number: u32) -> Option<usize> {
        self.border.as_ref().map_or(Some(number as usize), |border| border.row(number))
    }

    /// The places of a row's bodies among all.
    pub(super) fn places_of(&self, row: usize) -> [u32; 2] {
        let pair = self.rows().pair[row];
        self.border.as_ref().map_or(pair, |border| pair.map(|place| border.domain.among_all[place as usize]))
    }

    /// What the counts of all processes come to.
    pub(super) fn sum(&self, count: usize) -> usize {
        self.border.as_ref().map_or(count, |border| border.sum(count))
    }

    /// Learns which bodies at the border others have flagged; they are added to those `raised` last.
    pub(super) fn learn_flags(&self, flags: &mut [bool], raised: &mut Vec<u32>) {
        let Some(border) = &self.border else { return };
        let mut learnt = Vec::new();
        let flag = |body: u32| [f64::from(u8::from(flags[body as usize]))];
        border.swap(&border.out, &border.into, flag, |body, [flag]| learnt.extend((flag > 0.0).then_some(body)));
        raised.extend(learnt.into_iter().filter(|body| !std::mem::replace(&mut flags[*body as usize], true)));
    }

    /// Which parts of work of these sizes are for this process: the largest first, each to the one with the least.
    pub(super) fn own_parts(&self, sizes: &[usize]) -> Vec<bool> {
        let rank = self.border.as_ref().map(|border| border.domain.processes.rank());
        self.shares(sizes).into_iter().map(|process| rank.is_none_or(|rank| rank == process)).collect()
    }

    /// The process that each part is for.
    fn shares(&self, sizes: &[usize]) -> Vec<usize> {
        let processes = self.border.as_ref().map_or(1, |border| border.domain.processes.size());
        let mut largest_first: Vec<usize> = (0..sizes.len()).collect();
        largest_first.sort_by_key(|part| Reverse(sizes[*part]));
        let mut least: BinaryHeap<Reverse<(usize, usize)>> = (0..processes).map(|of| Reverse((0, of))).collect();
        let mut shares = vec![0; sizes.len()];
        for part in largest_first {
            let Some(Reverse((load, process))) = least.pop() else { break };
            shares[part] = process;
            least.push(Reverse((load + sizes[part], process)));
        }
        shares
    }

    /// What each part came to, and in how many iterations, from those that solved them.
    pub(super) fn exchange_parts(&self, sizes: &[usize], solved: Vec<(Vec<f64>, u64)>) -> Vec<(Vec<f64>, u64)> {
        let Some(border) = &self.border else { return solved };
        let shares = self.shares(sizes);
        let rank = border.domain.processes.rank();
        let mut words = Vec::new();
        for ((x, iterations), _) in solved.into_iter().zip(&shares).filter(|(_, process)| **process == rank) {
            words.push(iterations);
            words.extend(x.into_iter().map(f64::to_bits));
        }
        let all = border.gather(&words);
        // Where the parts of each process begin.
        let mut next = vec![0; border.domain.processes.size() + 1];
        shares.iter().zip(sizes).for_each(|(process, size)| next[process + 1] += 1 + size);
        for process in 1..next.len() {
            next[process] += next[process - 1];
        }
        let mut of_part = |(process, size): (usize, &usize)| {
            let words = &all[next[process]..][..1 + size];
            next[process] += 1 + size;
            (words[1..].iter().copied().map(f64::from_bits).collect(), words[0])
        };
        shares.into_iter().zip(sizes).map(&mut of_part).collect()
    }
}

/// All of a problem that processes share, for a method that each of them takes alone.
pub(super) struct Whole<const D: usize> {
    pub cpu: Cpu<D>,
    pub drive: Drive<Vec<f64>>,
}

impl<const D: usize> Whole<D> {
    pub fn of(cpu: &mut Cpu<D>, drive: &mut Drive<Vec<f64>>) -> Self {
        let mut whole = Whole { cpu: cpu.gathered().clone(), drive: Drive::default() };
        whole.cpu.count_anew();
        whole.drive.at.x = cpu.gather_numbers(&drive.at.x);
        whole.drive.history = drive.history.take();
        whole
    }

    /// Goes on with what of it is here.
    pub fn give_back(self, cpu: &mut Cpu<D>, drive: &mut Drive<Vec<f64>>) {
        cpu.count(self.cpu.products_made());
        drive.at.x = cpu.numbers_here(&self.drive.at.x);
        drive.history = self.drive.history;
    }
}
