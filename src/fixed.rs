//! Bodies that do not move: obstacles. Like walls they have no unknowns: their free velocity and their mobility are
//! zero.

use crate::bodies::Bodies;

/// Which bodies of a scene do not move, by their id and by their group. Ids stay where bodies before them leave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fixed {
    /// In ascending order.
    ids: Vec<u64>,
    groups: Vec<bool>,
}

impl Fixed {
    /// Those with these ids, and a flag for each group.
    pub fn new(mut ids: Vec<u64>, groups: Vec<bool>) -> Fixed {
        ids.sort_unstable();
        Fixed { ids, groups }
    }

    /// Whether any body may be fixed.
    pub fn any(&self) -> bool {
        !self.ids.is_empty() || self.groups.contains(&true)
    }

    /// Whether the body of this id, in the group of this number, is fixed.
    pub fn holds(&self, id: u64, group: u32) -> bool {
        self.ids.binary_search(&id).is_ok() || self.groups.get(group as usize).copied().unwrap_or(false)
    }

    /// A flag for each body; none at all where no body can be fixed.
    pub fn flags(&self, bodies: &Bodies) -> Vec<bool> {
        if !self.any() {
            return Vec::new();
        }
        bodies.group.iter().zip(&bodies.lineage).map(|(group, line)| self.holds(line.id, *group)).collect()
    }
}
