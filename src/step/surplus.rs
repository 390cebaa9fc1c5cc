//! Rows of violations that ask for more than a violation takes back.
//!
//! A row made at a trial is exact there, and the next trial is elsewhere: bodies that are pushed apart slide on along
//! each other and overlap again by a part of what they did. Packed bodies in space then recurse as often as it takes
//! to halve and halve again what is left. A row that asks for a separation of a part of the overlap anticipates this.
//!
//! Only the first attempt at a step does it: one that fails, as bodies that fit nowhere make it, is taken again with
//! rows that ask for touching.

use super::{Model, Recursion, Rows, Stepping};
use crate::dynamics::Cells;

/// The part of an overlap that its row asks for as a separation. 1,000 packed rods at dt 0.1, from t = 10 to 12, take
/// 1,800 products a step without, and 1,542, 1,448, 1,366 and 1,439 with 0.2, 0.3, 0.5 and 1.
const PART: f64 = 0.5;

/// The largest such separation, in parts of the thinnest body's thickness: a tenth of the gap at which a contact that
/// pushes is loosened. The same rods take 1,481, 1,416, 1,366 and 1,386 products a step with a fifth, half of this,
/// this, and twice this; and without a bound 3,850, as all steps are loosened.
const MOST: f64 = 0.002;

/// The least number of rows for it. Few bodies take no time, and what they come to is often known: a ball that a
/// trap draws into a ring rests 0.002 off where its row asks for more, as no row of the two sees that they touch all
/// round.
pub(super) const LEAST_ROWS: usize = 128;

/// What rows of violations ask for beyond touching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surplus {
    /// The part of the overlap.
    pub part: f64,
    /// The most, a length.
    pub most: f64,
}

impl Surplus {
    /// Touching is enough.
    pub const NONE: Surplus = Surplus { part: 0.0, most: 0.0 };

    /// That of bodies the thinnest of which has this thickness, infinite where there are none.
    pub fn of(thinnest: f64) -> Surplus {
        if thinnest.is_finite() { Surplus { part: PART, most: MOST * thinnest } } else { Surplus::NONE }
    }

    /// The separation that the row of an overlap asks for.
    pub fn asked(self, overlap: f64) -> f64 {
        (self.part * overlap.max(0.0)).min(self.most)
    }
}

/// Whether crowds of a scene over-correct. In the plane violations move their own rows first. With inertia the
/// separation would become speed; a midpoint step needs its rows' offsets for its order, friction those of the contacts
/// that it acts at, and bonds that keep a length may leave no room for it.
pub(super) fn over_corrects(model: &Model) -> bool {
    let bonded = model.bonds.first_implicit().is_some() || model.cells.as_ref().is_some_and(Cells::bond_daughters);
    model.contact.rows_of_method() == Rows::Auto
        && model.contact.recursion == Recursion::Inexact
        && !model.planar
        && model.time.stepping == Stepping::Euler
        && !model.dynamics.has_inertia()
        && model.friction.is_none()
        && !bonded
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn a_row_asks_for_half_the_overlap_up_to_a_length_that_no_gap_of_a_push_is_judged_by() {
        let surplus = Surplus::of(0.5);
        assert_eq!([-1e-3, 0.0, 1e-5, 1e-3].map(|overlap| surplus.asked(overlap)), [0.0, 0.0, 5e-6, 5e-4]);
        assert_eq!(surplus.asked(1.0), 1e-3);
        const { assert!(MOST < 0.5 * crate::step::two_sided::GAP) };
        assert_eq!([Surplus::NONE, Surplus::of(f64::INFINITY)].map(|none| none.asked(1.0)), [0.0; 2]);
    }

    #[test]
    fn only_crowds_in_space_without_inertia_friction_and_stiff_bonds_ask_for_more_than_touching() {
        let asks = |name: &str, set: &[&str]| over_corrects(&Scene::load(name, set.iter().copied()).unwrap().model());
        assert!(asks("compaction", &[]));
        let without: [(&str, &[&str]); 6] = [
            ("colony", &[]),
            ("compaction", &["contact.rows=paper"]),
            ("compaction", &["time.stepping=midpoint"]),
            ("compaction", &["contact.recursion=exact"]),
            ("compaction", &["contact.friction=0.3"]),
            ("pile", &[]),
        ];
        for (name, set) in without {
            assert!(!asks(name, set), "{name} {set:?}");
        }
    }
}
