//! The error of a step that misses its tolerances in every attempt: overlap, bodies, residual.

use super::Guard;
use crate::digits::{beside, few, short};
use crate::dynamics::BondName;
use std::fmt;

/// Bodies without a way out, and the indices of the walls that they are pressed against.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wedge {
    /// The bodies, ascending.
    pub bodies: Vec<usize>,
    /// The walls, ascending.
    pub walls: Vec<usize>,
}

/// Bodies of a wedge that a message names; the others it counts.
const NAMED: usize = 8;

impl Wedge {
    /// Its first two bodies, or its first body and wall.
    pub(super) fn first_two(&self) -> [Option<[usize; 2]>; 2] {
        match (self.bodies.as_slice(), self.walls.as_slice()) {
            ([body, ..], [wall, ..]) => [None, Some([*body, *wall])],
            ([a, b, ..], []) => [Some([*a, *b]), None],
            _ => [None; 2],
        }
    }

    /// Who has no way out, in words; where the wedge is not known, those that the step fails at.
    pub(super) fn pressed(&self, unresolved: &Unresolved) -> String {
        let list = |numbers: &[usize]| numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let walls = |walls: &[usize]| match walls {
            [wall] => format!("wall {wall}"),
            walls => format!("walls {}", list(walls)),
        };
        let (bodies, against) = match (self.bodies.as_slice(), unresolved.wall, unresolved.pair) {
            ([], Some([body, wall]), _) => (vec![body], vec![wall]),
            ([], None, Some(pair)) => (pair.into(), Vec::new()),
            (bodies, ..) => (bodies.into(), self.walls.clone()),
        };
        let named = list(&bodies[..bodies.len().min(NAMED)]);
        let more = if bodies.len() > NAMED { format!(" and {} more", bodies.len() - NAMED) } else { String::new() };
        match (bodies.len(), against.is_empty()) {
            (0, _) => "the cells find no way out".into(),
            (1, true) => format!("cell {named} finds no way out"),
            (1, false) => format!("cell {named} is pressed against {} and finds no way out", walls(&against)),
            (_, true) => format!("cells {named}{more} press each other and find no way out"),
            (_, false) => format!("cells {named}{more} and {} press each other and find no way out", walls(&against)),
        }
    }
}

/// What may keep bodies from parting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hindrance {
    /// Nothing known.
    #[default]
    Nothing,
    /// Bonds or joints that keep a length or an angle exactly.
    RigidBonds,
    /// Bonds with bending that load may press to nothing.
    BendingBonds,
    /// Walls that move or bear a load, or a cell that shrinks: they may leave no room.
    Walls,
}

/// A step that misses a tolerance however it is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// The step that was being taken.
    pub step: u64,
    /// The overlap that its shortest piece would leave, a length.
    pub overlap: f64,
    /// The bond, where that is no overlap, but what an implicit bond would be off by; `pair` are its bodies.
    pub bond: Option<BondName>,
    /// The pair of bodies that overlaps by it, or that went through each other.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap by it, if they do.
    pub wall: Option<[usize; 2]>,
    /// What its velocities times `dt` may be off by, a length.
    pub residual: f64,
    /// Whether it fails only because bodies went through each other.
    pub passed: bool,
    /// The promise about what contact does that is broken.
    pub broken: Option<Guard>,
    /// The body that contact moves farthest from its free motion, and how far.
    pub moved: Option<(usize, f64)>,
    /// The overlap tolerance, which is that of the residual too.
    pub tolerance: f64,
    /// Whether `contact.on_failure` of the scene may be `"continue"`.
    pub may_be_accepted: bool,
    /// What of the scene may keep its bodies from parting.
    pub hindrance: Hindrance,
}

impl Unresolved {
    /// What may help cells without room, beside waiting.
    pub(super) fn remedy_of_no_room(&self) -> &'static str {
        match self.name() {
            "locked" => "with growth.stress_sensitivity too, and they stop under pressure",
            _ => "if the container is open, a smaller time.dt may find a way out",
        }
    }

    /// What may help.
    pub(super) fn remedy(&self) -> &'static str {
        match self.name() {
            "locked" => {
                "use a smaller contact.friction; cells that lock wait with growth.stress_sensitivity or \
                 growth.on_no_room = \"stall\""
            }
            "overlap" if self.hindrance == Hindrance::Walls => {
                "where walls or a shrinking cell leave the bodies no room, they are jammed: end the motion earlier, or \
                 push with a load; else use a smaller time.dt"
            }
            "overlap" | "bond" if self.hindrance == Hindrance::BendingBonds => {
                "use a smaller time.dt; a soft bond with bending that load presses to nothing has no direction: make it \
                 stiffer or longer"
            }
            "overlap" if self.may_be_accepted => {
                "use a smaller time.dt; bodies that are jammed need more room; or accept and count such steps with \
                 contact.on_failure = \"continue\""
            }
            _ if self.may_be_accepted => {
                "use a smaller time.dt, or accept and count such steps with contact.on_failure = \"continue\""
            }
            // Balls that touch and turn about the point where they touch overlap at once.
            "overlap" if self.hindrance == Hindrance::RigidBonds => {
                "use a smaller time.dt; joined bodies need room to turn, or \"contact\": false in their bond or joint"
            }
            "overlap" => "use a smaller time.dt; bodies that are jammed need more room",
            _ => "use a smaller time.dt",
        }
    }

    /// Its name in files and tables: what it misses.
    pub fn name(&self) -> &'static str {
        match self.broken {
            _ if self.passed => "passed",
            _ if self.overlap > self.tolerance && self.bond.is_some() => "bond",
            _ if self.overlap > self.tolerance => "overlap",
            Some(Guard::Energy) => "energy",
            Some(Guard::Spin) => "spin",
            Some(Guard::Locked) => "locked",
            Some(_) => "thrown",
            None => "residual",
        }
    }
}

