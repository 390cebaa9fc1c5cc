//! An iterate and the step from it: multipliers and slacks of unit rows, all positive.

use super::contradiction;
use super::normal_matrix::{NormalMatrix, Refused};
use super::rows::{UnitRows, fill, fold, sums};
use crate::lcp::cone::{Inner, is_outside, lack, project, residual, worse};

/// The proximal term: a step uses `A + REGULARIZATION` in place of `A`, with rows of length one. Measured (November
/// 2026) on the five stored systems, 700 random ones with repeated, opposite or nearly opposite rows, and 120
/// contradictory ones: 1e-10, 1e-11 and 1e-12 take 105, 97 and 95 steps for the stored ones, at most 33, 25 and 23 for
/// one system; the others differ by 3 %. At 1e-8 some need three times the steps, and velocities of nearly parallel
/// rows have errors of 3e-7.
const REGULARIZATION: f64 = 1e-12;

/// The start of multipliers and slacks, in units of the violations and of the multipliers that correct them. On the
/// stored systems 1, 3, 10, 30 and 100 take 134, 103, 95, 98 and 108 steps in total; the small random ones take fewer
/// steps with smaller values.
const START: f64 = 10.0;

/// The same in tight wedges, where steps from near the bounds are short. Of 400 solves of a chamber of 60 cells with
/// relieved rows, 151 miss the tolerance with 10, 119 with 300, 110 with 1e3, 107 with 1e4 and 111 with 1e5.
const START_FAR_INSIDE: f64 = 1e3;

/// How far inside a start near an approximate solution is, in residuals of it: a colony to 2,048 cells at dt 0.01 takes
/// 14.4, 13.7 and 14.0 s with 10, 100 and 1e3, and 18.4 s from the violations.
const START_NEAR: f64 = 100.0;

/// An approximate solution is no start if a multiplier is so many times the deepest violation: rows nearly contradict
/// each other, and the method stalls. In colonies to 1,024 cells the largest is 220. In a full chamber over half of the
/// solves have more, up to 1e9; it takes 13,800 products a step from such starts, 8,200 without.
const TIGHT: f64 = 1e3;

/// The part of the distance to the first bound that a step leaves, at least and at most; between them it is the part by
/// which the predicted step fell short. With an upper limit of 0.005 or 0.01, some random systems cycle for up to 45
/// steps, and one does not end; 0.1 costs a tenth more. A lower limit of 1e-3 costs 5 %, 1e-9 changes nothing.
const SHORTEST_OF: f64 = 1e-6;
const LONGEST_OF: f64 = 3e-2;

/// Corrections of a step's direction at most. In five steps in which 4,096 cells divide, solves take 18.6, 16.2, 14.8
/// and 15.2 steps with 0 to 3, and all of them 40, 34, 32 and 36 s.
const MOST_CORRECTIONS: usize = 2;

/// No step that goes at least this far is corrected; another should go this much farther, and goes at least this part
/// of it farther if it counts. The last is Gondzio's, as is the factor by which products may differ from the target;
/// other values of the first two were not tried.
const LONG: f64 = 0.9;
const LONGER: f64 = 0.3;
const WORTH: f64 = 0.1;
const CENTRAL: f64 = 10.0;

/// A direction in multipliers and slacks.
#[derive(Default)]
struct Direction {
    gamma: Vec<f64>,
    slack: Vec<f64>,
}

impl Direction {
    fn of(&self, row: usize) -> Inner {
        Inner { gamma: self.gamma[row], slack: self.slack[row] }
    }
}

/// The iterate, and scratch space for its step.
#[derive(Default)]
pub(super) struct Iterate<const D: usize> {
    gamma: Vec<f64>,
    slack: Vec<f64>,
    /// `q + A gamma`.
    g: Vec<f64>,
    weight: Vec<f64>,
    right: Vec<f64>,
    work: Vec<f64>,
    /// What the step aims at as the products of multipliers and slacks, and a correction of that.
    pull: Vec<f64>,
    next: Vec<f64>,
    velocity: Vec<[f64; D]>,
    predicted: Direction,
    step: Direction,
    /// The compliance that is added to the diagonal of `A`, which is one.
    compliance: f64,
    /// The number of half products, `J^T x` or `J v`, since [`Iterate::reset`].
    pub halves: u64,
}

impl<const D: usize> Iterate<D> {
    /// Resets everything.
    pub fn reset(&mut self, compliance: f64) {
        self.compliance = compliance;
        self.halves = 0;
        self.step.gamma.clear();
    }

