//! An iterate and the step from it: multipliers and slacks of unit rows, all positive.

use super::contradiction;
use super::normal_matrix::{NormalMatrix, Refused};
use super::rows::UnitRows;

/// The proximal term: `A + REGULARIZATION` stands for `A` in a step. TODO evidence
const REGULARIZATION: f64 = 1e-10;

/// Where multipliers and slacks start, in units of the violations and what mends them. On the stored systems 1, 10 and 100 take 115, 96
/// and 107 factorizations in all.
const START: f64 = 10.0;

/// A step leaves at least and at most this part of the way to the first bound, between them the part by which the predicted step fell
/// short. 
const SHORTEST_OF: f64 = 1e-6;
const LONGEST_OF: f64 = 5e-3;

/// Weights of the second-order correction that are tried, from one to zero in equal steps. TODO evidence
const BLENDS: u32 = 4;

/// A smaller weight must lengthen the step by this factor.
const LONGER: f64 = 1.01;

/// A direction in multipliers and slacks.
#[derive(Default)]
struct Direction {
    gamma: Vec<f64>,
    slack: Vec<f64>,
}

/// The iterate, and room for its step.
#[derive(Default)]
pub(super) struct Iterate<const D: usize> {
    gamma: Vec<f64>,
    slack: Vec<f64>,
    /// `q + A gamma`.
    g: Vec<f64>,
    weight: Vec<f64>,
    right: Vec<f64>,
    work: Vec<f64>,
    velocity: Vec<[f64; D]>,
    first: Direction,
    second: Direction,
    /// Products with a half of `A` made since [`Iterate::reset`].
    pub products: u64,
}

impl<const D: usize> Iterate<D> {
    /// Forgets all.
    pub fn reset(&mut self) {
        self.products = 0;
        self.first.gamma.clear();
    }

    /// Starts where the violated rows alone, as springs, would push; all rows equally complementary where they can be.
    pub fn begin(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) -> Result<(), Refused> {
        let fill = |x: &mut Vec<f64>, value: &dyn Fn(f64) -> f64| {
            x.clear();
            x.extend(rows.q.iter().map(|q| value(*q)));
        };
        fill(&mut self.weight, &|q| if q < 0.0 { 1.0 } else { 0.0 });
        fill(&mut self.work, &|q| (-q).max(0.0));
        fill(&mut self.right, &|_| 0.0);
        matrix.factorize(rows, &self.weight)?;
        rows.velocity(&self.work, &mut self.velocity);
        matrix.solve(&mut self.velocity);
        self.products += 2;
        self.g.clear();
        self.g.extend((0..rows.len()).map(|i| rows.along(i, &self.velocity)));
        let shift = START * self.g.iter().fold(rows.deepest, |largest, moved| largest.max(moved.abs()));
        let gap = || rows.q.iter().zip(&self.g).map(|(q, moved)| q + moved);
        self.slack.clear();
        self.slack.extend(gap().map(|gap| gap.max(0.0) + shift));
        self.gamma.clear();
        self.gamma.extend(gap().zip(&self.slack).map(|(gap, slack)| (-gap).max(0.0) + shift * (shift / slack)));
        Ok(())
    }

    /// The multipliers of the problem's rows.
    pub fn export(&self, rows: &UnitRows<D>, x: &mut [f64]) {
        x.fill(0.0);
        for ((row, gamma), inverse) in rows.row.iter().zip(&self.gamma).zip(&rows.inverse_length) {
            x[*row as usize] = gamma * inverse;
        }
    }

    /// Takes `g` of the problem's rows.
    pub fn look(&mut self, rows: &UnitRows<D>, g: &[f64]) {
        for ((own, row), inverse) in self.g.iter_mut().zip(&rows.row).zip(&rows.inverse_length) {
            *own = g[*row as usize] * inverse;
        }
    }

    /// How far slacks are from the gaps, at most.
    pub fn infeasibility(&self) -> f64 {
        self.g.iter().zip(&self.slack).fold(0.0, |largest, (g, slack)| largest.max((g - slack).abs()))
    }

    /// Whether the last step proves that the rows have no solution.
    pub fn contradicts(&mut self, rows: &UnitRows<D>) -> bool {
        if self.first.gamma.is_empty() {
            return false;
        }
        self.work.clear();
        self.work.extend(self.first.gamma.iter().map(|change| change.max(0.0)));
        rows.velocity(&self.work, &mut self.velocity);
        self.products += 1;
        contradiction::proven(rows, &self.work, &self.velocity)
    }

