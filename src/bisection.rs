//! Blocks of near bodies, by recursive coordinate bisection (M. J. Berger, S. H. Bokhari, "A partitioning strategy for
//! nonuniform problems on multiprocessors", IEEE Transactions on Computers C-36, 570 (1987)): all bodies are cut in two
//! halves across the longest side of the box of their centres, each half likewise, until a block has few.
//!
//! The blocks depend on nothing but where the bodies are, so that whoever adds up numbers block by block, and the
//! blocks in the order of the cuts, comes to the same bits. Blocks that follow each other are near each other.

use crate::periodic::Periods;
use glam::DVec3;

/// Most bodies of a block. A colony has 2.7 rows a body, so that a block has some 340 rows, as many as a chunk of a sum
/// had before there were blocks: ten steps of 16,384 cells take the same iterations. Smaller blocks would share out
/// work more evenly, and cost more between two chunks. Other sizes were not measured.
pub(crate) const MOST_IN_A_BLOCK: usize = 128;

/// Halves of fewer bodies are cut by one thread. Ten times 16,384 bodies took some 10 ms on one thread, all levels.
const LEAST_BODIES_A_TASK: usize = 8_192;

/// Bodies in blocks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Blocks {
    /// All bodies, block by block.
    pub order: Vec<u32>,
    /// Where each block begins; one more at the end. There are as many as a power of two.
    pub edges: Vec<u32>,
}

impl Blocks {
    /// The place of each body in the order.
    pub fn places(&self) -> Vec<u32> {
        let mut place = vec![0; self.order.len()];
        (0..).zip(&self.order).for_each(|(at, body)| place[*body as usize] = at);
        place
    }

    /// How many blocks there are.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.edges.len() - 1
    }
}

/// Cuts bodies with these centres; in periodic space at their images in one cell.
pub(crate) fn bisect(centres: &[DVec3], periods: Periods) -> Blocks {
    let cuts = cuts(centres.len());
    let mut bodies: Vec<(DVec3, u32)> = centres.iter().map(|x| periods.wrapped(*x).0).zip(0..).collect();
    Blocks { order: order(&mut bodies, cuts), edges: edges(centres.len(), cuts) }
}

/// How often so many bodies are cut.
pub(crate) fn cuts(bodies: usize) -> u32 {
    let mut cuts = 0;
    while bodies > MOST_IN_A_BLOCK << cuts {
        cuts += 1;
    }
    cuts
}

/// Where the parts begin that so many cuts make of so many bodies; one more at the end.
pub(crate) fn edges(bodies: usize, cuts: u32) -> Vec<u32> {
    let mut edges = vec![0, bodies as u32];
    for _ in 0..cuts {
        let halves = edges.windows(2).flat_map(|ends| [ends[0], ends[0] + half((ends[1] - ends[0]) as usize) as u32]);
        edges = halves.chain([bodies as u32]).collect();
    }
    edges
}

/// How many of so many bodies are in the first half.
pub(crate) fn half(bodies: usize) -> usize {
    bodies / 2
}

/// The axis of the longest side of a box.
pub(crate) fn longest(low: DVec3, high: DVec3) -> usize {
    let sides = (high - low).to_array();
    (1..3).fold(0, |longest, axis| if sides[axis] > sides[longest] { axis } else { longest })
}

/// The numbers of bodies, block by block and ascending in each, after so many cuts.
pub(crate) fn order(bodies: &mut [(DVec3, u32)], cuts: u32) -> Vec<u32> {
    cut(bodies, cuts);
    let mut order: Vec<u32> = bodies.iter().map(|(_, body)| *body).collect();
    let edges = edges(order.len(), cuts);
    edges.windows(2).for_each(|ends| order[ends[0] as usize..ends[1] as usize].sort_unstable());
    order
}

fn cut(bodies: &mut [(DVec3, u32)], cuts: u32) {
    if cuts == 0 || bodies.len() < 2 {
        return;
    }
    let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = bodies.iter().fold(ends, |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    let longest = longest(low, high);
    let middle = half(bodies.len());
    bodies.select_nth_unstable_by(middle, |(x, a), (y, b)| x[longest].total_cmp(&y[longest]).then(a.cmp(b)));
    let (first, second) = bodies.split_at_mut(middle);
    if first.len() < LEAST_BODIES_A_TASK {
        cut(first, cuts - 1);
        cut(second, cuts - 1);
    } else {
        rayon::join(|| cut(first, cuts - 1), || cut(second, cuts - 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn scattered(bodies: usize) -> Vec<DVec3> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        (0..bodies).map(|_| DVec3::new(4.0 * random.random::<f64>(), random.random(), 0.0)).collect()
    }

    #[test]
    fn blocks_hold_each_body_once_and_are_of_one_size() {
        for bodies in [0, 1, 2, 128, 129, 1_000, 20_000] {
            let blocks = bisect(&scattered(bodies), Periods::NONE);
            assert!(blocks.len().is_power_of_two(), "{bodies}");
            let mut all = blocks.order.clone();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..bodies as u32), "{bodies}");
            let sizes: Vec<u32> = blocks.edges.windows(2).map(|ends| ends[1] - ends[0]).collect();
            let (least, most) = (sizes.iter().min().unwrap(), sizes.iter().max().unwrap());
            assert!(most - least <= 1 && *most as usize <= MOST_IN_A_BLOCK, "{bodies}: {least} to {most}");
            assert!(blocks.places().iter().zip(0..).all(|(place, body)| blocks.order[*place as usize] == body));
        }
    }

    #[test]
    fn a_block_is_small_and_does_not_know_images() {
        let centres = scattered(2_048);
        let blocks = bisect(&centres, Periods::NONE);
        for ends in blocks.edges.windows(2) {
            let of_block = blocks.order[ends[0] as usize..ends[1] as usize].iter().map(|body| centres[*body as usize]);
            let (low, high) = of_block.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            // Sixteen blocks of a space of 4 by 1: half by half.
            assert!((high - low).max_element() < 0.6, "{low} {high}");
        }
        let periods = Periods::new([Some(4.0), Some(1.0), None]);
        let moved: Vec<DVec3> = centres.iter().zip(0..).map(|(x, k)| *x + 4.0 * f64::from(k % 3) * DVec3::X).collect();
        let near = |blocks: &Blocks| blocks.order.clone();
        assert_eq!(near(&bisect(&moved, periods)), near(&bisect(&centres, periods)));
    }
}
