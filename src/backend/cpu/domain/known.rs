//! What is known of all bodies beside where they are, and of pairs by the owners of their bodies.

use super::Domain;
use super::halo::Halo;
use crate::bisection::Blocks;
use crate::bodies::Bodies;
use crate::processes::Processes;
use crate::step::State;
use crate::walls::surface_of;
use crate::warm::Warm;
use glam::DVec3;
use std::ops::Range;
use std::sync::OnceLock;

/// What a body is counted for beside its rows, in rows: its poses, boxes and candidates. A step of a colony spends nine
/// tenths of its time on rows and near pairs, of which it has 2.7 a body.
pub(super) const WORK_OF_A_BODY: f64 = 1.0;

/// The work of a body that nothing is known of: the mean of a colony.
const WORK_AT_FIRST: f64 = 3.5;

/// The way of a body that nothing is known of, and the least way of any, as parts of the longest side of its box:
/// bodies at rest may be hit. They change no result, only how often a step is made anew, and how long the halo is.
const WAY_AT_FIRST: f64 = 0.05;
const LEAST_WAY: f64 = 0.02;

/// Of each body: whose it is, what it costs, and how far it may go in a step.
pub(super) struct Known {
    pub owner: Vec<u32>,
    pub work: Vec<f64>,
    pub way: Vec<f64>,
}

impl Known {
    /// Of bodies that are seen for the first time.
    pub fn nothing(bodies: &Bodies) -> Self {
        let known = Known { owner: Vec::new(), work: Vec::new(), way: Vec::new() };
        known.grown(bodies)
    }

    /// With the bodies that were born.
    pub fn grown(&self, bodies: &Bodies) -> Self {
        let side = |body: usize| 2.0 * bodies.shape[body].half_extents(bodies.orientation[body]).max_element();
        let way = |body: usize| match self.way.get(body) {
            Some(way) => way.max(LEAST_WAY * side(body)),
            None => WAY_AT_FIRST * side(body),
        };
        Known {
            owner: Vec::new(),
            work: (0..bodies.len()).map(|body| self.work.get(body).copied().unwrap_or(WORK_AT_FIRST)).collect(),
            way: (0..bodies.len()).map(way).collect(),
        }
    }

    /// Gives each process the bodies of its blocks.
    pub fn own(&mut self, blocks: &Blocks, shares: &[Range<usize>]) {
        self.owner = vec![0; blocks.order.len()];
        for (process, share) in (0..).zip(shares) {
            let bodies = blocks.edges[share.start] as usize..blocks.edges[share.end] as usize;
            blocks.order[bodies].iter().for_each(|body| self.owner[*body as usize] = process);
        }
    }
}

/// Tells all processes numbers of each body, which its owner has.
pub(super) fn spread<const N: usize>(
    processes: Processes,
    owner: &[u32],
    own: impl Fn(usize) -> [f64; N],
    mut put: impl FnMut(usize, [f64; N]),
) {
    let mut counts = vec![0; processes.size()];
    owner.iter().for_each(|process| counts[*process as usize] += N);
    let rank = processes.rank() as u32;
    let bodies = (0..owner.len()).filter(|body| owner[*body] == rank);
    let numbers: Vec<f64> = bodies.flat_map(own).collect();
    let mut all = vec![0.0; N * owner.len()];
    processes.gather_into(&numbers, &counts, &mut all);
    let mut next: Vec<usize> =
        counts.iter().scan(0, |next, count| Some(std::mem::replace(next, *next + count))).collect();
    for (body, process) in owner.iter().enumerate() {
        let next = &mut next[*process as usize];
        put(body, std::array::from_fn(|k| all[*next + k]));
        *next += N;
    }
}

/// Words of what is remembered of a contact.
const WORDS: usize = 6;

fn pack(warm: &Warm) -> [u64; WORDS] {
    let Warm { pair: [a, b], feature, gamma, normal } = *warm;
    let [x, y, z] = normal.to_array().map(f64::to_bits);
    [u64::from(a) << 32 | u64::from(b), feature.into(), gamma.to_bits(), x, y, z]
}

fn unpack(words: &[u64; WORDS]) -> Warm {
    let [pair, feature, gamma, normal @ ..] = *words;
    Warm {
        pair: [(pair >> 32) as u32, pair as u32],
        feature: feature as u32,
        gamma: f64::from_bits(gamma),
        normal: DVec3::from_array(normal.map(f64::from_bits)),
    }
}

/// Sorted as a state has them.
fn from_words(words: &[u64]) -> Vec<Warm> {
    let mut warm: Vec<Warm> = words.as_chunks::<WORDS>().0.iter().map(unpack).collect();
    warm.sort_unstable_by_key(|warm| (warm.pair, warm.feature));
    warm
}

