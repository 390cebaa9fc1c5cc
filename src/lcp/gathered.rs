//! Gathers a distributed problem for methods that need all rows on each process.

use super::cpu::Cpu;
use super::domain::{Border, Domain};
use super::drive::Drive;
use super::islands::{Given, Islands, NONE, groups};
use super::loops::{self, Chunks};
use super::portion::Portion;
use super::product::Product;
use super::taken::Taken;
use super::{Outcome, Places, Problem, Solver};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// The rows of a process's domain, or all rows of a problem that is not distributed.
#[derive(Clone, Debug, Default)]
pub struct OfDomain<const D: usize> {
    /// The bodies of subsequent problems, if these are distributed.
    domain: Option<Arc<Domain>>,
    /// The exchange with the other processes.
    border: Option<Border>,
    /// The whole problem, gathered on first use.
    all: OnceLock<Box<Cpu<D, OfDomain<D>>>>,
}

impl<const D: usize> OfDomain<D> {
    /// The portion of problems of these bodies.
    pub fn of(domain: Domain) -> Self {
        OfDomain { domain: Some(Arc::new(domain)), ..OfDomain::default() }
    }

    /// The values of all rows in global order, from those of the local rows.
    fn gather_numbers(&self, numbers: &[f64]) -> Vec<f64> {
        let Some(border) = &self.border else { return numbers.to_vec() };
        let own: Vec<u64> = numbers[border.rows.clone()].iter().map(|number| number.to_bits()).collect();
        border.all_gather(&own).into_iter().map(f64::from_bits).collect()
    }

    /// The values of the local rows, from those of all rows.
    fn numbers_here(&self, all: &[f64], rows: usize) -> Vec<f64> {
        match &self.border {
            Some(border) => (0..rows).map(|row| all[border.number(row) as usize]).collect(),
            None => all.to_vec(),
        }
    }

    /// The process that solves each part: the largest part first, each to the process with the least work.
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
}

impl<const D: usize> Portion<D> for OfDomain<D> {
    fn take(&mut self, pair: &[[u32; 2]], bodies: usize) {
        let domain = self.domain.as_ref().filter(|domain| domain.among_all.len() == bodies);
        self.border = domain.map(|domain| Border::new(domain, pair));
        self.all = OnceLock::new();
    }

    fn all_rows(&self, here: usize) -> usize {
        self.border.as_ref().map_or(here, |border| border.all)
    }

    fn survey(&self, (largest, finite): (f64, bool)) -> (f64, bool) {
        let Some(border) = &self.border else { return (largest, finite) };
        let processes = border.domain.processes;
        let mut all = vec![0.0; 2 * processes.size()];
        processes.all_gather_even(&[largest, f64::from(u8::from(finite))], &mut all);
        let of = |(largest, finite): (f64, bool), one: &[f64; 2]| (largest.max(one[0]), finite && one[1] > 0.0);
        all.as_chunks::<2>().0.iter().fold((0.0, true), of)
    }

