//! A process's portion of a problem: all of it, or the rows of its bodies.

use super::Outcome;
use super::Solver;
use super::cpu::Cpu;
use super::drive::Drive;
use super::loops::{self, Chunks};
use super::product::Product;
use super::taken::Taken;
use std::fmt::Debug;
use std::ops::Range;

/// A process's portion of a problem, and what solvers need of the other portions. Methods are collective.
pub trait Portion<const D: usize>: Clone + Debug + Default + Send + Sync {
    /// Loads a problem of `bodies` bodies with these pairs of positions.
    fn take(&mut self, pair: &[[u32; 2]], bodies: usize);
    /// The number of rows of the whole problem, of which these are local.
    fn all_rows(&self, here: usize) -> usize;
    /// The largest entry of the diagonal, and whether all numbers are finite.
    fn survey(&self, own: (f64, bool)) -> (f64, bool);
    /// `out = A x`.
    fn multiply(&self, product: &mut Product<D>, x: &[f64], out: &mut [f64]);
    /// Reduces the chunks of all rows.
    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
        chunks: &Chunks,
    ) -> [f64; N];
    /// Whether a process will have all rows of problems of this many bodies.
    fn is_alone(&self, bodies: usize) -> bool;
    /// Whether threads can share its rows.
    fn has_threads(&self) -> bool;
    /// The whole problem, with its rows in global order.
    fn gathered(cpu: &Cpu<D, Self>) -> &Cpu<D, Self>;
    /// Solves the whole problem with a method that is not distributed.
    fn solve_whole<R>(
        cpu: &mut Cpu<D, Self>,
        drive: &mut Drive<Vec<f64>>,
        solve: impl FnOnce(&mut Cpu<D, Self>, &mut Drive<Vec<f64>>) -> R,
    ) -> R;
    /// Solves the solver's problem by its islands, if it is distributed and has several.
    fn solve_islands(solver: &mut Solver<D, Self>, gamma: &mut [f64]) -> Option<Outcome>;
    /// Continues with the islands of the solver's last problem.
    fn resume_islands(solver: &mut Solver<D, Self>, gamma: &mut [f64]) -> Outcome;
    /// Relaxes the solver's problem.
    fn relax(solver: &mut Solver<D, Self>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome;
    /// Whether this process counts a row: one process counts each.
    fn counts(&self, row: usize) -> bool;
    /// The global index of a row.
    fn number(&self, row: usize) -> u32;
    /// The local row with this global index, if there is one.
    fn row(&self, number: u32) -> Option<usize>;
    /// The global positions of the bodies at these local positions.
    fn among_all(&self, places: [u32; 2]) -> [u32; 2];
    /// The sum of the counts of all processes.
    fn sum(&self, count: usize) -> usize;
    /// Adds to `raised` the bodies at the border that other processes have flagged.
    fn learn_flags(&self, flags: &mut [bool], raised: &mut Vec<u32>);
    /// The rows that all processes have selected, of those that each counts.
    fn all_taken(&self, own: Taken<D>) -> Taken<D>;
    /// The parts of these sizes that this process solves.
    fn own_parts(&self, sizes: &[usize]) -> Vec<bool>;
    /// Gathers each part's solution and iterations from the processes that solved them.
    fn exchange_parts(&self, sizes: &[usize], solved: Vec<(Vec<f64>, u64)>) -> Vec<(Vec<f64>, u64)>;
}

/// One process with the whole problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl<const D: usize> Portion<D> for Alone {
    fn take(&mut self, _pair: &[[u32; 2]], _bodies: usize) {}

    fn all_rows(&self, here: usize) -> usize {
        here
    }

    fn survey(&self, own: (f64, bool)) -> (f64, bool) {
        own
    }

    fn multiply(&self, product: &mut Product<D>, x: &[f64], out: &mut [f64]) {
        product.apply(x, out);
    }

    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
        chunks: &Chunks,
    ) -> [f64; N] {
        loops::join_chunks(start, join, chunk, chunks)
    }

    fn is_alone(&self, _bodies: usize) -> bool {
        true
    }

    fn has_threads(&self) -> bool {
        true
    }

    fn gathered(cpu: &Cpu<D>) -> &Cpu<D> {
        cpu
    }

    fn solve_whole<R>(
        cpu: &mut Cpu<D>,
        drive: &mut Drive<Vec<f64>>,
        solve: impl FnOnce(&mut Cpu<D>, &mut Drive<Vec<f64>>) -> R,
    ) -> R {
        solve(cpu, drive)
    }

    fn solve_islands(_solver: &mut Solver<D>, _gamma: &mut [f64]) -> Option<Outcome> {
        None
    }

    fn resume_islands(solver: &mut Solver<D>, gamma: &mut [f64]) -> Outcome {
        solver.islands.run(&Alone, gamma, solver.task.settings)
    }

    fn relax(solver: &mut Solver<D>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        solver.relax_here(gamma, allowed)
    }

    fn counts(&self, _row: usize) -> bool {
        true
    }

    fn number(&self, row: usize) -> u32 {
        row as u32
    }

    fn row(&self, number: u32) -> Option<usize> {
        Some(number as usize)
    }

    fn among_all(&self, places: [u32; 2]) -> [u32; 2] {
        places
    }

    fn sum(&self, count: usize) -> usize {
        count
    }

    fn learn_flags(&self, _flags: &mut [bool], _raised: &mut Vec<u32>) {}

    fn all_taken(&self, own: Taken<D>) -> Taken<D> {
        own
    }

    fn own_parts(&self, sizes: &[usize]) -> Vec<bool> {
        vec![true; sizes.len()]
    }

    fn exchange_parts(&self, _sizes: &[usize], solved: Vec<(Vec<f64>, u64)>) -> Vec<(Vec<f64>, u64)> {
        solved
    }
}
