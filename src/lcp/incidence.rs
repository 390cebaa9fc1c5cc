//! The rows of each body: lists by body, rows ascending, so that sums over a body's rows do not depend on threads.

/// The rows of every body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Incidence {
    /// The offset of each body's list in `entries`, and the end.
    pub start: Vec<u32>,
    /// `2 row + side`, with `side` the position (0 or 1) of the body in the row's pair.
    pub entries: Vec<u32>,
}

impl Incidence {
    /// Rebuilds the lists for the pairs of a problem's rows, by a counting sort.
    ///
    /// A problem has at most `2^31` rows, so that a row index fits an entry.
    pub fn rebuild(&mut self, bodies: usize, pair: &[[u32; 2]]) {
        self.start.clear();
        self.start.resize(bodies + 1, 0);
        for body in pair.as_flattened() {
            self.start[*body as usize + 1] += 1;
        }
        for body in 0..bodies {
            self.start[body + 1] += self.start[body];
        }
        self.entries.clear();
        self.entries.resize(2 * pair.len(), 0);
        // Filling moves each start to that of the next body; they are moved back below.
        for (entry, body) in pair.as_flattened().iter().enumerate() {
            let next = &mut self.start[*body as usize];
            self.entries[*next as usize] = entry as u32;
            *next += 1;
        }
        self.start.rotate_right(1);
        self.start[0] = 0;
    }

    /// The entries of a body.
    pub fn of(&self, body: usize) -> &[u32] {
        &self.entries[self.start[body] as usize..self.start[body + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_whole_and_ascend() {
        let mut incidence = Incidence::default();
        incidence.rebuild(4, &[[0, 3], [3, 1], [0, 1], [0, 3]]);
        assert_eq!(incidence.of(0), [0, 4, 6]);
        assert_eq!(incidence.of(1), [3, 5]);
        assert!(incidence.of(2).is_empty());
        assert_eq!(incidence.of(3), [1, 2, 7]);
        incidence.rebuild(0, &[]);
        assert_eq!(incidence.start, [0]);
    }
}
