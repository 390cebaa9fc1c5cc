//! One record for each pair: what a step knows of it between verbs.

use super::narrow_phase::Near;
use crate::walls::surface_of;
use crate::warm::Warm;
use glam::DVec3;

/// What is known of a pair. The second of a pair may be a surface of a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub pair: [u32; 2],
    /// The normal found last, where the next search starts; zero where none was found.
    normal: DVec3,
    /// The range of its multipliers in the last step's warm start, and of its rows among the first rows.
    recalled: [u32; 2],
    rows: [u32; 2],
}

impl Record {
    fn of(near: &Near) -> Record {
        Record { pair: near.pair, normal: near.found.normal, recalled: [0; 2], rows: [0; 2] }
    }

    /// The normal found last.
    pub fn normal(&self) -> Option<DVec3> {
        (self.normal != DVec3::ZERO).then_some(self.normal)
    }

    /// Its first rows.
    pub fn first_rows(&self) -> std::ops::Range<usize> {
        self.rows[0] as usize..self.rows[1] as usize
    }
}

/// What a contact ended the last step with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recalled {
    /// The multiplier of its normal rows.
    pub gamma: f64,
    /// Its friction force on the second body.
    pub tangent: DVec3,
}

impl From<Warm> for Recalled {
    fn from(warm: Warm) -> Recalled {
        Recalled { gamma: warm.gamma, tangent: warm.tangent }
    }
}

/// The records of all pairs, sorted by pair.
#[derive(Default)]
pub struct Pairs {
    records: Vec<Record>,
    /// The warm start from the last step, or from the first half of this one; sorted by pair and feature.
    warm: Vec<Warm>,
}

impl Pairs {
    /// Sets the warm start.
    pub fn remember(&mut self, warm: &[Warm]) {
        warm.clone_into(&mut self.warm);
    }

    /// Makes the records of the pairs that the last step left.
    pub fn recall(&mut self) {
        self.records.clear();
        let mut first = 0;
        for of_pair in self.warm.chunk_by(|w, v| w.pair == v.pair) {
            let last = first + of_pair.len() as u32;
            let normal = of_pair.iter().map(|w| w.normal).find(|normal| *normal != DVec3::ZERO).unwrap_or_default();
            self.records.push(Record { pair: of_pair[0].pair, normal, recalled: [first, last], rows: [0; 2] });
            first = last;
        }
    }

    /// Makes the records of the pairs with first rows, in place of those of the last step. `found` has the separation
    /// of each near pair, and `rows` the rows of these and of walls; both sorted by pair.
    pub fn keep(&mut self, found: &[Near], rows: &[Near]) {
        self.records.clear();
        let (mut found, mut first) = (found.iter().peekable(), 0);
        for of_pair in rows.chunk_by(|near, next| near.pair == next.pair) {
            let (pair, last) = (of_pair[0].pair, first + of_pair.len() as u32);
            while found.next_if(|near| near.pair < pair).is_some() {}
            let normal = found.next_if(|near| near.pair == pair).map_or(DVec3::ZERO, |near| near.found.normal);
            self.records.push(Record { pair, normal, recalled: [0; 2], rows: [first, last] });
            first = last;
        }
    }

    /// Takes over the normals of `found` (sorted by pair).
    pub fn renew(&mut self, found: &[Near]) {
        let (mut new, mut at) = (Vec::new(), 0);
        for near in found {
            at += self.records[at..].partition_point(|record| record.pair < near.pair);
            match self.records.get_mut(at).filter(|record| record.pair == near.pair) {
                Some(record) => record.normal = near.found.normal,
                None => new.push(Record::of(near)),
            }
        }
        if !new.is_empty() {
            self.records.extend(new);
            self.records.sort_by_key(|record| record.pair);
        }
    }

    /// The record of a pair.
    pub fn get(&self, pair: [u32; 2]) -> Option<&Record> {
        let at = self.records.binary_search_by_key(&pair, |record| record.pair).ok()?;
        self.records.get(at)
    }

    /// An iterator over records from `pair` on, for ordered lookups.
    pub fn from(&self, pair: [u32; 2]) -> Cursor<'_> {
        let first = self.records.partition_point(|record| record.pair < pair);
        Cursor { rest: &self.records[first..] }
    }

    /// The multipliers that a pair ended the last step with, by feature.
    pub fn recalled(&self, record: Option<&Record>) -> &[Warm] {
        record.map_or(&[], |record| &self.warm[record.recalled[0] as usize..record.recalled[1] as usize])
    }

    /// What first contacts (sorted by pair and feature) start from: those that their branches ended the
    /// last step with. What a branch without a row ended with goes to the pair's nearest one.
    pub fn multipliers(&self, rows: &[Near]) -> Vec<Recalled> {
        let mut all = vec![Recalled::default(); rows.len()];
        let mut cursor = Cursor { rest: &self.records };
        let mut first = 0;
        for of_pair in rows.chunk_by(|near, next| near.pair == next.pair) {
            let pair = of_pair[0].pair;
            let separation = |row: &usize| of_pair[*row].found.separation;
            let nearest = (0..of_pair.len()).min_by(|i, j| separation(i).total_cmp(&separation(j))).unwrap_or(0);
            let wall = surface_of(pair[1]).is_some();
            for w in self.recalled(cursor.find(pair)) {
                let own = of_pair.iter().position(|near| near.feature == w.feature);
                if let Some(row) = own.or((!wall).then_some(nearest)) {
                    all[first + row].gamma += w.gamma;
                    all[first + row].tangent += w.tangent;
                }
            }
            first += of_pair.len();
        }
        all
    }

    /// Copies the normals to the same pairs in `warm` (sorted).
    pub fn copy_normals(&self, warm: &mut [Warm]) {
        let mut cursor = Cursor { rest: &self.records };
        for w in warm {
            w.normal = cursor.find(w.pair).map_or(w.normal, |record| record.normal);
        }
    }
}

/// A walk along the records.
pub struct Cursor<'a> {
    rest: &'a [Record],
}

impl<'a> Cursor<'a> {
    /// The record of `pair`, which must not precede the last one looked up.
    pub fn find(&mut self, pair: [u32; 2]) -> Option<&'a Record> {
        while self.rest.first().is_some_and(|record| record.pair < pair) {
            self.rest = &self.rest[1..];
        }
        self.rest.first().filter(|record| record.pair == pair)
    }
}
