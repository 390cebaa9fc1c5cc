//! What processes must agree on in a step: faults, and how bodies overlap.

use super::Domain;
use crate::step::Overlap;
use crate::walls::{Walls, surface_of};

/// A fault of a body, before it has a message: which of the faults that are looked for together, the body, and a
/// number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::backend::cpu) struct Trouble {
    pub kind: u8,
    pub body: usize,
    pub number: f64,
}

impl Domain {
    /// The first trouble of all processes: of the first kind, of the first body.
    pub(in crate::backend::cpu) fn first(&self, own: Option<Trouble>) -> Option<Trouble> {
        if !self.is_shared() {
            return own;
        }
        let own =
            own.map_or([u64::MAX; 3], |own| [own.kind.into(), self.number(own.body) as u64, own.number.to_bits()]);
        let mut all = vec![0_u64; 3 * self.processes.size()];
        self.processes.gather_even(&own, &mut all);
        let [kind, body, number] = *all.as_chunks::<3>().0.iter().min()?;
        (kind != u64::MAX).then(|| Trouble { kind: kind as u8, body: body as usize, number: f64::from_bits(number) })
    }

    /// The largest number of all processes.
    pub(in crate::backend::cpu) fn largest(&self, own: f64) -> f64 {
        if !self.is_shared() {
            return own;
        }
        let mut all = vec![0.0; self.processes.size()];
        self.processes.gather_even(&[own], &mut all);
        all.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The overlap of all, from those of the pairs of each process. `violations` are those of pairs whose first body is
    /// its own.
    pub(in crate::backend::cpu) fn all_overlaps(
        &self,
        own: &Overlap,
        worst: Option<([u32; 2], f64)>,
        walls: &Walls,
    ) -> Overlap {
        if !self.is_shared() {
            return *own;
        }
        let number = |body: u32| surface_of(body).map_or_else(|| self.number(body as usize) as u32, |_| body);
        let (numbers, separation) = worst.map_or(([u32::MAX; 2], 0.0), |(pair, found)| (pair.map(number), found));
        let words = [
            separation.to_bits(),
            u64::from(numbers[0]) << 32 | u64::from(numbers[1]),
            own.violations as u64,
            own.worst.to_bits(),
        ];
        let mut all = vec![0_u64; 4 * self.processes.size()];
        self.processes.gather_even(&words, &mut all);
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
        }
    }
}