    fn multiply(&self, product: &mut Product<D>, x: &[f64], out: &mut [f64]) {
        match &self.border {
            Some(border) => border.multiply(product, x, out),
            None => product.apply(x, out),
        }
    }

    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
        chunks: &Chunks,
    ) -> [f64; N] {
        match &self.border {
            Some(border) => border.join_chunks(start, join, chunk, chunks.ranges()),
            None => loops::join_chunks(start, join, chunk, chunks),
        }
    }

    fn is_alone(&self, bodies: usize) -> bool {
        self.domain.as_ref().is_none_or(|domain| domain.among_all.len() != bodies)
    }

    fn has_threads(&self) -> bool {
        self.border.is_none()
    }

    fn gathered(cpu: &Cpu<D, Self>) -> &Cpu<D, Self> {
        match &cpu.portion.border {
            Some(border) => cpu.portion.all.get_or_init(|| Box::new(gather(cpu, border))),
            None => cpu,
        }
    }

    fn solve_whole<R>(
        cpu: &mut Cpu<D, Self>,
        drive: &mut Drive<Vec<f64>>,
        solve: impl FnOnce(&mut Cpu<D, Self>, &mut Drive<Vec<f64>>) -> R,
    ) -> R {
        if cpu.portion.border.is_none() {
            return solve(cpu, drive);
        }
        let (mut whole, mut of_whole) = (Self::gathered(cpu).clone(), Drive::default());
        whole.restart_count();
        of_whole.at.x = cpu.portion.gather_numbers(&drive.at.x);
        of_whole.history = drive.history.take();
        let solved = solve(&mut whole, &mut of_whole);
        cpu.count(whole.products_made());
        drive.at.x = cpu.portion.numbers_here(&of_whole.at.x, cpu.order.len());
        drive.history = of_whole.history;
        solved
    }

    fn solve_islands(solver: &mut Solver<D, Self>, gamma: &mut [f64]) -> Option<Outcome> {
        let tightest = solver.for_islands()?;
        let cpu = &solver.task.cpu;
        let border = cpu.portion.border.as_ref()?;
        let bodies = border.domain.bodies;
        if groups(all_moving(cpu, border).into_iter(), bodies).is_none() {
            solver.islands.forget();
            return None;
        }
        let rows = Self::gathered(cpu).rows();
        let (pair, jacobian, q) = (rows.pair.to_vec(), rows.jacobian.to_vec(), rows.q.to_vec());
        let problem = Problem { bodies, pair, jacobian, q, ..Problem::default() };
        let place: Vec<u32> = (0..bodies as u32).collect();
        let given = Given { place: &place, tightest, settings: solver.task.settings };
        solve_all(solver, gamma, |islands, all, portion| islands.solve(&problem, all, given, portion))
    }

    fn resume_islands(solver: &mut Solver<D, Self>, gamma: &mut [f64]) -> Outcome {
        let settings = solver.task.settings;
        if solver.task.cpu.portion.border.is_none() {
            return solver.islands.run(&solver.task.cpu.portion, gamma, settings);
        }
        solve_all(solver, gamma, |islands, all, portion| islands.run(portion, all, settings))
    }

    fn relax(solver: &mut Solver<D, Self>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        if solver.task.cpu.portion.border.is_none() {
            return solver.relax_here(gamma, allowed);
        }
        // Every process solves the whole problem.
        let mut x = Vec::new();
        solver.task.cpu.import(gamma, &mut x);
        let mut all = solver.task.cpu.portion.gather_numbers(&x);
        let whole = Self::gathered(&solver.task.cpu).clone();
        let domain = std::mem::replace(&mut solver.task.cpu, whole);
        let outcome = solver.relax_here(&mut all, allowed);
        solver.task.cpu = domain;
        let cpu = &solver.task.cpu;
        cpu.export(&cpu.portion.numbers_here(&all, cpu.order.len()), gamma);
        outcome
    }

    fn counts(&self, row: usize) -> bool {
        self.border.as_ref().is_none_or(|border| border.rows.contains(&row))
    }

    fn number(&self, row: usize) -> u32 {
        self.border.as_ref().map_or(row as u32, |border| border.number(row))
    }

    fn row(&self, number: u32) -> Option<usize> {
        self.border.as_ref().map_or(Some(number as usize), |border| border.row(number))
    }

    fn among_all(&self, places: [u32; 2]) -> [u32; 2] {
        self.border.as_ref().map_or(places, |border| places.map(|place| border.domain.among_all[place as usize]))
    }

    fn sum(&self, count: usize) -> usize {
        self.border.as_ref().map_or(count, |border| border.sum(count))
    }

    fn learn_flags(&self, flags: &mut [bool], raised: &mut Vec<u32>) {
        let Some(border) = &self.border else { return };
        let mut learnt = Vec::new();
        let flag = |body: u32| [f64::from(u8::from(flags[body as usize]))];
        border.exchange(&border.out, &border.into, flag, |body, [flag]| learnt.extend((flag > 0.0).then_some(body)));
        raised.extend(learnt.into_iter().filter(|body| !std::mem::replace(&mut flags[*body as usize], true)));
    }

    fn all_taken(&self, own: Taken<D>) -> Taken<D> {
        let Some(border) = &self.border else { return own };
        let mut words = Vec::with_capacity((4 + 2 * D) * own.row.len());
        for (k, [a, b]) in own.pair.iter().enumerate() {
            words.extend([u64::from(own.row[k]), u64::from(*a) << 32 | u64::from(*b)]);
            words.extend(own.jacobian[k].as_flattened().iter().map(|number| number.to_bits()));
            words.extend([own.x[k].to_bits(), own.g[k].to_bits()]);
        }
        let mut all = Taken::default();
        for words in border.all_gather(&words).chunks_exact(4 + 2 * D) {
            let block = |first: usize| std::array::from_fn(|k| f64::from_bits(words[first + k]));
            all.row.push(words[0] as u32);
            all.pair.push([(words[1] >> 32) as u32, words[1] as u32]);
            all.jacobian.push([block(2), block(2 + D)]);
            all.x.push(f64::from_bits(words[2 + 2 * D]));
            all.g.push(f64::from_bits(words[3 + 2 * D]));
        }
        all
    }

    fn own_parts(&self, sizes: &[usize]) -> Vec<bool> {
        let rank = self.border.as_ref().map(|border| border.domain.processes.rank());
        self.shares(sizes).into_iter().map(|process| rank.is_none_or(|rank| rank == process)).collect()
    }

    fn exchange_parts(&self, sizes: &[usize], solved: Vec<(Vec<f64>, u64)>) -> Vec<(Vec<f64>, u64)> {
        let Some(border) = &self.border else { return solved };
        let shares = self.shares(sizes);
        let rank = border.domain.processes.rank();
        let mut words = Vec::new();
        for ((x, iterations), _) in solved.into_iter().zip(&shares).filter(|(_, process)| **process == rank) {
            words.push(iterations);
            words.extend(x.into_iter().map(f64::to_bits));
        }
        let all = border.all_gather(&words);
        // The offset of each process's parts.
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

/// The bodies that each of all rows moves, in global order.
fn all_moving<const D: usize>(cpu: &Cpu<D, OfDomain<D>>, border: &Border) -> Vec<[u32; 2]> {
    let rows = cpu.rows();
    let word = |row: usize| {
        let of = |side: usize| match rows.jacobian[row][side] == [0.0; D] {
            true => NONE,
            false => border.domain.among_all[rows.pair[row][side] as usize],
        };
        u64::from(of(0)) << 32 | u64::from(of(1))
    };
    let own: Vec<u64> = border.rows.clone().map(word).collect();
    border.all_gather(&own).into_iter().map(|word| [(word >> 32) as u32, word as u32]).collect()
}

/// Solves with the islands of all rows.
fn solve_all<const D: usize, R>(
    solver: &mut Solver<D, OfDomain<D>>,
    gamma: &mut [f64],
    solve: impl FnOnce(&mut Islands<D>, &mut Vec<f64>, &OfDomain<D>) -> R,
) -> R {
    let mut x = Vec::new();
    solver.task.cpu.import(gamma, &mut x);
    let mut all = solver.task.cpu.portion.gather_numbers(&x);
    let solved = solve(&mut solver.islands, &mut all, &solver.task.cpu.portion);
    let cpu = &solver.task.cpu;
    cpu.export(&cpu.portion.numbers_here(&all, cpu.order.len()), gamma);
    solved
}

/// The whole problem, gathered on all processes.
fn gather<const D: usize>(cpu: &Cpu<D, OfDomain<D>>, border: &Border) -> Cpu<D, OfDomain<D>> {
    let mut all = Cpu::default();
    let domain = &border.domain;
    let rows = cpu.rows();
    let mut words = Vec::with_capacity((2 + 2 * D) * border.rows.len());
    for row in border.rows.clone() {
        let [a, b] = rows.pair[row].map(|place| u64::from(domain.among_all[place as usize]));
        words.push(a << 32 | b);
        words.extend(rows.jacobian[row].as_flattened().iter().map(|number| number.to_bits()));
        words.push(rows.q[row].to_bits());
    }
    let mut problem = Problem::<D> { bodies: domain.bodies, ..Problem::default() };
    for words in border.all_gather(&words).chunks_exact(2 + 2 * D) {
        let block = |first: usize| std::array::from_fn(|k| f64::from_bits(words[first + k]));
        problem.pair.push([(words[0] >> 32) as u32, words[0] as u32]);
        problem.jacobian.push([block(1), block(1 + D)]);
        problem.q.push(f64::from_bits(words[1 + 2 * D]));
    }
    let place = (0..domain.bodies as u32).collect();
    all.place(Places { place, blocks: domain.edges.clone() }, OfDomain::default());
    all.rebuild(&problem);
    all
}
