//! The exact solver for small systems: the dual active set method of Goldfarb and Idnani (A numerically stable dual
//! method for solving strictly convex quadratic programs, 1983) in the unknowns of the bodies, `min 1/2 |v|^2` subject
//! to `J v + q >= 0`.
//!
//! The multipliers of that program solve the LCP. Only rows that are independent of the active ones enter, so repeated,
//! parallel and zero rows need no special treatment. The active rows are kept as `Q R` with `Q` orthonormal. Memory and
//! time per iteration grow with the unknowns times the active rows: the method is for a few hundred rows.

use super::cone::{lack, project, room};
use super::cpu::{Cpu, Rows};
use super::drive::Point;
use super::portion::Portion;
use super::verbs::Verbs;
use super::{Settings, Status};
use nalgebra::DVector;

/// A row depends on the active ones if its orthogonal part is shorter than this part of its length: twenty times the
/// rounding error of two rounds of orthogonalization for a few hundred rows.
const DEPENDENT: f64 = 1e-13;

/// Violations below this part of the size of a row's terms do not count: a few roundings.
const ROUNDING: f64 = 1e-14;

#[derive(Default)]
pub(crate) struct Dense {
    /// The index of each body among those that rows refer to.
    place: Vec<usize>,
    places: usize,
    active: Vec<Active>,
    velocity: DVector<f64>,
}

/// An active row.
struct Active {
    row: usize,
    multiplier: f64,
    /// Its columns of `Q` and of `R`, which is upper triangular: the k-th column has k + 1 entries.
    q: DVector<f64>,
    r: Vec<f64>,
}

impl Dense {
    /// Solves from scratch; `at.x` becomes the solution. Iterations are steps of the active set, and each costs about a
    /// product.
    pub fn run<const D: usize, P: Portion<D>>(
        &mut self,
        cpu: &mut Cpu<D, P>,
        at: &mut Point<Vec<f64>>,
        settings: &Settings,
    ) -> (Status, u64, f64) {
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        let start = cpu.residual(&at.x, &at.g);
        let warm = at.x.clone();
        let (end, iterations) = self.active_set(&cpu.rows(), settings.max_iterations);
        cpu.count(iterations);
        at.x.fill(0.0);
        for active in &self.active {
            at.x[active.row] = project(active.multiplier);
        }
        cpu.gradient(&at.x, &mut at.g);
        let residual = cpu.residual(&at.x, &at.g);
        let status = match end {
            _ if residual <= settings.tolerance => Status::Solved,
            _ if !residual.is_finite() => Status::NotFinite,
            End::Steps => Status::MaxIterations,
            End::Optimal | End::Infeasible => Status::NoProgress,
        };
        if residual <= start {
            return (status, iterations, residual);
        }
        at.x.copy_from_slice(&warm);
        (if start <= settings.tolerance { Status::Solved } else { status }, iterations, start)
    }

    fn active_set<const D: usize>(&mut self, rows: &Rows<D>, max_steps: u64) -> (End, u64) {
        self.arrange(rows);
        let mut steps = 0;
        while let Some(row) = self.most_violated(rows) {
            let normal = self.normal(rows, row);
            let mut multiplier = 0.0;
            loop {
                if steps >= max_steps {
                    return (End::Steps, steps);
                }
                steps += 1;
                match self.advance(rows, row, &normal, &mut multiplier) {
                    Advance::Entered => break,
                    Advance::Left => {}
                    Advance::Infeasible => return (End::Infeasible, steps),
                }
            }
        }
        self.polish(rows);
        (End::Optimal, steps)
    }

    /// Numbers the bodies that rows refer to.
    fn arrange<const D: usize>(&mut self, rows: &Rows<D>) {
        let bodies = rows.pair.as_flattened().iter().max().map_or(0, |body| *body as usize + 1);
        self.place.clear();
        self.place.resize(bodies, usize::MAX);
        self.places = 0;
        for body in rows.pair.as_flattened() {
            if self.place[*body as usize] == usize::MAX {
                self.place[*body as usize] = self.places;
                self.places += 1;
            }
        }
        self.active.clear();
        self.velocity = DVector::zeros(D * self.places);
    }

    /// A row of `J` as a dense vector.
    fn normal<const D: usize>(&self, rows: &Rows<D>, row: usize) -> DVector<f64> {
        let mut normal = DVector::zeros(D * self.places);
        for (body, block) in rows.pair[row].iter().zip(&rows.jacobian[row]) {
            let first = D * self.place[*body as usize];
            for (sum, number) in normal.as_mut_slice()[first..].iter_mut().zip(block) {
                *sum += number;
            }
        }
        normal
    }

    /// `g` of a row at the current velocity, and the sum of the sizes of its terms.
    fn gap<const D: usize>(&self, rows: &Rows<D>, row: usize) -> (f64, f64) {
        let (mut g, mut size) = (rows.q[row], rows.q[row].abs());
        for (body, block) in rows.pair[row].iter().zip(&rows.jacobian[row]) {
            let first = D * self.place[*body as usize];
            for (velocity, number) in self.velocity.as_slice()[first..].iter().zip(block) {
                let term = number * velocity;
                g += term;
                size += term.abs();
            }
        }
        (g, size)
    }

