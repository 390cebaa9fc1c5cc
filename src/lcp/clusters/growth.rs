//! Grows clusters, one after the other.

use super::super::incidence::Incidence;
use super::{MOST_BODIES, MOST_MEMBERS, MOST_ROWS};

/// The partition so far.
pub(super) struct Growth<'a> {
    sides: &'a [[u32; 2]],
    incidence: &'a Incidence,
    bodies: usize,
    /// Whether a body belongs to a cluster.
    assigned: Vec<bool>,
    /// The rows of the present domain, the bodies all of whose rows are in it, and all bodies of its rows.
    rows: Marked,
    whole: Marked,
    touched: Marked,
}

/// A set of indices. Clearing or truncating it takes time only for the removed entries.
struct Marked {
    is: Vec<bool>,
    all: Vec<u32>,
}

impl Marked {
    fn new(most: usize) -> Self {
        Marked { is: vec![false; most], all: Vec::new() }
    }

    fn add(&mut self, number: u32) -> bool {
        let new = !std::mem::replace(&mut self.is[number as usize], true);
        if new {
            self.all.push(number);
        }
        new
    }

    fn shorten(&mut self, length: usize) {
        self.all.drain(length..).for_each(|number| self.is[number as usize] = false);
    }
}

impl<'a> Growth<'a> {
    /// For rows whose sides without mobility have the index `bodies`.
    pub fn new(bodies: usize, sides: &'a [[u32; 2]], incidence: &'a Incidence) -> Self {
        Growth {
            sides,
            incidence,
            bodies,
            assigned: vec![false; bodies],
            rows: Marked::new(sides.len()),
            whole: Marked::new(bodies),
            touched: Marked::new(bodies),
        }
    }

    /// The rows of the cluster that starts at a body. None if the body is in a cluster already, or has no rows.
    pub fn domain(&mut self, first: u32) -> Option<Vec<u32>> {
        if self.assigned[first as usize] || self.incidence.of(first as usize).is_empty() {
            return None;
        }
        if !self.take(first, true) && !self.take(first, false) {
            self.assigned[first as usize] = true;
            return None;
        }
        // Bodies next to members, with the number of rows that connect them.
        let mut near: Vec<(u32, u32)> = Vec::new();
        let mut newest = first;
        for _ in 1..MOST_MEMBERS {
            for entry in self.incidence.of(newest as usize) {
                let other = self.other(*entry);
                if other as usize == self.bodies || self.assigned[other as usize] {
                    continue;
                }
                match near.iter_mut().find(|(body, _)| *body == other) {
                    Some((_, joins)) => *joins += 1,
                    None => near.push((other, 1)),
                }
            }
            let Some(best) = (0..near.len()).rev().max_by_key(|k| near[*k].1) else { break };
            (newest, _) = near.remove(best);
            if !self.take(newest, true) {
                break;
            }
        }
        let mut rows = self.rows.all.clone();
        rows.sort_unstable();
        self.shorten([0; 3]);
        Some(rows)
    }

    /// Takes a body into the cluster, with all rows of its neighbours or only its own, unless a limit forbids it.
    fn take(&mut self, body: u32, with_layer: bool) -> bool {
        let before = [self.rows.all.len(), self.whole.all.len(), self.touched.all.len()];
        self.take_rows(body);
        if with_layer {
            for entry in self.incidence.of(body as usize) {
                let other = self.other(*entry);
                if (other as usize) < self.bodies {
                    self.take_rows(other);
                }
            }
        }
        let fits = self.rows.all.len() <= MOST_ROWS && self.touched.all.len() <= MOST_BODIES;
        if fits {
            self.assigned[body as usize] = true;
        } else {
            self.shorten(before);
        }
        fits
    }

    fn take_rows(&mut self, body: u32) {
        if !self.whole.add(body) {
            return;
        }
        for entry in self.incidence.of(body as usize) {
            let row = entry / 2;
            if self.rows.add(row) {
                for side in self.sides[row as usize] {
                    if (side as usize) < self.bodies {
                        self.touched.add(side);
                    }
                }
            }
        }
    }

    fn other(&self, entry: u32) -> u32 {
        self.sides[(entry / 2) as usize][1 - (entry % 2) as usize]
    }

    fn shorten(&mut self, [rows, whole, touched]: [usize; 3]) {
        self.rows.shorten(rows);
        self.whole.shorten(whole);
        self.touched.shorten(touched);
    }
}