    /// Starts from an approximate solution of the problem with gaps `g`, or says that it is no start.
    pub fn begin_near(&mut self, rows: &UnitRows<D>, x: &[f64], g: &[f64]) -> bool {
        let unit = |row: usize| rows.unit(row, x, g);
        let largest = (0..rows.len()).map(|row| unit(row)[0]).fold(0.0, f64::max);
        let residual = (0..rows.len()).map(|row| residual(unit(row)[1], 1.0, unit(row)[0])).fold(0.0, worse);
        if !(largest <= TIGHT * rows.deepest && residual > 0.0 && residual.is_finite()) {
            return false;
        }
        self.resize(rows.len());
        for row in 0..rows.len() {
            let [gamma, gap] = unit(row);
            let Inner { gamma, slack } = Inner::near(gamma, gap, START_NEAR * residual);
            (self.gamma[row], self.slack[row]) = (gamma, slack);
        }
        true
    }

    /// Room for this many rows.
    fn resize(&mut self, rows: usize) {
        let Iterate { gamma, slack, g, weight, right, work, .. } = self;
        for numbers in [gamma, slack, g, weight, right, work] {
            numbers.resize(rows, 0.0);
        }
    }

    /// Starts from the multipliers that the violated rows would have as springs, with equal complementarity of all rows
    /// where possible.
    pub fn begin(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>, far_inside: bool) -> Result<(), Refused> {
        let fill = |x: &mut Vec<f64>, value: &dyn Fn(f64) -> f64| {
            x.clear();
            x.extend(rows.q.iter().map(|q| value(*q)));
        };
        fill(&mut self.weight, &|q| if is_outside(q) { 1.0 } else { 0.0 });
        fill(&mut self.work, &lack);
        fill(&mut self.right, &|_| 0.0);
        matrix.factorize(rows, &self.weight)?;
        rows.velocity(&self.work, &mut self.velocity);
        matrix.solve(&mut self.velocity);
        self.halves += 2;
        self.g.clear();
        self.g.extend((0..rows.len()).map(|i| rows.along(i, &self.velocity)));
        let start = if far_inside { START_FAR_INSIDE } else { START };
        let shift = start * self.g.iter().fold(rows.deepest, |largest, moved| largest.max(moved.abs()));
        self.gamma.clear();
        self.slack.clear();
        for (q, moved) in rows.q.iter().zip(&self.g) {
            let Inner { gamma, slack } = Inner::at(q + moved, shift);
            self.gamma.push(gamma);
            self.slack.push(slack);
        }
        Ok(())
    }

    /// The multipliers of the problem's rows.
    pub fn export(&self, rows: &UnitRows<D>, x: &mut [f64]) {
        x.fill(0.0);
        for ((row, gamma), inverse) in rows.row.iter().zip(&self.gamma).zip(&rows.inverse_length) {
            x[*row as usize] = gamma * inverse;
        }
    }

    /// Sets the gradient from that of the problem's rows.
    pub fn set_gradient(&mut self, rows: &UnitRows<D>, g: &[f64]) {
        for ((own, row), inverse) in self.g.iter_mut().zip(&rows.row).zip(&rows.inverse_length) {
            *own = (g[*row as usize] + rows.relief) * inverse;
        }
    }

    /// The largest multiplier.
    pub fn largest_multiplier(&self) -> f64 {
        fold(self.gamma.len(), 0.0, f64::max, |i| self.gamma[i])
    }

    /// The largest difference between a slack and its gap.
    pub fn infeasibility(&self) -> f64 {
        fold(self.gamma.len(), 0.0, f64::max, |i| (self.g[i] - self.slack[i]).abs())
    }

    /// Whether the last step proves that the rows have no solution.
    pub fn contradicts(&mut self, rows: &UnitRows<D>) -> bool {
        if self.step.gamma.is_empty() || self.compliance > 0.0 {
            return false;
        }
        self.work.clear();
        self.work.extend(self.step.gamma.iter().map(|change| project(*change)));
        rows.velocity(&self.work, &mut self.velocity);
        self.halves += 1;
        contradiction::proven(rows, &self.work, &self.velocity)
    }