    /// The row whose plane is violated by the largest distance in the space of velocities. Zero rows never enter.
    fn most_violated<const D: usize>(&self, rows: &Rows<D>) -> Option<usize> {
        let mut worst = (0.0, None);
        for row in (0..rows.q.len()).filter(|row| rows.inverse[*row] > 0.0) {
            let (g, size) = self.gap(rows, row);
            let distance = g * rows.inverse[row].sqrt();
            if g < -ROUNDING * size && distance < worst.0 && self.active.iter().all(|active| active.row != row) {
                worst = (distance, Some(row));
            }
        }
        worst.1
    }

    /// One step of the dual method towards the plane of a row. It ends at the plane, and the row enters, or when an
    /// active multiplier becomes zero, and that row leaves.
    fn advance<const D: usize>(
        &mut self,
        rows: &Rows<D>,
        row: usize,
        normal: &DVector<f64>,
        multiplier: &mut f64,
    ) -> Advance {
        let (across, mut column) = self.orthogonalize(normal);
        let length = across.norm();
        let direction = self.solve_upper(column.clone());
        let leaving = direction.iter().zip(&self.active).enumerate();
        let leaving = leaving.map(|(k, (r, active))| (room(project(active.multiplier), -r), k));
        let leaving = leaving.reduce(|first, next| if next.0 < first.0 { next } else { first });
        let independent = length > DEPENDENT * normal.norm();
        let full = if independent { lack(self.gap(rows, row).0) / (length * length) } else { f64::INFINITY };
        let part = leaving.map_or(full, |(part, _)| part.min(full));
        if part == f64::INFINITY {
            return Advance::Infeasible;
        }
        if independent {
            self.velocity.axpy(part, &across, 1.0);
        }
        for (active, r) in self.active.iter_mut().zip(&direction) {
            active.multiplier -= part * r;
        }
        *multiplier += part;
        match leaving {
            Some((first, k)) if first < full => {
                self.leave(k);
                Advance::Left
            }
            _ => {
                column.push(length);
                self.active.push(Active { row, multiplier: *multiplier, q: across / length, r: column });
                Advance::Entered
            }
        }
    }

    /// The part of a vector orthogonal to the active rows, and its components along `Q`. Two rounds keep `Q`
    /// orthonormal to rounding.
    fn orthogonalize(&self, vector: &DVector<f64>) -> (DVector<f64>, Vec<f64>) {
        let mut across = vector.clone();
        let mut column = vec![0.0; self.active.len()];
        for _ in 0..2 {
            for (active, component) in self.active.iter().zip(&mut column) {
                let along = active.q.dot(&across);
                across.axpy(-along, &active.q, 1.0);
                *component += along;
            }
        }
        (across, column)
    }

    /// `R^-1 b`.
    fn solve_upper(&self, mut b: Vec<f64>) -> Vec<f64> {
        for k in (0..b.len()).rev() {
            b[k] /= self.active[k].r[k];
            for j in 0..k {
                b[j] -= self.active[k].r[j] * b[k];
            }
        }
        b
    }

    /// Removes the k-th active row; Givens rotations make `R` triangular again.
    fn leave(&mut self, k: usize) {
        let mut orphan = self.active.remove(k).q;
        // From column k on, column j now has j + 2 entries. A rotation of the rows j and j + 1 of R clears the last
        // one.
        for j in k..self.active.len() {
            let (a, b) = (self.active[j].r[j], self.active[j].r[j + 1]);
            let length = a.hypot(b);
            let (c, s) = if length > 0.0 { (a / length, b / length) } else { (1.0, 0.0) };
            for active in &mut self.active[j..] {
                let (a, b) = (active.r[j], active.r[j + 1]);
                (active.r[j], active.r[j + 1]) = (c * a + s * b, c * b - s * a);
            }
            self.active[j].r.pop();
            // The columns of Q for the rows j and j + 1 of R: that of the removed row, and that of this active row.
            let own = &mut self.active[j].q;
            let turned = c * &orphan + s * &*own;
            orphan = c * &*own - s * &orphan;
            *own = turned;
        }
    }

    /// Solves again for the active rows, `R^T w = -q`, `v = Q w`, `R multiplier = w`, which removes the accumulated
    /// rounding errors of the steps.
    fn polish<const D: usize>(&mut self, rows: &Rows<D>) {
        let mut w: Vec<f64> = self.active.iter().map(|active| -rows.q[active.row]).collect();
        for k in 0..w.len() {
            for j in 0..k {
                w[k] -= self.active[k].r[j] * w[j];
            }
            w[k] /= self.active[k].r[k];
        }
        let multipliers = self.solve_upper(w);
        for (active, multiplier) in self.active.iter_mut().zip(multipliers) {
            active.multiplier = multiplier;
        }
    }
}

/// How the active set method ended.
enum End {
    Optimal,
    Infeasible,
    Steps,
}

/// The result of a step.
enum Advance {
    Entered,
    Left,
    Infeasible,
}
