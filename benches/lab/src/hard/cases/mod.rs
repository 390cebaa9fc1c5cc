//! The cases: one table a file.

mod confined;
mod crowds;
mod inertial;
mod motion;
mod poses;

use super::laws::Law;
use super::same::Change;
use super::start::Start;

/// What a case looks at beside contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// Nothing.
    Contact,
    /// That something holds in every step.
    Law(Law),
    /// That the same scene, changed, gives the same result changed; the case's figures are those of the changed scene.
    Same(Change),
}

/// A small scene that is hard, and how long it is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// What kind of hardness.
    pub group: &'static str,
    /// Its name.
    pub name: String,
    /// Steps at most.
    pub steps: u64,
    /// Where it starts.
    pub start: Start,
    /// What it looks at.
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
