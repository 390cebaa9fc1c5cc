//! The Cholesky factor of a symmetric positive matrix in blocks of `D` by `D`, one row of blocks per body, by several
//! threads.
//!
//! The method is multifrontal (Duff and Reid, The multifrontal solution of indefinite sparse symmetric linear
//! equations, 1983). The bodies of a supernode are eliminated together, in a dense front of their columns and of the
//! rows below. What that changes in these rows, the front's update, is added to the front of the parent in the
//! elimination tree. Subtrees of little work, and the paths above them, are the tasks of the threads ([`task`]). Work
//! is counted, not timed, and updates are added in the order of the children, so no bit depends on the number of
//! threads.

mod front;
mod order;
mod plan;
mod solve;
mod task;

use super::sparse_cholesky::Pattern;
pub(super) use front::Blocks;
pub(super) use order::elimination_order;
use rayon::prelude::*;
use task::Task;

/// A task has at least this much work if it can, some 0.8 ms: threads take longer to share less.
const LEAST_WORK: f64 = 1e7;

/// The factor of the last matrix, and scratch space.
pub(super) struct Multifrontal<const D: usize> {
    /// In postorder, so that each task is the last one of its subtree.
    tasks: Vec<Task<D>>,
    /// See [`Multifrontal::work`].
    work: f64,
    analysed: bool,
    least_work: f64,
}

impl<const D: usize> Default for Multifrontal<D> {
    fn default() -> Self {
        Multifrontal { tasks: Vec::new(), work: 0.0, analysed: false, least_work: LEAST_WORK }
    }
}

impl<const D: usize> Multifrontal<D> {
    /// Drops the analysis and the factor, and keeps the memory.
    pub fn forget(&mut self) {
        (self.work, self.analysed) = (0.0, false);
    }

    /// Whether a pattern is analysed.
    pub fn is_analysed(&self) -> bool {
        self.analysed
    }

    /// An estimate of the multiplications of a factorization: the squares of the lengths of the factor's columns.
    pub fn work(&self) -> f64 {
        self.work
    }

    /// Analyses the pattern of a matrix whose bodies are numbered by [`elimination_order`]: its graph has an edge from
    /// each body to each later one with which it shares a block. Says whether the factor has at most `largest` entries
    /// and there is memory for it.
    pub fn analyse(&mut self, graph: Pattern<'_>, largest: usize) -> bool {
        let old = std::mem::take(&mut self.tasks);
        self.forget();
        let Some(plan) = plan::Plan::new(graph, D, self.least_work) else { return false };
        if plan.entries() > largest {
            return false;
        }
        let Some(tasks) = task::tasks(&plan, graph, old) else { return false };
        (self.tasks, self.work, self.analysed) = (tasks, plan.work(), true);
        true
    }

    /// Factorizes a matrix of the pattern that was analysed; says whether all pivots are positive.
    pub fn factorize(&mut self, blocks: Blocks<'_, D>) -> bool {
        self.analysed && eliminate(&mut self.tasks, blocks)
    }

    /// Solves with the last factor; does nothing without one.
    pub fn solve(&mut self, x: &mut [[f64; D]]) {
        if !self.analysed {
            return;
        }
        forward(&mut self.tasks, x);
        backward(&mut self.tasks);
        for task in &self.tasks {
            task.export(x);
        }
    }
}

/// Eliminates the bodies of tasks, those of each subtree before its root's.
fn eliminate<const D: usize>(tasks: &mut [Task<D>], blocks: Blocks<'_, D>) -> bool {
    let of_subtree = |tasks: &mut [Task<D>]| {
        let Some((root, below)) = tasks.split_last_mut() else { return true };
        (below.is_empty() || eliminate(below, blocks)) && root.eliminate(blocks, below)
    };
    subtrees(tasks).into_par_iter().map(of_subtree).reduce(|| true, |a, b| a && b)
}

/// Solves with the lower triangle of the factor, those of each subtree before its root.
fn forward<const D: usize>(tasks: &mut [Task<D>], right: &[[f64; D]]) {
    subtrees(tasks).into_par_iter().for_each(|tasks| {
        let Some((root, below)) = tasks.split_last_mut() else { return };
        forward(below, right);
        root.forward(right, subtrees(below).iter().filter_map(|tasks| tasks.last()));
    });
}

/// Solves with the transposed factor, each root before its subtree.
fn backward<const D: usize>(tasks: &mut [Task<D>]) {
    subtrees(tasks).into_par_iter().for_each(|tasks| {
        let Some((root, below)) = tasks.split_last_mut() else { return };
        root.backward();
        for child in subtrees(below).iter_mut().filter_map(|tasks| tasks.last_mut()) {
            child.take_outside(root);
        }
        backward(below);
    });
}

/// The subtrees of tasks in postorder, each with its root as the last one.
fn subtrees<const D: usize>(mut tasks: &mut [Task<D>]) -> Vec<&mut [Task<D>]> {
    let mut parts = Vec::new();
    while let Some(root) = tasks.last() {
        let (before, part) = tasks.split_at_mut(tasks.len() - root.subtree);
        parts.push(part);
        tasks = before;
    }
    parts.reverse();
    parts
}

#[cfg(test)]
mod tests;
