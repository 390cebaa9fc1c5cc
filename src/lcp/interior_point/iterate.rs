//! One iterate and the step from it.

use super::normal_matrix::{NormalMatrix, Refused};
use super::rows::UnitRows;
use crate::lcp::product::dot;

fn delta() -> f64 { std::env::var("DELTA").ok().and_then(|d| d.parse().ok()).unwrap_or(1e-10) }
fn theta() -> f64 { std::env::var("THETA").ok().and_then(|d| d.parse().ok()).unwrap_or(10.0) }

pub(super) struct Step;

#[derive(Default)]
pub(super) struct Iterate<const D: usize> {
    gamma: Vec<f64>,
    slack: Vec<f64>,
    g: Vec<f64>,
    v: Vec<[f64; D]>,
    weight: Vec<f64>,
    right: Vec<f64>,
    dg: Vec<f64>,
    ds: Vec<f64>,
    work: Vec<f64>,
    dv: Vec<[f64; D]>,
    info: String,
}

impl<const D: usize> Iterate<D> {
    pub fn begin(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) -> Result<(), Refused> {
        let m = rows.len();
        for x in [&mut self.gamma, &mut self.slack, &mut self.g, &mut self.weight, &mut self.right, &mut self.dg, &mut self.ds, &mut self.work] {
            x.clear();
            x.resize(m, 0.0);
        }
        for i in 0..m {
            self.weight[i] = if rows.q[i] < 0.0 { 1.0 } else { 0.0 };
            self.work[i] = -rows.q[i].min(0.0);
        }
        matrix.factorize(rows, &self.weight)?;
        rows.velocity(&self.work, &mut self.v);
        matrix.solve(&mut self.v);
        let mut shift: f64 = 0.0;
        for i in 0..m {
            let moved = rows.along(i, &self.v);
            self.slack[i] = rows.q[i] + moved;
            shift = shift.max(moved.abs()).max(-rows.q[i]);
        }
        shift *= theta();
        for i in 0..m {
            let w = self.slack[i];
            self.slack[i] = w.max(0.0) + shift;
            self.gamma[i] = (-w).max(0.0) + shift * (shift / self.slack[i]);
        }
        Ok(())
    }

    pub fn look(&mut self, rows: &UnitRows<D>) {
        rows.velocity(&self.gamma, &mut self.v);
        for i in 0..rows.len() { self.g[i] = rows.q[i] + rows.along(i, &self.v); }
    }

    pub fn infeasibility(&self) -> f64 { self.g.iter().zip(&self.slack).fold(0.0f64, |w, (a, b)| w.max((a - b).abs())) }
    pub fn describe(&self) -> String {
        let m = self.gamma.len() as f64;
        let mu = self.gamma.iter().zip(&self.slack).map(|(a, b)| a * b).sum::<f64>() / m;
        let rp = self.g.iter().zip(&self.slack).fold(0.0f64, |w, (a, b)| w.max((a - b).abs()));
        let big = self.gamma.iter().fold(0.0f64, |w, a| w.max(*a));
        format!("mu {mu:.2e} rp {rp:.2e} gmax {big:.2e} {}", self.info)
    }

    pub fn reach(&self, rows: &UnitRows<D>) -> f64 {
        let of = |y: &[f64], v: &[[f64; D]]| {
            let gain = -y.iter().zip(&rows.q).map(|(y, q)| y * q).sum::<f64>();
            let length = v.iter().map(|v| dot(v, v)).sum::<f64>().sqrt();
            if gain > 0.0 { gain / length } else { 0.0 }
        };
        let scale = rows.q.iter().fold(0.0f64, |w, q| w.max(-q));
        let a = of(&self.gamma, &self.v);
        let up: Vec<f64> = self.dg.iter().map(|d| d.max(0.0)).collect();
        let mut v = Vec::new();
        rows.velocity(&up, &mut v);
        let b = of(&up, &v);
        a.max(b) / scale
    }

    pub fn export(&self, rows: &UnitRows<D>, x: &mut [f64]) {
        x.fill(0.0);
        for (i, row) in rows.row.iter().enumerate() {
            x[*row as usize] = self.gamma[i] * rows.inverse_length[i];
        }
    }

    fn newton(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) {
        for i in 0..rows.len() { self.work[i] = self.weight[i] * self.right[i]; }
        rows.velocity(&self.work, &mut self.dv);
        matrix.solve(&mut self.dv);
        for i in 0..rows.len() {
            self.dg[i] = self.weight[i] * (self.right[i] - rows.along(i, &self.dv));
        }
    }

    fn room(&self) -> f64 {
        let mut room = f64::INFINITY;
        for i in 0..self.gamma.len() {
            if self.dg[i] < 0.0 { room = room.min(-self.gamma[i] / self.dg[i]); }
            if self.ds[i] < 0.0 { room = room.min(-self.slack[i] / self.ds[i]); }
        }
        room
    }

    pub fn advance(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) -> Result<(), Refused> {
        let m = rows.len();
        let delta = delta();
        let mut mu = 0.0;
        for i in 0..m {
            self.weight[i] = 1.0 / (delta + self.slack[i] / self.gamma[i]);
            self.right[i] = -self.g[i];
            mu += self.gamma[i] * self.slack[i];
        }
        mu /= m as f64;
        matrix.factorize(rows, &self.weight)?;
        self.newton(rows, matrix);
        for i in 0..m { self.ds[i] = -self.slack[i] * (1.0 + self.dg[i] / self.gamma[i]); }
        let part = self.room().min(1.0);
        let mut mu_aff = 0.0;
        for i in 0..m { mu_aff += (self.gamma[i] + part * self.dg[i]) * (self.slack[i] + part * self.ds[i]); }
        mu_aff /= m as f64;
        let sigma = (mu_aff / mu).powi(3);
        for i in 0..m {
            let c = sigma * mu - self.dg[i] * self.ds[i];
            self.ds[i] = c / self.gamma[i];
            self.right[i] = -self.g[i] + c / self.gamma[i];
        }
        self.newton(rows, matrix);
        for i in 0..m { self.ds[i] -= self.slack[i] * (1.0 + self.dg[i] / self.gamma[i]); }
        let step = ((1.0 - (1.0 - part).clamp(1e-6, 0.005)) * self.room()).min(1.0);
        for i in 0..m {
            self.gamma[i] += step * self.dg[i];
            self.slack[i] += step * self.ds[i];
        }
        self.info = format!("aff {part:.3} sigma {sigma:.1e} step {step:.3}");
        Ok(())
    }
}