impl Domain {
    /// What is remembered of the pairs of own bodies, by their places in the domain, from what the owners `before`
    /// have.
    pub(super) fn hand_over(&self, halo: &Halo, owner: &[u32], before: Option<&[u32]>, warm: &[Warm]) -> Vec<Warm> {
        let rank = self.processes.rank() as u32;
        let bodies = |warm: &Warm| [Some(warm.pair[0]), Some(warm.pair[1]).filter(|b| surface_of(*b).is_none())];
        let is_own = |warm: &Warm| bodies(warm).into_iter().flatten().any(|body| owner[body as usize] == rank);
        let mut own: Vec<Warm> = warm.iter().filter(|warm| is_own(warm)).copied().collect();
        if let Some(before) = before {
            let mut lists = vec![Vec::new(); self.processes.size()];
            for warm in warm.iter().filter(|warm| before[warm.pair[0] as usize] == rank) {
                let [a, b] = bodies(warm);
                let has = [a, b].map(|body| body.map(|body| before[body as usize]));
                let mut needs: Vec<u32> = [a, b].into_iter().flatten().map(|body| owner[body as usize]).collect();
                needs.dedup();
                for process in needs.into_iter().filter(|process| !has.contains(&Some(*process))) {
                    lists[process as usize].extend(pack(warm));
                }
            }
            let come = self.processes.deliver(lists).concat();
            own.extend(come.as_chunks::<WORDS>().0.iter().map(unpack));
            own.sort_unstable_by_key(|warm| (warm.pair, warm.feature));
        }
        // Bodies that have parted do not know each other any more.
        let here = |mut warm: Warm| {
            warm.pair[0] = halo.place(warm.pair[0] as usize)? as u32;
            if surface_of(warm.pair[1]).is_none() {
                warm.pair[1] = halo.place(warm.pair[1] as usize)? as u32;
            }
            Some(warm)
        };
        own.into_iter().filter_map(here).collect()
    }

    /// What this process remembers for all: of pairs whose first body was its own.
    fn words(&self, state: &State) -> Vec<u64> {
        let Some(known) = &self.known else { return Vec::new() };
        let rank = self.processes.rank() as u32;
        state.warm.iter().filter(|warm| known.owner[warm.pair[0] as usize] == rank).flat_map(pack).collect()
    }

    /// Makes what is remembered of pairs whole on all processes, which must do so together.
    pub(in crate::backend::cpu) fn make_whole(&mut self, state: &mut State) {
        if self.known.is_some() {
            state.warm = from_words(&self.processes.gather(&self.words(state)));
            self.known = None;
        }
        self.step = None;
        self.gathered = OnceLock::new();
    }

    /// Whether what is remembered of pairs must be gathered for a state.
    pub(in crate::backend::cpu) fn is_partial(&self) -> bool {
        self.known.is_some() && self.gathered.get().is_none()
    }

    /// The state with all that is remembered of pairs, on process 0. All processes must ask together.
    pub(in crate::backend::cpu) fn gathered<'a>(&'a self, state: &'a State) -> &'a State {
        if self.known.is_none() {
            return state;
        }
        self.gathered.get_or_init(|| {
            let warm = from_words(&self.processes.gather_at_first(&self.words(state)));
            if self.processes.rank() > 0 {
                return State::default();
            }
            State {
                step: state.step,
                next_id: state.next_id,
                bodies: state.bodies.clone(),
                warm,
                removed: state.removed.clone(),
                unrounded: None,
            }
        })
    }

    /// Forgets what is known, as all is: a state has come from elsewhere.
    pub(in crate::backend::cpu) fn forget(&mut self) {
        (self.known, self.step, self.anew, self.gathered) = (None, None, None, OnceLock::new());
    }

    /// Goes on without some bodies.
    pub(in crate::backend::cpu) fn remove(&mut self, keep: &[bool]) {
        fn kept<T>(array: &mut Vec<T>, keep: &[bool]) {
            let mut flags = keep.iter();
            array.retain(|_| flags.next().copied().unwrap_or(true));
        }
        self.gathered = OnceLock::new();
        if let Some(Known { owner, work, way }) = &mut self.known {
            kept(owner, keep);
            kept(work, keep);
            kept(way, keep);
        }
    }

    /// The pressures of all bodies, of which each process has those of its own.
    pub(in crate::backend::cpu) fn all_pressures(&self, mut pressures: Vec<f64>) -> Vec<f64> {
        if let Some(known) = self.known.as_ref().filter(|_| !pressures.is_empty()) {
            let own = pressures.clone();
            spread(self.processes, &known.owner, |body| [own[body]], |body, [pressure]| pressures[body] = pressure);
        }
        pressures
    }

    /// What a step leaves, by the numbers of all bodies.
    pub(in crate::backend::cpu) fn by_number(&self, warm: Vec<Warm>) -> Vec<Warm> {
        let Some(step) = &self.step else { return warm };
        let number = |body: u32| surface_of(body).map_or_else(|| step.halo.members[body as usize], |_| body);
        warm.into_iter().map(|warm| Warm { pair: warm.pair.map(number), ..warm }).collect()
    }
}
