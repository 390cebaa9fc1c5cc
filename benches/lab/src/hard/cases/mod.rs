//! The cases: one table per file.

mod confined;
mod crowds;
mod inertial;
mod motion;
mod poses;

use super::laws::Law;
use super::same::Change;
use super::start::Start;

/// The test of a case in addition to contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// No further test.
    Contact,
    /// A law that must hold in every step.
    Law(Law),
    /// An invariance: the changed scene must give the changed result. The figures of the case are those of the changed
    /// scene.
    Same(Change),
}

/// A small hard scene and the length of its run.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The kind of difficulty.
    pub group: &'static str,
    /// Its name.
    pub name: String,
    /// The largest number of steps.
    pub steps: u64,
    /// The initial state.
    pub start: Start,
    /// The test.
    pub test: Test,
}

impl Case {
    fn contact(group: &'static str, name: impl Into<String>, steps: u64, start: Start) -> Case {
        Case { group, name: name.into(), steps, start, test: Test::Contact }
    }

    fn of(self, law: Law) -> Case {
        Case { test: Test::Law(law), ..self }
    }
}

/// All cases, in the order of the page.
pub fn all() -> Vec<Case> {
    [poses::cases(), crowds::cases(), motion::cases(), confined::cases(), inertial::cases(), super::same::cases()]
        .concat()
}
