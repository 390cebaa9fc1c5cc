//! The clusters of a problem in the device's format (`shaders/lcp/cluster.wgsl`). The host makes them from the pairs.

use crate::lcp::clusters::{MOST_BODIES, MOST_ROWS, NOBODY, domains};
use crate::lcp::incidence::Incidence;

/// Words per cluster, and per row of a cluster.
const CLUSTER_WORDS: usize = 6;
#[cfg(test)]
const ROW_WORDS: usize = 3;

/// The local number of a side without mobility.
const NO_BODY: u32 = 255;
const _: () = assert!(MOST_BODIES <= NO_BODY as usize && MOST_ROWS < 1 << 16);

/// The tables of all clusters.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tables {
    /// The number of clusters.
    pub clusters: usize,
    /// For every cluster, the offsets and the numbers of its rows, pairs and bodies; then for every row its number, its
    /// bodies, and the offset of its displacement; for every pair its first row and its number of rows; and for every
    /// body the offset of its list of rows, and these lists.
    pub words: Vec<u32>,
    /// The offset of each row's displacements, and the total at the end.
    pub part_start: Vec<u32>,
}

impl Tables {
    /// The tables for rows between these bodies; `block_start` has the first row of each pair. Numbers of at least
    /// `bodies` are not bodies.
    pub fn of(bodies: usize, pair: &[[u32; 2]], block_start: &[u32]) -> Self {
        let moving = |body: u32| if (body as usize) < bodies { body } else { NOBODY };
        let sides: Vec<[u32; 2]> = pair.iter().map(|pair| pair.map(moving)).collect();
        let domains = domains(bodies, &sides);
        // The number of rows in each row's pair.
        let mut size = vec![0; pair.len()];
        for edges in block_start.windows(2) {
            size[edges[0] as usize..edges[1] as usize].fill(edges[1] - edges[0]);
        }
        let mut part_start = vec![0; pair.len() + 1];
        domains.iter().flatten().for_each(|row| part_start[*row as usize + 1] += 1);
        for row in 0..pair.len() {
            part_start[row + 1] += part_start[row];
        }
        let mut next = part_start.clone();
        let clusters = domains.len();
        let mut words = vec![0; CLUSTER_WORDS * clusters];
        for (nth, mut rows) in domains.into_iter().enumerate() {
            // The rows of a pair stay together.
            rows.sort_by_key(|row| size[*row as usize]);
            let rows_at = words.len();
            let (local, count) = numbered(&rows, &sides);
            for (row, [a, b]) in rows.iter().zip(&local) {
                let place = &mut next[*row as usize];
                words.extend([*row, a | b << 8, *place]);
                *place += 1;
            }
            let pairs_at = words.len();
            let mut first = 0;
            while let Some(row) = rows.get(first) {
                words.push(first as u32 | size[*row as usize] << 16);
                first += size[*row as usize] as usize;
            }
            let bodies_at = words.len();
            let record = [rows_at, rows.len(), pairs_at, bodies_at - pairs_at, bodies_at, count];
            words[CLUSTER_WORDS * nth..][..CLUSTER_WORDS].copy_from_slice(&record.map(|word| word as u32));
            add_lists(&mut words, &local, count);
        }
        Tables { clusters, words, part_start }
    }

    /// The number of displacements of rows.
    pub fn parts(&self) -> u64 {
        self.part_start.last().map_or(0, |parts| u64::from(*parts))
    }
}

/// The sides of some rows with bodies numbered from zero, and the number of these bodies.
fn numbered(rows: &[u32], sides: &[[u32; 2]]) -> (Vec<[u32; 2]>, usize) {
    let of = |row: &u32| sides[*row as usize];
    let mut bodies: Vec<u32> = rows.iter().flat_map(of).filter(|body| *body != NOBODY).collect();
    bodies.sort_unstable();
    bodies.dedup();
    let number = |body: u32| match body {
        NOBODY => NO_BODY,
        _ => bodies.partition_point(|other| *other < body) as u32,
    };
    (rows.iter().map(|row| of(row).map(number)).collect(), bodies.len())
}

/// Appends the offsets of the bodies' lists, and the lists: twice a row's number in the cluster, plus the side.
fn add_lists(words: &mut Vec<u32>, sides: &[[u32; 2]], bodies: usize) {
    let walls = |sides: &[u32; 2]| sides.map(|body| body.min(bodies as u32));
    let sides: Vec<[u32; 2]> = sides.iter().map(walls).collect();
    let mut incidence = Incidence::default();
    incidence.rebuild(bodies + 1, &sides);
    let lists_at = (words.len() + bodies + 1) as u32;
    let starts = &incidence.start[..=bodies];
    words.extend(starts.iter().map(|start| lists_at + start));
    words.extend(&incidence.entries[..starts[bodies] as usize]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_every_row_and_its_sides() {
        // Two pairs in a chain, the second with two rows, and a body at a wall.
        let pair = [[0, 1], [2, 1], [2, 1], [2, 7]];
        let tables = Tables::of(3, &pair, &[0, 0, 1, 3, 4]);
        assert_eq!((tables.clusters, tables.parts()), (1, 4));
        assert_eq!(tables.part_start, [0, 1, 2, 3, 4]);
        // Pairs with one row come first.
        let rows = [[0, 1 << 8, 0], [3, 2 | NO_BODY << 8, 3], [1, 2 | 1 << 8, 1], [2, 2 | 1 << 8, 2]];
        assert_eq!(tables.words[..6], [6, 4, 18, 3, 21, 3]);
        assert_eq!(tables.words[6..18], *rows.as_flattened());
        assert_eq!(tables.words[18..21], [1 << 16, 1 | 1 << 16, 2 | 2 << 16]);
        assert_eq!(tables.words[21..25], [25, 26, 29, 32]);
        assert_eq!(tables.words[25..], [0, 1, 5, 7, 2, 4, 6]);
    }

    #[test]
    fn displacements_have_places_of_their_own() {
        let pair: Vec<[u32; 2]> = (0..99).map(|body| [body, body + 1]).collect();
        let starts: Vec<u32> = (0..=99).collect();
        let tables = Tables::of(100, &pair, &starts);
        let mut places: Vec<u32> = (0..tables.clusters)
            .flat_map(|nth| {
                let [at, rows] = [0, 1].map(|word| tables.words[CLUSTER_WORDS * nth + word] as usize);
                (0..rows).map(move |row| at + ROW_WORDS * row + 2).collect::<Vec<_>>()
            })
            .map(|place| tables.words[place])
            .collect();
        assert!(tables.clusters > 4 && places.len() > 99);
        places.sort_unstable();
        assert!(places.into_iter().eq(0..tables.parts() as u32));
        assert_eq!(Tables::of(0, &[], &[0]), Tables { clusters: 0, words: vec![], part_start: vec![0] });
    }
}
