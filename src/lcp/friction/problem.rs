//! What the multipliers of a problem may be.

use crate::lcp::Problem;

/// What the multiplier of a row may be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cone {
    /// `gamma >= 0`, of a row alone: contact without friction.
    Ray,
    /// The normal row of a contact with this coefficient of friction `mu`. Its tangent rows follow at once: two for
    /// bodies with six unknowns, one for bodies with three. The three multipliers lie in the cone
    /// `|gamma_t| <= mu gamma_n`.
    Friction(f64),
    /// A tangent row of the normal row before.
    Tangent,
    /// Any number, of a row alone: it pushes and pulls, so that `q + (A + k) gamma = 0`. A bond.
    Free,
    /// The same, of a row that the solver eliminates together with all others of this kind. Bonds with a bending
    /// stiffness, and joints.
    Linked,
}

impl Cone {
    /// Whether the multiplier may be any number.
    pub fn is_free(self) -> bool {
        matches!(self, Cone::Free | Cone::Linked)
    }
}

/// Tangent rows of a contact between bodies with `D` unknowns.
pub(super) const fn tangents<const D: usize>() -> usize {
    if D > 3 { 2 } else { 1 }
}

impl<const D: usize> Problem<D> {
    /// Checks the invariants of a problem with cones: [`Problem::cones`] and [`Problem::compliance`] are empty or have
    /// a number a row, the latter only beside the former; tangent rows, and only these, follow the normal row of their
    /// contact and have its pair; coefficients and compliances are finite and not negative.
    ///
    /// # Panics
    /// If one does not hold.
    pub fn check(&self) {
        let rows = self.q.len();
        assert!(self.cones.is_empty() || self.cones.len() == rows, "{} cones of {rows} rows", self.cones.len());
        let compliances = self.compliance.len();
        assert!(compliances == 0 || compliances == rows, "{compliances} compliances of {rows} rows");
        assert!(compliances == 0 || self.cones.len() == rows, "rows with compliances have no cones");
        assert!(self.compliance.iter().all(|k| is_number(*k)), "a compliance is negative or not finite");
        let mut row = 0;
        while let Some(cone) = self.cones.get(row) {
            let end = row + 1 + if matches!(cone, Cone::Friction(_)) { tangents::<D>() } else { 0 };
            assert!(*cone != Cone::Tangent, "row {row} is a tangent row without a normal row");
            if let Cone::Friction(mu) = cone {
                assert!(is_number(*mu), "row {row}: friction of {mu}");
                let follow = self.cones.get(row + 1..end).is_some_and(|rows| rows.iter().all(|c| *c == Cone::Tangent));
                assert!(follow, "row {row}: {} tangent rows must follow", end - row - 1);
                let same = self.pair[row..end].iter().all(|pair| *pair == self.pair[row]);
                assert!(same, "row {row}: its tangent rows have other pairs");
            }
            row = end;
        }
    }
}

fn is_number(x: f64) -> bool {
    x.is_finite() && x >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact() -> Problem<6> {
        Problem {
            bodies: 3,
            pair: vec![[0, 2], [0, 1], [0, 1], [0, 1]],
            jacobian: vec![[[0.0; 6]; 2]; 4],
            q: vec![0.0; 4],
            cones: vec![Cone::Ray, Cone::Friction(0.5), Cone::Tangent, Cone::Tangent],
            compliance: vec![0.0; 4],
        }
    }

    fn is_refused(change: impl FnOnce(&mut Problem<6>)) -> bool {
        let mut problem = contact();
        change(&mut problem);
        std::panic::catch_unwind(move || problem.check()).is_err()
    }

    #[test]
    fn tangents_follow_their_normal_row() {
        contact().check();
        Problem::<6>::default().check();
        assert!(is_refused(|problem| problem.cones[0] = Cone::Tangent));
        assert!(is_refused(|problem| problem.cones[1] = Cone::Ray));
        assert!(is_refused(|problem| problem.cones[2] = Cone::Ray));
        assert!(is_refused(|problem| problem.cones[2] = Cone::Friction(0.1)));
        assert!(is_refused(|problem| problem.cones[3] = Cone::Ray));
        assert!(is_refused(|problem| problem.cones[1] = Cone::Friction(-0.1)));
        assert!(is_refused(|problem| problem.cones[1] = Cone::Friction(f64::NAN)));
        assert!(is_refused(|problem| problem.pair[3] = [1, 0]));
        assert!(is_refused(|problem| problem.cones.truncate(3)));
        assert!(is_refused(|problem| problem.compliance.truncate(3)));
        assert!(is_refused(|problem| problem.compliance[2] = -1.0));
        assert!(is_refused(|problem| problem.cones.clear()));
    }
}
