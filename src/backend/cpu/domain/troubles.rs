//! Reductions over processes: faults, overlaps and the effect of contact.

use super::Domain;
use crate::backend::cpu::team::Worst;
use crate::backend::cpu::trouble::Trouble;
use crate::step::{Effect, Overlap};
use crate::walls::{Walls, surface_of};

impl Domain {
    /// The first trouble of all processes: the smallest kind, then the first body.
    pub(super) fn first_of_all(&self, own: Option<Trouble>) -> Option<Trouble> {
        let own =
            own.map_or([u64::MAX; 3], |own| [own.kind.into(), self.number(own.body) as u64, own.number.to_bits()]);
        let mut all = vec![0_u64; 3 * self.processes.size()];
        self.processes.all_gather_even(&own, &mut all);
        let [kind, body, number] = *all.as_chunks::<3>().0.iter().min()?;
        (kind != u64::MAX).then(|| Trouble { kind: kind as u8, body: body as usize, number: f64::from_bits(number) })
    }

    /// The largest value of all processes.
    pub(super) fn largest_of_all(&self, own: f64) -> f64 {
        let mut all = vec![0.0; self.processes.size()];
        self.processes.all_gather_even(&[own], &mut all);
        all.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The effect of contact, summed over processes.
    pub(super) fn effects_of_all(&self, own: Effect) -> Effect {
        let number = |body: u32| surface_of(body).map_or_else(|| self.number(body as usize) as u32, |_| body);
        let moved = own.moved.map_or(u64::MAX, |body| self.number(body) as u64);
        let pair = own.push_pair.map_or(u64::MAX, |pair| {
            let [a, b] = pair.map(number);
            u64::from(a) << 32 | u64::from(b)
        });
        let words = [
            own.largest_move.to_bits(),
            moved,
            own.push_gap.to_bits(),
            pair,
            own.apart as u64,
            own.thrown as u64,
            own.torn as u64,
            own.energy.to_bits(),
            own.energy_allowed.to_bits(),
            own.axial_spin.to_bits(),
        ];
        let mut all = vec![0_u64; words.len() * self.processes.size()];
        self.processes.all_gather_even(&words, &mut all);
        let mut joint = Effect::default();
        for words in all.as_chunks::<10>().0 {
            let of = f64::from_bits;
            if of(words[0]) > joint.largest_move {
                (joint.largest_move, joint.moved) = (of(words[0]), Some(words[1] as usize));
            }
            if of(words[2]) > joint.push_gap {
                (joint.push_gap, joint.push_pair) = (of(words[2]), Some([(words[3] >> 32) as u32, words[3] as u32]));
            }
            joint.apart += words[4] as usize;
            joint.thrown += words[5] as usize;
            joint.torn += words[6] as usize;
            joint.energy += of(words[7]);
            joint.energy_allowed += of(words[8]);
            joint.axial_spin = joint.axial_spin.max(of(words[9]));
        }
        joint
    }

    /// The overlap of all processes' pairs. `violations` counts pairs whose first body is the process's own.
    pub(super) fn overlaps_of_all(&self, own: Overlap, worst: Option<Worst>, walls: &Walls) -> Overlap {
        let number = |body: u32| surface_of(body).map_or_else(|| self.number(body as usize) as u32, |_| body);
        let (numbers, separation) = worst.map_or(([u32::MAX; 2], 0.0), |(pair, found)| (pair.map(number), found));
        let words = [
            separation.to_bits(),
            u64::from(numbers[0]) << 32 | u64::from(numbers[1]),
            own.violations as u64,
            own.worst.to_bits(),
        ];
        let mut all = vec![0_u64; 4 * self.processes.size()];
        self.processes.all_gather_even(&words, &mut all);
        let all = all.as_chunks::<4>().0;
        let none = u64::MAX;
        let deepest = all.iter().filter(|words| words[1] != none);
        let deepest =
            deepest.min_by(|a, b| f64::from_bits(a[0]).total_cmp(&f64::from_bits(b[0])).then(a[1].cmp(&b[1])));
        let pair = deepest.map(|words| [(words[1] >> 32) as u32, words[1] as u32]);
        let wall = pair.and_then(|[body, surface]| Some([body as usize, walls.wall_of(surface_of(surface)?)]));
        Overlap {
            worst: deepest.map_or(0.0, |words| f64::from_bits(words[3])),
            pair: pair.filter(|_| wall.is_none()).map(|pair| pair.map(|body| body as usize)),
            wall,
            violations: all.iter().map(|words| words[2] as usize).sum(),
            proxy: own.proxy,
            stretch: own.stretch,
            bond: own.bond,
        }
    }
}
