//! What of a problem a process has: all of it, or with other processes the rows of its bodies.

use super::Outcome;
use super::Solver;
use super::cpu::Cpu;
use super::drive::Drive;
use super::local::Taken;
use super::loops::{self, Chunks};
use super::product::Product;
use std::fmt::Debug;
use std::ops::Range;

/// What of a problem a process has, and what solvers that look at all rows need of the rest. All processes must ask
/// together.
pub trait Portion<const D: usize>: Clone + Debug + Default + Send + Sync {
    /// Takes a problem of so many bodies, whose rows have these pairs of places.
    fn take(&mut self, pair: &[[u32; 2]], bodies: usize);
    /// How many rows the whole problem has, of which these are here.
    fn all_rows(&self, here: usize) -> usize;
    /// The largest entry of the diagonal, and whether all numbers are finite.
    fn survey(&self, own: (f64, bool)) -> (f64, bool);
    /// `out = A x`.
    fn multiply(&self, product: &mut Product<D>, x: &[f64], out: &mut [f64]);
    /// What the chunks of all rows come to.
    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl Fn(Range<usize>) -> [f64; N],
        chunks: &Chunks,
    ) -> [f64; N];
    /// Whether threads may share its rows.
    fn has_threads(&self) -> bool;
    /// The whole problem, with its rows in their order among all.
    fn gathered(cpu: &Cpu<D, Self>) -> &Cpu<D, Self>;
    /// Solves the whole problem, by a method that each process takes alone.
    fn solve_whole<R>(
        cpu: &mut Cpu<D, Self>,
        drive: &mut Drive<Vec<f64>>,
        solve: impl FnOnce(&mut Cpu<D, Self>, &mut Drive<Vec<f64>>) -> R,
    ) -> R;
    /// Relaxes the problem that a solver has taken.
    fn relax(solver: &mut Solver<D, Self>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome;
    /// Whether a row is counted here: each is by one process.
    fn counts(&self, row: usize) -> bool;
    /// The number of a row among all.
    fn number(&self, row: usize) -> u32;
    /// The row that has this number among all, if it is here.
    fn row(&self, number: u32) -> Option<usize>;
    /// Where the bodies at these places stand among all.
    fn among_all(&self, places: [u32; 2]) -> [u32; 2];
    /// What the counts of all processes come to.
    fn sum(&self, count: usize) -> usize;
    /// Learns which bodies at the border others have flagged; they are added to those `raised` last.
    fn learn_flags(&self, flags: &mut [bool], raised: &mut Vec<u32>);
    /// The rows that all processes have taken, of those that are counted here.
    fn all_taken(&self, own: Taken<D>) -> Taken<D>;
    /// Which parts of work of these sizes are for this process.
    fn own_parts(&self, sizes: &[usize]) -> Vec<bool>;
    /// What each part came to, and in how many iterations, from those that solved them.
    fn exchange_parts(&self, sizes: &[usize], solved: Vec<(Vec<f64>, u64)>) -> Vec<(Vec<f64>, u64)>;
}

/// One process, which has all there is: it has nobody to ask.
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
        chunk: impl Fn(Range<usize>) -> [f64; N],
        chunks: &Chunks,
    ) -> [f64; N] {
        loops::join_chunks(start, join, chunk, chunks)
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
