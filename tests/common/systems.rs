//! Systems: those that are stored and small ones, and the residual of a solution.

use relcp::lcp::{Problem, velocity};

/// A stored system, a start, a reference solution's velocity.
pub struct Stored {
    pub problem: Problem<3>,
    pub start: Vec<f64>,
    pub velocity: Vec<[f64; 3]>,
}

pub fn stored(name: &str) -> Stored {
    let path = format!("{}/tests/data/lcp/{name}.npz", env!("CARGO_MANIFEST_DIR"));
    let (stored, _) = relcp::record::read_lcp(path.as_ref()).unwrap();
    Stored { problem: stored.problem().unwrap(), velocity: stored.velocity.as_chunks().0.to_vec(), start: stored.start }
}

/// The natural residual, written out.
pub fn residual<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> f64 {
    let v = velocity(problem, gamma);
    let mut worst: f64 = 0.0;
    for (row, [a, b]) in problem.pair.iter().enumerate() {
        let (mut g, mut s) = (problem.q[row], 0.0);
        for (body, block) in [a, b].into_iter().zip(&problem.jacobian[row]) {
            for k in 0..D {
                g += block[k] * v[*body as usize][k];
                s += block[k] * block[k];
            }
        }
        worst = worst.max(g.min(s * gamma[row]).abs());
    }
    worst
}

/// Two bodies, one unknown used.
pub fn line(rows: &[(f64, f64)]) -> Problem<3> {
    Problem {
        bodies: 2,
        pair: vec![[0, 1]; rows.len()],
        jacobian: rows.iter().map(|(j, _)| [[-j, 0.0, 0.0], [*j, 0.0, 0.0]]).collect(),
        q: rows.iter().map(|(_, q)| *q).collect(),
        ..Problem::default()
    }
}
