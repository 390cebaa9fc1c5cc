//! The order in which bodies are eliminated from a sparse symmetric matrix with a block a body and a link, and the
//! pattern of its Cholesky factor.
//!
//! Approximate minimum degree (P. R. Amestoy, T. A. Davis, I. S. Duff, 1996), postordered. Bodies that follow each
//! other and have the same rows below them are a supernode: their columns are one dense panel. Small ones are merged
//! where that stores few zeros (C. Ashcraft, R. Grimes, The influence of relaxed supernode partitions on the multifrontal
//! method, 1989), wide ones are cut.

use std::ops::Range;

/// Most unknowns of a panel: wider ones are cut, so that all but little of the work is products of panels.
const WIDEST: usize = 48;

/// The part of zeros that a merged supernode may store.
const ZEROS: f64 = 0.05;

/// Bodies that follow each other in the order of elimination, and share a panel.
#[derive(Clone, Debug)]
pub(super) struct Supernode {
    /// Their places.
    pub own: Range<usize>,
    /// Where the places of the panel's rows are in [`Pattern::row`]: ascending, its own first.
    rows: Range<usize>,
    /// Where its panel starts among the numbers.
    pub start: usize,
    /// What its panel takes from earlier ones.
    pub updates: Vec<Update>,
}

/// The rows of an earlier panel that a panel has too.
#[derive(Clone, Debug)]
pub(super) struct Update {
    /// The earlier panel.
    pub from: usize,
    /// How many of its rows come before them.
    pub skipped: usize,
    /// How many of them are among the panel's columns.
    pub columns: usize,
}

/// The pattern of a factor.
#[derive(Debug, Default)]
pub(super) struct Pattern {
    /// The place of each body in the order of elimination.
    pub place: Vec<u32>,
    /// The supernode of each place.
    pub node: Vec<u32>,
    pub nodes: Vec<Supernode>,
    row: Vec<u32>,
    /// How many numbers its panels hold.
    pub numbers: usize,
}

impl Pattern {
    /// Finds it for distinct links between bodies, with blocks of `size` by `size` numbers. None if it would have more
    /// than `largest` numbers.
    pub fn find(bodies: usize, links: &[[u32; 2]], size: usize, largest: usize) -> Option<Pattern> {
        let columns = Columns::find(bodies, links, largest / (size * size))?;
        let mut pattern = Pattern { place: columns.place.clone(), ..Pattern::default() };
        for own in columns.supernodes() {
            let last = &columns.below[own.end - 1];
            let mut first = own.start;
            while first < own.end {
                let end = own.end.min(first + (WIDEST / size).max(1));
                let rows = pattern.row.len()..pattern.row.len() + own.end - first + last.len();
                let start = pattern.numbers;
                pattern.numbers = (rows.len() * (end - first) * size * size).checked_add(start)?;
                pattern.row.extend((first..own.end).map(|place| place as u32).chain(last.iter().copied()));
                pattern.node.resize(end, pattern.nodes.len() as u32);
                pattern.nodes.push(Supernode { own: first..end, rows, start, updates: Vec::new() });
                first = end;
            }
        }
        pattern.find_updates();
        (pattern.numbers <= largest).then_some(pattern)
    }

    fn find_updates(&mut self) {
        for from in 0..self.nodes.len() {
            let node = &self.nodes[from];
            let (rows, mut skipped) = (&self.row[node.rows.clone()], node.own.len());
            while let Some(place) = rows.get(skipped) {
                let later = &mut self.nodes[self.node[*place as usize] as usize];
                let columns = rows[skipped..].partition_point(|place| (*place as usize) < later.own.end);
                later.updates.push(Update { from, skipped, columns });
                skipped += columns;
            }
        }
    }

    /// Multiplications of a factorization, about: the squares of its columns, with blocks of `D` by `D` numbers.
    pub fn work<const D: usize>(&self) -> f64 {
        let squares = |node: &Supernode| {
            let [height, width] = [D * node.rows.len(), D * node.own.len()];
            (height - width + 1..=height).map(|length| (length as f64).powi(2)).sum::<f64>()
        };
        self.nodes.iter().map(squares).sum()
    }

    /// Where the block between two places, which may be the same, is among the numbers, and how far apart its columns
    /// are. Its columns are of the earlier place.
    pub fn block<const D: usize>(&self, [a, b]: [u32; 2]) -> (usize, usize) {
        let (column, row) = (a.min(b), a.max(b));
        let node = &self.nodes[self.node[column as usize] as usize];
        let rows = self.rows(node);
        let (right, down) = (column as usize - node.own.start, rows.partition_point(|place| *place < row));
        (node.start + D * (right * D * rows.len() + down), D * rows.len())
    }

    /// The places of a panel's rows.
    pub fn rows(&self, node: &Supernode) -> &[u32] {
        &self.row[node.rows.clone()]
    }
}

/// The rows below the diagonal of each column, in the order of elimination.
struct Columns {
    place: Vec<u32>,
    below: Vec<Vec<u32>>,
}

impl Columns {
    /// None if there are more than `most`, the diagonal's with them.
    fn find(bodies: usize, links: &[[u32; 2]], most: usize) -> Option<Columns> {
        if bodies + links.len() > most {
            return None;
        }
        let place = minimum_degree(bodies, links)?;
        let mut below = vec![Vec::new(); bodies];
        for link in links {
            let [a, b] = link.map(|body| place[body as usize]);
            below[a.min(b) as usize].push(a.max(b));
        }
        let mut children = vec![Vec::new(); bodies];
        let mut count = bodies;
        for column in 0..bodies {
            let mut rows = std::mem::take(&mut below[column]);
            for child in &children[column] {
                let of_child: &Vec<u32> = &below[*child as usize];
                rows.extend(&of_child[1..]);
            }
            rows.sort_unstable();
            rows.dedup();
            count += rows.len();
            if count > most {
                return None;
            }
            if let Some(parent) = rows.first() {
                children[*parent as usize].push(column as u32);
            }
            below[column] = rows;
        }
        Some(Columns { place, below }.postordered(&children))
    }

