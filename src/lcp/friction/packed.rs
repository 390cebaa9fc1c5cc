//! Contacts with friction in the form that a device takes.

use super::Cone;
use super::problem::tangents;
use crate::lcp::Problem;

/// What contacts have beside their normal rows, contact by contact, as `shaders/lcp/friction/prepare_rows.wgsl` reads
/// it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedContacts {
    /// The blocks of tangent rows, three numbers and a zero each; one vector a block in the plane, else two.
    pub tangents: Vec<f64>,
    /// The coefficient, the number of rows and the offsets of the slips; the compliances of the rows and a zero.
    pub contacts: Vec<f64>,
    /// The multipliers and a zero.
    pub gammas: Vec<f64>,
}

impl PackedContacts {
    /// Adds the contact whose normal row this is; a row alone has no tangents.
    pub fn push<const D: usize>(&mut self, problem: &Problem<D>, gamma: &[f64], row: usize) {
        let (mu, rows) = match problem.cones[row] {
            Cone::Friction(mu) => (mu, 1 + tangents::<D>()),
            _ => (0.0, 1),
        };
        let of = |numbers: &[f64], at: usize| {
            if at < rows { numbers.get(row + at).copied().unwrap_or(0.0) } else { 0.0 }
        };
        for at in 1..=tangents::<D>() {
            let none = [[0.0; D]; 2];
            let blocks = if at < rows { &problem.jacobian[row + at] } else { &none };
            let parts = blocks.iter().flat_map(|block| block.chunks(3));
            self.tangents.extend(parts.flat_map(|part| [part[0], part[1], part[2], 0.0]));
        }
        self.contacts.extend([mu, rows as f64, of(&problem.q, 1), of(&problem.q, 2)]);
        self.contacts.extend([0, 1, 2].map(|at| of(&problem.compliance, at)).into_iter().chain([0.0]));
        self.gammas.extend([0, 1, 2].map(|at| of(gamma, at)).into_iter().chain([0.0]));
    }

    /// Sets the multipliers of the contact whose normal row this is from those that a device found.
    pub fn take<const D: usize>(found: &[f64], problem: &Problem<D>, gamma: &mut [f64], row: usize) {
        let rows = if matches!(problem.cones[row], Cone::Friction(_)) { 1 + tangents::<D>() } else { 1 };
        gamma[row..row + rows].copy_from_slice(&found[..rows]);
    }
}
