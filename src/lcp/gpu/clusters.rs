//! The clusters of a problem as a device reads them (`shaders/lcp/cluster.wgsl`), made by the host from the pairs.

use crate::lcp::clusters::{MOST_BODIES, MOST_ROWS, NOBODY, domains};
use crate::lcp::incidence::Incidence;

/// Words of a cluster, and of each of its rows.
const CLUSTER_WORDS: usize = 4;
#[cfg(test)]
const ROW_WORDS: usize = 3;

/// The number in a cluster of a side without mobility.
const NO_BODY: u32 = 255;
const _: () = assert!(MOST_BODIES <= NO_BODY as usize && MOST_ROWS < 1 << 16);

/// The tables of all clusters.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tables {
    /// How many clusters there are.
    pub clusters: usize,
    /// For every cluster where its rows and its bodies begin, and how many these are; then for every row of it its
    /// number, its bodies and the length of the pair that it begins, and the place of its displacement; and for every
    /// body where its list of rows begins, and these lists.
    pub words: Vec<u32>,
    /// Where the displacements of each row begin; one more at the end.
    pub part_start: Vec<u32>,
}

impl Tables {
    /// Of rows between these bodies, whose pairs begin at these rows. Numbers from `bodies` on are no bodies.
    pub fn of(bodies: usize, pair: &[[u32; 2]], block_start: &[u32]) -> Self {
        let moving = |body: u32| if (body as usize) < bodies { body } else { NOBODY };
        let sides: Vec<[u32; 2]> = pair.iter().map(|pair| pair.map(moving)).collect();
        let domains = domains(bodies, &sides);
        let mut length = vec![0; pair.len()];
        for edges in block_start.windows(2).filter(|edges| edges[0] < edges[1]) {
            length[edges[0] as usize] = edges[1] - edges[0];
        }
        let mut part_start = vec![0; pair.len() + 1];
        domains.iter().flatten().for_each(|row| part_start[*row as usize + 1] += 1);
        for row in 0..pair.len() {
            part_start[row + 1] += part_start[row];
        }
        let mut next = part_start.clone();
        let mut words = vec![0; CLUSTER_WORDS * domains.len()];
        for (nth, rows) in domains.iter().enumerate() {
            let rows_at = words.len();
            let (local, count) = numbered(rows, &sides);
            for (row, [a, b]) in rows.iter().zip(&local) {
                let place = &mut next[*row as usize];
                words.extend([*row, a | b << 8 | length[*row as usize] << 16, *place]);
                *place += 1;
            }
            let bodies_at = words.len();
            words[CLUSTER_WORDS * nth..][..CLUSTER_WORDS].copy_from_slice(&[
                rows_at as u32,
                rows.len() as u32,
                bodies_at as u32,
                count as u32,
            ]);
            add_lists(&mut words, &local, count);
        }
        Tables { clusters: domains.len(), words, part_start }
    }

    /// How many displacements of rows there are.
    pub fn parts(&self) -> u64 {
        self.part_start.last().map_or(0, |parts| u64::from(*parts))
    }
}

/// The sides of some rows by numbers from zero on, and how many bodies that are.
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

/// Adds where the lists of bodies begin, and the lists: twice a row's number in the cluster and its side.
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
        // Two pairs in a chain, the second of two rows, and a body at a wall.
        let pair = [[0, 1], [2, 1], [2, 1], [2, 7]];
        let tables = Tables::of(3, &pair, &[0, 0, 1, 3, 4]);
        assert_eq!((tables.clusters, tables.parts()), (1, 4));
        assert_eq!(tables.part_start, [0, 1, 2, 3, 4]);
        let one = |a: u32, b: u32, length: u32| a | b << 8 | length << 16;
        let rows = [[0, one(0, 1, 1), 0], [1, one(2, 1, 2), 1], [2, one(2, 1, 0), 2], [3, one(2, NO_BODY, 1), 3]];
        assert_eq!(tables.words[..4], [4, 4, 16, 3]);
        assert_eq!(tables.words[4..16], *rows.as_flattened());
        assert_eq!(tables.words[16..20], [20, 21, 24, 27]);
        assert_eq!(tables.words[20..], [0, 1, 3, 5, 2, 4, 6]);
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
