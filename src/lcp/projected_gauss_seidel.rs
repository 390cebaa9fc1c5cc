//! Projected Gauss-Seidel: row after row, `gamma_i <- max(0, gamma_i - g_i / A_ii)`, with the velocity of the bodies
//! kept up to date (Cottle, Pang, Stone: The linear complementarity problem, section 5.2). Sequential, so for the CPU
//! only.

use super::cone::project;
use super::cpu::Cpu;
use super::drive::{Method, PATIENCE_OF_SLOW_METHODS, Point};
use super::portion::Portion;
use super::product::{add, dot, scatter};
use super::verbs::Verbs;

#[derive(Default)]
pub(crate) struct ProjectedGaussSeidel<const D: usize> {
    velocity: Vec<[f64; D]>,
}

impl<const D: usize, P: Portion<D>> Method<Cpu<D, P>> for ProjectedGaussSeidel<D> {
    fn begin(&mut self, verbs: &mut Cpu<D, P>, at: &Point<Vec<f64>>) {
        let rows = verbs.rows();
        let bodies = rows.pair.as_flattened().iter().max().map_or(0, |body| *body as usize + 1);
        self.velocity.resize(bodies, [0.0; D]);
        scatter(rows.pair, rows.jacobian, &at.x, &mut self.velocity);
    }

    /// One sweep, which costs as much as a product.
    fn step(&mut self, verbs: &mut Cpu<D, P>, at: &mut Point<Vec<f64>>) {
        let rows = verbs.rows();
        for (i, [a, b]) in rows.pair.iter().enumerate() {
            let [ja, jb] = &rows.jacobian[i];
            let (a, b) = (*a as usize, *b as usize);
            let g = rows.q[i] + dot(ja, &self.velocity[a]) + dot(jb, &self.velocity[b]);
            let x = project(at.x[i] - g * rows.inverse[i]);
            let change = x - at.x[i];
            at.x[i] = x;
            add(&mut self.velocity[a], change, ja);
            add(&mut self.velocity[b], change, jb);
        }
        verbs.count(1);
    }

    fn refresh(&mut self, verbs: &mut Cpu<D, P>, at: &mut Point<Vec<f64>>) -> bool {
        verbs.gradient(&at.x, &mut at.g);
        true
    }

    fn patience(&self) -> u64 {
        PATIENCE_OF_SLOW_METHODS
    }
}
