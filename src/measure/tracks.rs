//! The tracks of bodies over the states of a run: each by its id, from its birth to its division.
//!
//! The total rotation of a body is the sum of its rotation vectors from state to state, which is unbounded (S.
//! Kämmerer, W. Kob, R. Schilling, Phys. Rev. E 56, 5450 (1997)). It is correct if a body turns by less than half a
//! turn between two states.

use crate::bodies::Bodies;
use crate::fixed::Fixed;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;

/// The largest number of points of all tracks, about 700 MB: in long runs fewer bodies are followed.
const POINTS: usize = 1 << 23;
/// The largest number of bodies that are followed: the standard error of a mean square over this many free ones is 1.3
/// % in space.
const MOST: usize = 4096;
/// The smallest number if there are many states.
const LEAST: usize = 64;

/// A body in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its centre, not wrapped into a cell.
    pub position: DVec3,
    /// The sum of its rotation vectors since its first state.
    pub turned: DVec3,
    /// The direction of its velocity; zero at rest.
    pub direction: DVec3,
}

/// A body over consecutive states.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The index of its first state.
    pub first: usize,
    /// The body in this state and the following ones.
    pub points: Vec<Point>,
    last: DQuat,
}

/// The tracks of a run's bodies: of all, or of a random selection if there are many. Fixed bodies have none.
#[derive(Clone, Debug)]
pub struct Tracks {
    /// The tracks, in the order of their first states and of the bodies there.
    pub all: Vec<Track>,
    /// The limit on followed bodies per state, if it was exceeded.
    pub drawn: Option<usize>,
    most: usize,
    seed: u64,
    states: usize,
    open: BTreeMap<u64, usize>,
}

impl Tracks {
    /// No tracks yet, for a run of `states` states; if there are many bodies, `seed` selects those that are followed.
    pub fn new(states: usize, seed: u64) -> Tracks {
        let most = (POINTS / states.max(1)).clamp(LEAST, MOST);
        Tracks { all: Vec::new(), drawn: None, most, seed, states: 0, open: BTreeMap::new() }
    }

    /// Adds the next state.
    pub fn push(&mut self, bodies: &Bodies, fixed: &Fixed) {
        let mut open = BTreeMap::new();
        for i in self.chosen(bodies, fixed) {
            let id = bodies.lineage[i].id;
            let (q, position) = (bodies.orientation[i], bodies.position[i]);
            let direction = bodies.velocity[i].normalize_or_zero();
            let at = match self.open.get(&id) {
                Some(&at) => at,
                None => {
                    self.all.push(Track { first: self.states, points: Vec::new(), last: q });
                    self.all.len() - 1
                }
            };
            let track = &mut self.all[at];
            let before = track.points.last().map_or(DVec3::ZERO, |point| point.turned);
            let turned = before + rotation_vector(q * track.last.conjugate());
            track.points.push(Point { position, turned, direction });
            track.last = q;
            open.insert(id, at);
        }
        self.open = open;
        self.states += 1;
    }

    /// The number of states so far.
    pub fn states(&self) -> usize {
        self.states
    }

    /// The bodies to follow, in their order: if there are many, those whose ids come first in a random order by the
    /// seed, so that the next state follows the same ones.
    fn chosen(&mut self, bodies: &Bodies, fixed: &Fixed) -> Vec<usize> {
        let mut chosen: Vec<usize> =
            (0..bodies.len()).filter(|&i| !fixed.holds(bodies.lineage[i].id, bodies.group[i])).collect();
        if chosen.len() > self.most {
            let rank = |i: &usize| (mixed(bodies.lineage[*i].id ^ mixed(self.seed)), *i);
            chosen.select_nth_unstable_by_key(self.most, rank);
            chosen.truncate(self.most);
            chosen.sort_unstable();
            self.drawn = Some(self.most);
        }
        chosen
    }
}

/// A pseudorandom number: the output function of SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
fn mixed(number: u64) -> u64 {
    let z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Axis times angle of a rotation, the angle at most half a turn.
fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    if sine == 0.0 { DVec3::ZERO } else { q.xyz() * (2.0 * sine.atan2(q.w) / sine) }
}
