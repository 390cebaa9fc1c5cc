//! The rows of the turns that a bond resists ([`crate::dynamics::bonds::turning`]).
//!
//! A turn by `theta n` from rest has a row along each of its axes,
//!
//! ```text
//! g = r theta n . c + gamma / (B / r^2) = 0
//! ```
//!
//! with the stiffness `B` and a length `r`, so that a row of a turn is a length as all rows are. What turns are two
//! bodies, or a body and the bond itself, which turns by `d x d' / |d|^2` where its points move apart by `d'`.

use super::bond::{Line, Stretch};
use super::{Mover, carried_back, row_of};
use crate::dynamics::{Between, Turn, least_way};
use glam::DVec3;

/// The rows of a turn of a bond.
pub(super) fn lines<'a, const D: usize>(
    of: &'a Stretch,
    turn: &'a Turn,
    movers: [Mover<'a>; 2],
    dt: f64,
) -> impl Iterator<Item = Line<D>> + 'a {
    let distance = of.way.length().max(least_way(of.length));
    let along = of.way.normalize_or_zero();
    let angular = movers.map(|mover| mover.reached_with.angular);
    let turns = move |(part, about): (f64, DVec3)| {
        let about = of.reach * about;
        let aside = if turn.between == Between::Bodies { DVec3::ZERO } else { about.cross(along) / distance };
        let [at_a, at_b] = of.arms.map(|arm| arm.cross(aside));
        let (direction, [on_a, on_b]) = match turn.between {
            Between::Bodies => (DVec3::ZERO, [about, about]),
            Between::FirstAndWay => (aside, [at_a + about, at_b]),
            Between::WayAndSecond => (-aside, [-at_a, about - at_b]),
        };
        let arms = [carried_back(on_a, angular[0], dt), carried_back(on_b, angular[1], dt)];
        let row = row_of(movers, direction, arms, of.reach * part, dt);
        let couple = if turn.between == Between::FirstAndWay { DVec3::ZERO } else { about };
        Line { row, compliance: of.reach * of.reach * turn.compliance, direction, couple }
    };
    turn.parts().map(turns)
}
