//! header TODO

mod iterate;
mod normal_matrix;
mod rows;

use super::cpu::Cpu;
use super::drive::Point;
use super::verbs::Verbs;
use super::{Settings, Status};
use iterate::{Iterate, Step};
use normal_matrix::{NormalMatrix, Refused};
use rows::UnitRows;

const MOST_ITERATIONS: u64 = 200;
const PATIENCE: u64 = 15;

#[derive(Default)]
pub(crate) struct InteriorPoint<const D: usize> {
    rows: UnitRows<D>,
    matrix: NormalMatrix<D>,
    iterate: Iterate<D>,
    best: Vec<f64>,
    /// Factorizations of the last solve.
    pub factorizations: u64,
}

impl<const D: usize> InteriorPoint<D> {
    pub fn run(&mut self, cpu: &mut Cpu<D>, at: &mut Point<Vec<f64>>, settings: &Settings) -> (Status, u64, f64) {
        self.factorizations = 0;
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        let mut residual = cpu.residual(&at.x, &at.g);
        if residual <= settings.tolerance {
            return (Status::Solved, 0, residual);
        }
        self.rows.rebuild(&cpu.rows());
        let (status, iterations) = self.iterate(cpu, at, settings, &mut residual);
        (status, iterations, residual)
    }

    fn iterate(&mut self, cpu: &mut Cpu<D>, at: &mut Point<Vec<f64>>, settings: &Settings, residual: &mut f64) -> (Status, u64) {
        if self.matrix.analyse(&self.rows).is_err() {
            return (Status::NoProgress, 0);
        }
        eprintln!("rows {} bodies {} factor {}", self.rows.len(), self.rows.bodies, self.matrix.factor_len());
        self.best.clone_from(&at.x);
        let tolerance = settings.tolerance;
        self.factorizations += 1;
        if let Err(_) = self.iterate.begin(&self.rows, &mut self.matrix) {
            return (Status::NotFinite, 0);
        }
        let mut marked = (f64::INFINITY, 0); let mut marked_rp = f64::INFINITY;
        let mut k = 0;
        loop {
            self.iterate.look(&self.rows);
            self.iterate.export(&self.rows, &mut at.x);
            cpu.gradient(&at.x, &mut at.g);
            let now = cpu.residual(&at.x, &at.g);
            eprintln!("{k} residual {now:.3e} {}", self.iterate.describe());
            if now <= tolerance {
                *residual = now;
                return (Status::Solved, k);
            }
            if now < *residual {
                *residual = now;
                self.best.clone_from(&at.x);
            }
            let rp = self.iterate.infeasibility(); if rp < 0.5 * marked_rp { marked_rp = rp; marked.1 = k; }
            if now < 0.5 * marked.0 { marked = (now, k); }
            let end = if self.iterate.reach(&self.rows) > 1e10 {
                eprintln!("certificate");
                Some(Status::NoProgress)
            } else if k - marked.1 > PATIENCE { Some(Status::NoProgress) }
            else if k >= settings.max_iterations.min(MOST_ITERATIONS) { Some(Status::MaxIterations) } else { None };
            if let Some(end) = end {
                at.x.clone_from(&self.best);
                return (end, k);
            }
            self.factorizations += 1;
            if let Err(e) = self.iterate.advance(&self.rows, &mut self.matrix) {
                eprintln!("{e:?}");
                at.x.clone_from(&self.best);
                return (Status::NotFinite, k);
            }
            k += 1;
        }
    }
}
