//! Bodies that do not move: obstacles. Like walls they have no unknowns: their free velocity and their mobility are
//! zero.

use crate::bodies::Bodies;

/// Which bodies of a scene do not move, by their number and by their group. Bodies that are born later have higher
/// numbers, and a fixed body neither grows nor divides, so that numbers stay.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fixed {
    bodies: Vec<bool>,
    groups: Vec<bool>,
}

impl Fixed {
    /// Those of a scene: a flag for each body that it lists, and for each group.
    pub fn new(bodies: Vec<bool>, groups: Vec<bool>) -> Fixed {
        Fixed { bodies, groups }
    }

    /// Whether any body may be fixed.
    pub fn any(&self) -> bool {
        self.bodies.iter().chain(&self.groups).any(|fixed| *fixed)
    }

    /// Whether body `i`, in the group of this number, is fixed.
    pub fn holds(&self, i: usize, group: u32) -> bool {
        let flag = |flags: &[bool], at: usize| flags.get(at).copied().unwrap_or(false);
        flag(&self.bodies, i) || flag(&self.groups, group as usize)
    }

    /// A flag for each body; none at all where no body can be fixed.
    pub fn flags(&self, bodies: &Bodies) -> Vec<bool> {
        if !self.any() {
            return Vec::new();
        }
        bodies.group.iter().enumerate().map(|(i, group)| self.holds(i, *group)).collect()
    }
}