    /// Takes one step.
    pub fn advance(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) -> Result<(), Refused> {
        for (weight, (gamma, slack)) in self.weight.iter_mut().zip(self.gamma.iter().zip(&self.slack)) {
            *weight = 1.0 / (REGULARIZATION + slack / gamma);
        }
        matrix.factorize(rows, &self.weight)?;
        let (mut first, mut second) = (std::mem::take(&mut self.first), std::mem::take(&mut self.second));
        // The predictor aims at the bounds; how far it gets says how much centring the step needs.
        self.newton(rows, matrix, |_| 0.0, true, &mut first);
        let part = self.room(&first, &second, 0.0).min(1.0);
        let centre = self.centre(&first, part);
        self.newton(rows, matrix, |i| -first.gamma[i] * first.slack[i], false, &mut second);
        self.newton(rows, matrix, |_| centre, true, &mut first);
        let blend = self.blend(&first, &second);
        for (first, second) in [(&mut first.gamma, &second.gamma), (&mut first.slack, &second.slack)] {
            for (first, second) in first.iter_mut().zip(second) {
                *first += blend * second;
            }
        }
        let short = (1.0 - part).clamp(SHORTEST_OF, LONGEST_OF);
        let step = ((1.0 - short) * self.room(&first, &second, 0.0)).min(1.0);
        for (x, change) in [(&mut self.gamma, &first.gamma), (&mut self.slack, &first.slack)] {
            for (x, change) in x.iter_mut().zip(change) {
                *x += step * change;
            }
        }
        (self.first, self.second) = (first, second);
        Ok(())
    }

    /// The Newton direction towards `gamma slack = pull`, and towards slacks equal to the gaps, if `whole`; otherwise only what a
    /// change of `gamma slack` by `pull` adds to it.
    fn newton(
        &mut self,
        rows: &UnitRows<D>,
        matrix: &mut NormalMatrix<D>,
        pull: impl Fn(usize) -> f64,
        whole: bool,
        out: &mut Direction,
    ) {
        for i in 0..rows.len() {
            let gap = if whole { self.g[i] } else { 0.0 };
            self.right[i] = pull(i) / self.gamma[i] - gap;
            self.work[i] = self.weight[i] * self.right[i];
        }
        rows.velocity(&self.work, &mut self.velocity);
        matrix.solve(&mut self.velocity);
        self.products += 2;
        let away = if whole { 1.0 } else { 0.0 };
        let mut change = std::mem::take(&mut out.gamma);
        change.clear();
        change.extend((0..rows.len()).map(|i| self.weight[i] * (self.right[i] - rows.along(i, &self.velocity))));
        out.slack.clear();
        let slack = |i: usize| (pull(i) - self.slack[i] * change[i]) / self.gamma[i] - away * self.slack[i];
        out.slack.extend((0..rows.len()).map(slack));
        out.gamma = change;
    }

    /// `gamma slack` that a step aims at, Mehrotra's cubic rule.
    fn centre(&self, predicted: &Direction, part: f64) -> f64 {
        let (mut now, mut then) = (0.0, 0.0);
        for i in 0..self.gamma.len() {
            now += self.gamma[i] * self.slack[i];
            then += (self.gamma[i] + part * predicted.gamma[i]) * (self.slack[i] + part * predicted.slack[i]);
        }
        (then / now).powi(3) * now / self.gamma.len() as f64
    }

    /// The weight of the second-order correction that allows the longest step.
    fn blend(&self, first: &Direction, second: &Direction) -> f64 {
        let (mut longest, mut best) = (0.0, 1.0);
        for k in 0..=BLENDS {
            let blend = 1.0 - f64::from(k) / f64::from(BLENDS);
            let room = self.room(first, second, blend).min(1.0);
            if room > LONGER * longest {
                (longest, best) = (room, blend);
            }
            if room >= 1.0 {
                break;
            }
        }
        best
    }

    /// How far `first + blend second` goes before a multiplier or a slack is zero.
    fn room(&self, first: &Direction, second: &Direction, blend: f64) -> f64 {
        let mut room = f64::INFINITY;
        let halves = [(&self.gamma, &first.gamma, &second.gamma), (&self.slack, &first.slack, &second.slack)];
        for (x, first, second) in halves {
            for i in 0..x.len() {
                let change = if blend == 0.0 { first[i] } else { first[i] + blend * second[i] };
                if change < 0.0 {
                    room = room.min(-x[i] / change);
                }
            }
        }
        room
    }
}