impl fmt::Display for Unresolved {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Unresolved { step, overlap, residual, tolerance, .. } = self;
        let pair = match (self.pair, self.wall) {
            (_, Some([body, wall])) => format!("body {body} and wall {wall}"),
            (Some([a, b]), None) => format!("bodies {a} and {b}"),
            (None, None) => "bodies".into(),
        };
        write!(f, "step {step}: {pair} ")?;
        match self.name() {
            "passed" => write!(f, "go through each other"),
            "thrown" => {
                let (body, way) = self.moved.unwrap_or_default();
                write!(f, "push each other too far: contact moves body {body} by {}", few(way))
            }
            "energy" => write!(f, "gain energy by contact"),
            "spin" => write!(f, "are spun by contact about their own axes"),
            "locked" => write!(f, "lock: no friction forces of ordinary size were found that let them move"),
            "bond" => write!(
                f,
                "are off what {} allows by {}, {} is allowed",
                self.bond.map_or_else(|| "their bond".into(), |name| name.to_string()),
                beside(*overlap, *tolerance),
                short(*tolerance)
            ),
            "residual" => {
                write!(
                    f,
                    "have no accurate velocities: the contact problem is solved to {}, the tolerance is {}",
                    beside(*residual, *tolerance),
                    short(*tolerance)
                )
            }
            _ => write!(f, "still overlap by {}, {} is allowed", beside(*overlap, *tolerance), short(*tolerance)),
        }?;
        if self.name() == "locked" { Ok(()) } else { write!(f, ", even in steps of dt/64") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step that leaves a body past a wall, or in another.
    fn unresolved(pair: Option<[usize; 2]>, wall: Option<[usize; 2]>) -> Unresolved {
        let (step, overlap, residual, tolerance) = (2, 2.1e-5, 0.0, 1e-5);
        Unresolved {
            step,
            overlap,
            bond: None,
            pair,
            wall,
            residual,
            passed: false,
            broken: None,
            moved: None,
            tolerance,
            may_be_accepted: true,
            hindrance: Hindrance::Nothing,
        }
    }

    #[test]
    fn bodies_that_closing_walls_jam_get_a_remedy() {
        let jammed = Unresolved { hindrance: Hindrance::Walls, ..unresolved(Some([4, 7]), None) };
        assert!(jammed.remedy().contains("are jammed"));
        assert!(!Unresolved { passed: true, ..jammed }.remedy().contains("jammed"));
    }

    #[test]
    fn balls_that_turn_about_the_point_where_they_touch_get_a_remedy() {
        let joined =
            Unresolved { may_be_accepted: false, hindrance: Hindrance::RigidBonds, ..unresolved(Some([4, 7]), None) };
        assert!(joined.remedy().contains("need room to turn"));
        let bent = Unresolved { hindrance: Hindrance::BendingBonds, ..joined };
        assert!(bent.remedy().contains("stiffer or longer"));
        assert!(Unresolved { hindrance: Hindrance::Nothing, ..joined }.remedy().ends_with("need more room"));
        let off = Unresolved { overlap: 0.0, residual: 1e-3, hindrance: Hindrance::Nothing, ..joined };
        assert_eq!(off.remedy(), "use a smaller time.dt");
    }

    #[test]
    fn those_without_room_are_named_whether_there_is_a_wedge_or_not() {
        let wedge =
            |bodies: std::ops::Range<usize>, walls: &[usize]| Wedge { bodies: bodies.collect(), walls: walls.into() };
        let [pair, wall] = [unresolved(Some([4, 7]), None), unresolved(None, Some([3, 1]))];
        for (wedge, at, said) in [
            (wedge(0..0, &[]), &wall, "cell 3 is pressed against wall 1 and finds no way out"),
            (wedge(0..0, &[]), &pair, "cells 4, 7 press each other and find no way out"),
            (wedge(5..6, &[0, 2]), &pair, "cell 5 is pressed against walls 0, 2 and finds no way out"),
            (wedge(1..3, &[0]), &pair, "cells 1, 2 and wall 0 press each other and find no way out"),
            (wedge(0..10, &[]), &pair, "cells 0, 1, 2, 3, 4, 5, 6, 7 and 2 more press each other and find no way out"),
        ] {
            assert_eq!(wedge.pressed(at), said);
        }
        assert!(wall.to_string().starts_with("step 2: body 3 and wall 1 still overlap by 2.1e-5, 1e-5 is allowed"));
    }
}
