//! An LCP with a start and a solution, as stored in files, and its residual computed from the definition.

use super::{Problem, velocity};

/// An LCP with any number of unknowns per body, with a start and a solver's result. Blocks of `J` and velocities are
/// flat, with `unknowns` scalars each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored {
    /// Unknowns per body: 3 in the plane, 6 in space.
    pub unknowns: usize,
    /// The number of bodies that rows refer to.
    pub bodies: usize,
    /// The two bodies of each row, distinct.
    pub pair: Vec<[u32; 2]>,
    /// The first and the second block of each row of `J`.
    pub rows: [Vec<f64>; 2],
    /// `g` at `gamma = 0`, one length per row.
    pub q: Vec<f64>,
    /// The solver's start.
    pub start: Vec<f64>,
    /// The solver's result.
    pub gamma: Vec<f64>,
    /// `J^T gamma`.
    pub velocity: Vec<f64>,
}

impl Stored {
    /// A problem with its start and result.
    ///
    /// # Panics
    /// If the lengths differ, a row refers to a body out of range, or the problem has cones, which are not stored.
    pub fn new<const D: usize>(problem: &Problem<D>, start: Vec<f64>, gamma: &[f64]) -> Self {
        assert!(problem.cones.is_empty(), "problems with cones are not stored");
        let side = |side: usize| problem.jacobian.iter().flat_map(|row| row[side]).collect();
        Stored {
            unknowns: D,
            bodies: problem.bodies,
            pair: problem.pair.clone(),
            rows: [side(0), side(1)],
            q: problem.q.clone(),
            start,
            gamma: gamma.to_vec(),
            velocity: velocity(problem, gamma).into_flattened(),
        }
    }

    /// The problem, if its bodies have `D` unknowns.
    pub fn problem<const D: usize>(&self) -> Option<Problem<D>> {
        let blocks = self.rows[0].as_chunks::<D>().0.iter().zip(self.rows[1].as_chunks::<D>().0);
        (self.unknowns == D).then(|| Problem {
            bodies: self.bodies,
            pair: self.pair.clone(),
            jacobian: blocks.map(|(a, b)| [*a, *b]).collect(),
            q: self.q.clone(),
            ..Problem::default()
        })
    }

    /// The natural residual `max |min(q + J v, s gamma)|` of multipliers, with `v = J^T gamma` and `s` the squared
    /// lengths of the rows of `J`: computed from the definition, independently of the solvers. NaN if an entry is NaN.
    ///
    /// # Panics
    /// If the number of multipliers differs from that of rows.
    pub fn residual(&self, gamma: &[f64]) -> f64 {
        let block = |row: usize, side: usize| &self.rows[side][row * self.unknowns..(row + 1) * self.unknowns];
        let mut v = vec![0.0; self.bodies * self.unknowns];
        for (row, pair) in self.pair.iter().enumerate() {
            for (side, body) in pair.iter().enumerate() {
                let v = &mut v[*body as usize * self.unknowns..];
                v.iter_mut().zip(block(row, side)).for_each(|(v, j)| *v += j * gamma[row]);
            }
        }
        let mut worst: f64 = 0.0;
        for (row, pair) in self.pair.iter().enumerate() {
            let (mut g, mut s) = (self.q[row], 0.0);
            for (side, body) in pair.iter().enumerate() {
                let v = &v[*body as usize * self.unknowns..];
                g += v.iter().zip(block(row, side)).map(|(v, j)| v * j).sum::<f64>();
                s += block(row, side).iter().map(|j| j * j).sum::<f64>();
            }
            let scaled = s * gamma[row];
            if g.is_nan() || scaled.is_nan() {
                return f64::NAN;
            }
            worst = worst.max(g.min(scaled).abs());
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_rows() -> Problem<3> {
        Problem {
            bodies: 3,
            pair: vec![[0, 1], [2, 1]],
            jacobian: vec![[[-1.0, 0.0, 0.5], [1.0, 0.0, 0.0]], [[0.0, 2.0, 0.0], [0.0, -1.0, 0.25]]],
            q: vec![-0.1, 0.3],
            ..Problem::default()
        }
    }

    #[test]
    fn a_problem_comes_back() {
        let problem = two_rows();
        let stored = Stored::new(&problem, vec![0.0, 1.0], &[0.5, 0.0]);
        assert_eq!(stored.problem::<3>().unwrap(), problem);
        assert_eq!(stored.problem::<6>(), None);
        assert_eq!(stored.velocity, [-0.5, 0.0, 0.25, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn the_residual_is_that_of_the_worst_row() {
        let stored = Stored::new(&two_rows(), vec![], &[0.0, 0.0]);
        assert_eq!(stored.residual(&[0.0, 0.0]), 0.1);
        // Row 0: g = -0.1 + 2.25 x, s = 2.25; row 1: g = 0.3, s = 5.0625.
        assert!((stored.residual(&[0.1 / 2.25, 0.0])).abs() < 1e-15);
        assert!((stored.residual(&[1.0, 0.0]) - 2.15).abs() < 1e-12);
        let row_1 = stored.residual(&[0.0, 0.01]);
        assert!((row_1 - 0.1).abs() < 1e-12, "{row_1}");
        assert!(stored.residual(&[f64::NAN, 0.0]).is_nan());
    }
}
