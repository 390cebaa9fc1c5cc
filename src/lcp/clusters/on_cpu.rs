//! The local LCPs on the CPU, in f64: each by one thread, several at once.

use super::super::cone::{residual, worse};
use super::super::cpu::Cpu;
use super::super::drive::{Method, Point};
use super::super::loops::update;
use super::super::pair_block_cg::PairBlockCg;
use super::super::{Problem, cpu};
use super::{COMPLIANCE, LOCAL_STEPS, NOBODY, QUIET, domains};
use rayon::prelude::*;

/// The local LCPs of a problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters<const D: usize> {
    local: Vec<Local<D>>,
    /// Whether a row is in a cluster.
    covered: Vec<bool>,
}

/// One local LCP.
#[derive(Clone, Debug)]
struct Local<const D: usize> {
    /// The global indices of its rows, in its own order.
    rows: Vec<u32>,
    cpu: Cpu<D>,
    method: PairBlockCg<Vec<f64>, f64>,
    at: Point<Vec<f64>>,
    /// The result of the steps: first their start, then the displacement from it.
    displacement: Vec<f64>,
}

impl<const D: usize> Clusters<D> {
    /// The local LCPs of these rows. A side with a zero block has no mobility.
    pub fn new(bodies: usize, rows: &cpu::Rows<'_, D>) -> Self {
        let moving = |(pair, blocks): (&[u32; 2], &[[f64; D]; 2])| {
            [0, 1].map(|side: usize| if blocks[side] == [0.0; D] { NOBODY } else { pair[side] })
        };
        let sides: Vec<[u32; 2]> = rows.pair.iter().zip(rows.jacobian).map(moving).collect();
        let domains = domains(bodies, &sides);
        let mut covered = vec![false; sides.len()];
        domains.iter().flatten().for_each(|row| covered[*row as usize] = true);
        let local = domains.par_iter().map(|domain| Local::new(domain, rows)).collect();
        Clusters { local, covered }
    }

    /// Writes the sum of the local displacements for every row in a cluster. `s` is the diagonal of `A`.
    pub fn descend(&mut self, x: &[f64], g: &[f64], s: &[f64], tolerance: f64, out: &mut [f64]) {
        self.local.par_iter_mut().for_each(|local| local.descend(x, g, s, tolerance));
        for (out, covered) in out.iter_mut().zip(&self.covered) {
            *out = if *covered { 0.0 } else { *out };
        }
        // One after the other, so that the bits do not depend on threads.
        for local in &self.local {
            for (row, moved) in local.rows.iter().zip(&local.displacement) {
                out[*row as usize] += moved;
            }
        }
    }
}

impl<const D: usize> Local<D> {
    fn new(domain: &[u32], rows: &cpu::Rows<'_, D>) -> Self {
        let mut bodies: Vec<u32> = domain.iter().flat_map(|row| rows.pair[*row as usize]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let place = |body: u32| bodies.partition_point(|other| *other < body) as u32;
        let problem = Problem {
            bodies: bodies.len(),
            pair: domain.iter().map(|row| rows.pair[*row as usize].map(place)).collect(),
            jacobian: domain.iter().map(|row| rows.jacobian[*row as usize]).collect(),
            q: vec![0.0; domain.len()],
            ..Problem::default()
        };
        let mut cpu = Cpu::<D>::default();
        cpu.rebuild(&problem);
        cpu.set_compliance(COMPLIANCE);
        let rows = cpu.order().iter().map(|row| domain[*row as usize]).collect();
        Local { rows, cpu, method: PairBlockCg::new(), at: Point::default(), displacement: Vec::new() }
    }

    fn descend(&mut self, x: &[f64], g: &[f64], s: &[f64], tolerance: f64) {
        let of = |numbers: &[f64]| self.rows.iter().map(|row| numbers[*row as usize]).collect();
        self.at = Point { x: of(x), g: of(g) };
        let share = |row: &u32| residual(g[*row as usize], s[*row as usize], x[*row as usize]);
        self.displacement.clone_from(&self.at.x);
        if self.rows.iter().map(share).fold(0.0, worse) > QUIET * tolerance {
            self.method.begin(&mut self.cpu, &self.at);
            for _ in 0..LOCAL_STEPS {
                self.method.step(&mut self.cpu, &mut self.at);
            }
        }
        update(&mut self.displacement, [&self.at.x], |start, [end]| end - start);
    }
}