    /// Takes one step.
    pub fn advance(&mut self, rows: &UnitRows<D>, matrix: &mut NormalMatrix<D>) -> Result<(), Refused> {
        let added = REGULARIZATION + self.compliance;
        let mut weight = std::mem::take(&mut self.weight);
        fill(&mut weight, rows.len(), |i| 1.0 / (added + self.at(i).compliance()));
        self.weight = weight;
        matrix.factorize(rows, &self.weight)?;
        let (mut predicted, mut step) = (std::mem::take(&mut self.predicted), std::mem::take(&mut self.step));
        // The predictor aims at the bounds; the length of its step determines the centring.
        self.newton(rows, matrix, |_| 0.0, &mut predicted);
        let part = self.room(&predicted).min(1.0);
        let centre = self.centre(&predicted, part);
        let mut pull = std::mem::take(&mut self.pull);
        fill(&mut pull, rows.len(), |i| centre - predicted.of(i).complementarity());
        self.newton(rows, matrix, |i| pull[i], &mut step);
        self.correct(rows, matrix, centre, &mut pull, [&mut step, &mut predicted]);
        self.pull = pull;
        let short = (1.0 - part).clamp(SHORTEST_OF, LONGEST_OF);
        let length = ((1.0 - short) * self.room(&step)).min(1.0);
        for (x, change) in [(&mut self.gamma, &step.gamma), (&mut self.slack, &step.slack)] {
            for (x, change) in x.iter_mut().zip(change) {
                *x += length * change;
            }
        }
        (self.predicted, self.step) = (predicted, step);
        Ok(())
    }

    /// Corrects a step that bounds make short: each correction aims, a bit beyond the step's end, at products of
    /// multipliers and slacks that are neither small nor large, and counts if it makes the step longer (Gondzio,
    /// Multiple centrality corrections in a primal-dual method for linear programming, 1996). `pull` is what the step
    /// aims at; the second direction is scratch space.
    fn correct(
        &mut self,
        rows: &UnitRows<D>,
        matrix: &mut NormalMatrix<D>,
        centre: f64,
        pull: &mut Vec<f64>,
        [step, other]: [&mut Direction; 2],
    ) {
        // Near the rounding of the products there may be no target.
        let most = if centre > 0.0 { MOST_CORRECTIONS } else { 0 };
        let mut next = std::mem::take(&mut self.next);
        for _ in 0..most {
            let reached = self.room(step).min(1.0);
            if reached >= LONG {
                break;
            }
            let wished = (reached + LONGER).min(1.0);
            fill(&mut next, rows.len(), |i| {
                let product = self.at(i).after(wished, step.of(i)).complementarity();
                let change = product.clamp(centre / CENTRAL, centre * CENTRAL) - product;
                pull[i] + change.max(-centre * CENTRAL)
            });
            self.newton(rows, matrix, |i| next[i], other);
            if self.room(other).min(1.0) < reached + WORTH * LONGER {
                break;
            }
            std::mem::swap(pull, &mut next);
            std::mem::swap(step, other);
        }
        self.next = next;
    }

    /// The Newton direction towards `gamma slack = pull` and slacks equal to the gaps.
    fn newton(
        &mut self,
        rows: &UnitRows<D>,
        matrix: &mut NormalMatrix<D>,
        pull: impl Fn(usize) -> f64 + Sync + Send,
        out: &mut Direction,
    ) {
        let (mut right, mut work) = (std::mem::take(&mut self.right), std::mem::take(&mut self.work));
        fill(&mut right, rows.len(), |i| self.at(i).slack_for(pull(i)) - self.g[i]);
        fill(&mut work, rows.len(), |i| self.weight[i] * right[i]);
        (self.right, self.work) = (right, work);
        rows.velocity(&self.work, &mut self.velocity);
        matrix.solve(&mut self.velocity);
        self.halves += 2;
        let Direction { gamma, slack } = out;
        fill(gamma, rows.len(), |i| self.weight[i] * (self.right[i] - rows.along(i, &self.velocity)));
        fill(slack, rows.len(), |i| self.at(i).change_of_slack(pull(i), gamma[i]));
    }

    /// The target of `gamma slack` for a step, by Mehrotra's cubic rule.
    fn centre(&self, predicted: &Direction, part: f64) -> f64 {
        let [now, then] = sums(self.gamma.len(), |i| {
            [self.at(i).complementarity(), self.at(i).after(part, predicted.of(i)).complementarity()]
        });
        (then / now).powi(3) * now / self.gamma.len() as f64
    }

    /// The largest step along a direction before a multiplier or a slack reaches its bound.
    fn room(&self, along: &Direction) -> f64 {
        fold(self.gamma.len(), f64::INFINITY, f64::min, |i| self.at(i).room(along.of(i)))
    }

    /// The multiplier and the slack of a row.
    fn at(&self, row: usize) -> Inner {
        Inner { gamma: self.gamma[row], slack: self.slack[row] }
    }
}