    /// Each column right after the subtrees of its children, whose patterns it holds.
    fn postordered(self, children: &[Vec<u32>]) -> Columns {
        let bodies = self.below.len();
        let mut after = vec![0; bodies];
        let mut next = bodies as u32;
        let mut open: Vec<u32> = (0..bodies as u32).filter(|column| self.below[*column as usize].is_empty()).collect();
        // From the last one on: a column, then what is before it.
        while let Some(column) = open.pop() {
            next -= 1;
            after[column as usize] = next;
            open.extend(&children[column as usize]);
        }
        let mut below = vec![Vec::new(); bodies];
        for (mut rows, after_this) in self.below.into_iter().zip(&after) {
            rows.iter_mut().for_each(|row| *row = after[*row as usize]);
            rows.sort_unstable();
            below[*after_this as usize] = rows;
        }
        Columns { place: self.place.iter().map(|place| after[*place as usize]).collect(), below }
    }

    /// Columns with the same rows, merged where few zeros are stored by that.
    fn supernodes(&self) -> Vec<Range<usize>> {
        let length = |column: usize| self.below[column].len();
        let parent = |column: usize| self.below[column].first().map(|row| *row as usize);
        let mut nodes: Vec<Range<usize>> = Vec::new();
        for column in 0..self.below.len() {
            match nodes.last_mut() {
                Some(node) if parent(column - 1) == Some(column) && length(column - 1) == length(column) + 1 => {
                    node.end = column + 1;
                }
                _ => nodes.push(column..column + 1),
            }
        }
        let mut merged: Vec<(Range<usize>, usize)> = Vec::new();
        for node in nodes {
            let mut entries: usize = node.clone().map(|column| 1 + length(column)).sum();
            let mut own = node;
            while let Some((child, of_child)) = merged.last() {
                let columns = own.end - child.start;
                let stored = columns * (columns + 1) / 2 + columns * length(own.end - 1);
                let zeros = || (stored - entries - of_child) as f64;
                let is_child = parent(child.end - 1).is_some_and(|column| own.contains(&column));
                if !is_child || zeros() > ZEROS * stored as f64 {
                    break;
                }
                own.start = child.start;
                entries += of_child;
                merged.pop();
            }
            merged.push((own, entries));
        }
        merged.into_iter().map(|(own, _)| own).collect()
    }
}

/// The place of each body.
fn minimum_degree(bodies: usize, links: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut entries: Vec<[i32; 2]> = links.iter().map(|link| link.map(|body| body as i32)).collect();
    // The crate counts on a diagonal.
    entries.extend((0..bodies as i32).map(|body| [body; 2]));
    entries.sort_unstable();
    let start: Vec<i32> =
        (0..=bodies as i32).map(|body| entries.partition_point(|[column, _]| *column < body) as i32).collect();
    let row: Vec<i32> = entries.iter().map(|[_, row]| *row).collect();
    let (_, place, _) = amd::order(bodies as i32, &start, &row, &amd::Control::default()).ok()?;
    Some(place.into_iter().map(|place| place as u32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice.
    fn lattice(side: u32) -> Vec<[u32; 2]> {
        let right = (0..side * side).filter(|body| body % side + 1 < side).map(|body| [body, body + 1]);
        right.chain((0..side * (side - 1)).map(|body| [body, body + side])).collect()
    }

    #[test]
    fn panels_hold_all_blocks_of_the_matrix_and_of_the_factor() {
        let links = lattice(9);
        let pattern = Pattern::find(81, &links, 3, 1 << 20).unwrap();
        let mut places = pattern.place.clone();
        places.sort_unstable();
        assert_eq!(places, (0..81).collect::<Vec<u32>>());
        let rows_of = |place: u32| pattern.rows(&pattern.nodes[pattern.node[place as usize] as usize]);
        for link in &links {
            let [a, b] = link.map(|body| pattern.place[body as usize]);
            assert!(rows_of(a.min(b)).contains(&a.max(b)));
        }
        for node in &pattern.nodes {
            let rows = pattern.rows(node);
            assert!(
                rows.is_sorted() && rows[..node.own.len()].iter().map(|place| *place as usize).eq(node.own.clone())
            );
            // What a column has below the diagonal, the first of these has too.
            let below = &rows[node.own.len()..];
            assert!(below.iter().all(|place| rows_of(below[0]).contains(place)));
        }
    }

    #[test]
    fn orders_that_fill_in_little_are_found() {
        let chain: Vec<[u32; 2]> = (1..500).map(|body| [body - 1, body]).collect();
        let pattern = Pattern::find(500, &chain, 1, 1 << 20).unwrap();
        assert!(pattern.numbers <= 4 * 500, "{}", pattern.numbers);
        // From left to right the factor of this lattice has 61,504 numbers.
        let pattern = Pattern::find(1024, &lattice(32), 1, 1 << 20).unwrap();
        assert!(pattern.numbers < 20_000, "{}", pattern.numbers);
        assert!(Pattern::find(1024, &lattice(32), 1, pattern.numbers).is_some());
        assert!(Pattern::find(1024, &lattice(32), 1, pattern.numbers - 1).is_none());
        assert!(Pattern::find(0, &[], 3, 0).is_some());
    }
}
