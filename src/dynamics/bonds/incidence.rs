//! Which bonds hold which bodies.

use crate::bodies::Lineage;
use std::collections::HashMap;

/// Marks a broken bond in [`Incidence::ends`].
pub const GONE: [u32; 2] = [u32::MAX; 2];

/// The bonds of each body, by the places that bodies have in a state: those that hold, in the order of the scene's
/// list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Incidence {
    /// The bodies of each bond; [`GONE`] where it is broken, or has lost a body.
    ends: Vec<[u32; 2]>,
    /// Where each body's part of `entries` begins, and where the last one's ends.
    starts: Vec<u32>,
    /// Twice a bond's number, and one more for its second body.
    entries: Vec<u32>,
}

impl Incidence {
    pub(super) fn new(ids: &[[u64; 2]], lineage: &[Lineage], broken: &[u32]) -> Incidence {
        let places: HashMap<u64, u32> = lineage.iter().map(|line| line.id).zip(0..).collect();
        let ends_of = |(bond, ids): (u32, &[u64; 2])| {
            let holds = broken.binary_search(&bond).is_err();
            let [a, b] = ids.map(|id| places.get(&id).copied().filter(|_| holds));
            a.zip(b).map_or(GONE, |(a, b)| [a, b])
        };
        let ends: Vec<[u32; 2]> = (0..).zip(ids).map(ends_of).collect();
        let mut entries: Vec<(u32, u32)> = (0..)
            .zip(&ends)
            .filter(|(_, ends)| **ends != GONE)
            .flat_map(|(bond, [a, b])| [(*a, 2 * bond), (*b, 2 * bond + 1)])
            .collect();
        entries.sort_unstable();
        let starts = (0..=lineage.len()).map(|body| entries.partition_point(|(of, _)| (*of as usize) < body) as u32);
        Incidence { ends, starts: starts.collect(), entries: entries.into_iter().map(|(_, entry)| entry).collect() }
    }

    /// The bonds of body `i`: their numbers, which of the two ends it is, and both bodies.
    pub(super) fn of(&self, i: usize) -> impl Iterator<Item = (usize, usize, [usize; 2])> + '_ {
        let range = self.starts[i] as usize..self.starts[i + 1] as usize;
        self.entries[range].iter().map(|entry| {
            let bond = (entry >> 1) as usize;
            (bond, (entry & 1) as usize, self.ends[bond].map(|body| body as usize))
        })
    }

    /// The bodies of a bond; `None` if it is broken.
    pub(super) fn pair(&self, bond: usize) -> Option<[usize; 2]> {
        Some(self.ends[bond]).filter(|ends| *ends != GONE).map(|ends| ends.map(|body| body as usize))
    }

    /// The bodies of each bond, for a device.
    #[cfg(feature = "gpu")]
    pub(crate) fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Where each body's entries begin, counted from the first of these words, and the entries, for a device.
    #[cfg(feature = "gpu")]
    pub(crate) fn words(&self) -> Vec<u32> {
        let first = self.starts.len() as u32;
        self.starts.iter().map(|start| first + start).chain(self.entries.iter().copied()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(ids: &[u64]) -> Vec<Lineage> {
        ids.iter().map(|id| Lineage { id: *id, parent: None, birth: 0.0, generation: 0, birth_length: None }).collect()
    }

    #[test]
    fn bonds_follow_ids_and_are_gone_with_them() {
        let bonds = [[4, 7], [7, 9], [4, 9]];
        let of = |ids: &[u64], broken: &[u32]| Incidence::new(&bonds, &lines(ids), broken);
        let all = of(&[7, 4, 9], &[]);
        assert_eq!(all.of(0).collect::<Vec<_>>(), [(0, 1, [1, 0]), (1, 0, [0, 2])]);
        assert_eq!(all.of(2).collect::<Vec<_>>(), [(1, 1, [0, 2]), (2, 1, [1, 2])]);
        let without_seven = of(&[3, 9, 4], &[]);
        assert_eq!((0..3).map(|bond| without_seven.pair(bond)).collect::<Vec<_>>(), [None, None, Some([2, 1])]);
        assert_eq!(without_seven.of(0).count(), 0);
        let broken = of(&[7, 4, 9], &[0, 2]);
        assert_eq!((0..3).filter_map(|bond| broken.pair(bond)).collect::<Vec<_>>(), [[0, 2]]);
        assert_eq!(broken.of(1).count(), 0);
    }
}
