//! Which rows belong together: those that share moving bodies, in groups that are solved together.

use crate::lcp::Problem;

/// The rows of a group at least.
const LEAST_ROWS: usize = 128;

/// A group with more than this part of all rows leaves too little to gain.
const MOST_OF_ROWS: f64 = 0.875;

/// No body.
pub(in crate::lcp) const NONE: u32 = u32::MAX;

/// The positions of the bodies that each row moves; [`NONE`] for what does not move.
pub(super) fn moving<const D: usize>(
    problem: &Problem<D>,
    position: &[u32],
) -> impl ExactSizeIterator<Item = [u32; 2]> + Clone {
    problem.pair.iter().zip(&problem.jacobian).map(|(pair, blocks)| {
        let of = |side: usize| if blocks[side] == [0.0; D] { NONE } else { position[pair[side] as usize] };
        [of(0), of(1)]
    })
}

/// The group of each row, and the number of groups, in the order of their first bodies, from the bodies that rows move.
/// None where one has nearly all rows, or a row moves nothing.
pub(in crate::lcp) fn groups(
    rows: impl ExactSizeIterator<Item = [u32; 2]> + Clone,
    bodies: usize,
) -> Option<(Vec<u32>, usize)> {
    if rows.len() < 2 * LEAST_ROWS {
        return None;
    }
    let mut joined = Joined { first: vec![NONE; bodies], parts: 0 };
    for [a, b] in rows.clone() {
        match [a != NONE, b != NONE] {
            [true, true] => joined.join(a, b),
            [true, false] => joined.touch(a),
            [false, true] => joined.touch(b),
            [false, false] => return None,
        }
    }
    if joined.parts < 2 {
        return None;
    }
    let mut of_row = Vec::with_capacity(rows.len());
    let mut sizes = vec![0; bodies];
    let most = (MOST_OF_ROWS * rows.len() as f64) as usize;
    for [a, b] in rows {
        let first = joined.first_of(a.min(b));
        sizes[first as usize] += 1;
        of_row.push(first);
    }
    let (group, count) = gather(&sizes, most)?;
    of_row.iter_mut().for_each(|of| *of = group[*of as usize]);
    Some((of_row, count))
}

/// The group of each island, which its first body names, from their numbers of rows: a large one is a group, small ones
/// are gathered in order. None if a group has more than `most` rows.
pub(super) fn gather(sizes: &[usize], most: usize) -> Option<(Vec<u32>, usize)> {
    let mut group = vec![NONE; sizes.len()];
    let mut rows: Vec<usize> = Vec::new();
    let mut filling: Option<usize> = None;
    for (first, size) in sizes.iter().enumerate().filter(|(_, size)| **size > 0) {
        let of = match filling.filter(|_| *size < LEAST_ROWS) {
            Some(of) => of,
            None => {
                rows.push(0);
                rows.len() - 1
            }
        };
        rows[of] += size;
        group[first] = of as u32;
        if *size < LEAST_ROWS {
            filling = Some(of).filter(|of| rows[*of] < LEAST_ROWS);
        }
    }
    (rows.len() > 1 && rows.iter().all(|rows| *rows <= most)).then_some((group, rows.len()))
}

/// Bodies that are joined, each part named by its first body.
struct Joined {
    /// A body of the same part that is not later; none where no row touches it.
    first: Vec<u32>,
    parts: usize,
}

impl Joined {
    fn touch(&mut self, body: u32) {
        let first = &mut self.first[body as usize];
        if *first == NONE {
            *first = body;
            self.parts += 1;
        }
    }

    fn first_of(&mut self, mut body: u32) -> u32 {
        while self.first[body as usize] != body {
            let before = self.first[self.first[body as usize] as usize];
            self.first[body as usize] = before;
            body = before;
        }
        body
    }

    fn join(&mut self, a: u32, b: u32) {
        self.touch(a);
        self.touch(b);
        let [a, b] = [self.first_of(a), self.first_of(b)];
        if a != b {
            self.first[a.max(b) as usize] = a.min(b);
            self.parts -= 1;
        }
    }
}
