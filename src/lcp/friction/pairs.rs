//! The diagonal blocks of `A` that belong to one pair of bodies: steps within the cones, as a metric.
//!
//! A pair with one unit is solved exactly (`block`), one with several by a few sweeps of block Gauss-Seidel over its
//! units; where these are single rows, with numbers in place of triples (`scalars`). No sweep raises the objective, so
//! what comes out is a descent step all the same.

use super::block::Block;
use super::cone::{Triple, dot};
use super::linked::Linked;
use super::scalars::Scalars;
use super::unit::{Unit, plus};
use crate::lcp::pair_blocks::{entry, sorted};
use crate::lcp::product::Product;
use std::ops::Range;

/// Addition to the diagonal of a block, as a part of its largest entry, as in [`crate::lcp::pair_blocks`].
pub(in crate::lcp) const REGULARIZATION: f64 = 1e-6;

/// Most sweeps over the units of a pair.
pub(in crate::lcp) const SWEEPS: usize = 10;

/// A sweep that moves the units by less than this part of the first one is the last. In scenes of rods, ellipsoids and
/// superellipsoids, 1e-3 took as many iterations and a fifth to a third more time.
pub(in crate::lcp) const SETTLED: f64 = 0.3;

/// The units of a pair.
struct Pair {
    units: Range<usize>,
    /// Whether all of them are single rows.
    is_scalar: bool,
}

/// The blocks of all units, and pairs of several.
#[derive(Default)]
pub(super) struct Pairs {
    pairs: Vec<Pair>,
    /// One for each unit of the pairs that have cones.
    blocks: Vec<Block>,
    /// `A_uv` of all units of each such pair with several, row by row of units.
    couplings: Vec<[Triple; 3]>,
    /// The block of each of the other pairs, row by row.
    entries: Vec<f64>,
    rise: Vec<Triple>,
    rise_of_rows: Vec<f64>,
    /// The rows that are solved together, whose units are in no pair.
    linked: Linked,
}

impl Pairs {
    /// Makes the blocks of units whose pairs stand together.
    pub fn rebuild<const D: usize>(&mut self, product: &Product<D>, units: &[Unit], compliance: &[f64]) {
        let (pair_of, jacobian) = (product.pair(), product.jacobian());
        let of = |unit: &Unit| sorted(pair_of[unit.rows().start]);
        let coupling = |u: &Unit, v: &Unit| -> [Triple; 3] {
            let (rows, columns) = (u.rows(), v.rows());
            std::array::from_fn(|i| {
                std::array::from_fn(|j| match (rows.clone().nth(i), columns.clone().nth(j)) {
                    (Some(i), Some(j)) => entry(pair_of, jacobian, i, j),
                    _ => 0.0,
                })
            })
        };
        self.linked.rebuild(product, units, compliance);
        self.pairs.clear();
        for (at, unit) in units.iter().enumerate() {
            if unit.linked && self.linked.is_some() {
                continue;
            }
            match self.pairs.last_mut() {
                Some(Pair { units: last, is_scalar }) if last.end == at && of(&units[last.start]) == of(unit) => {
                    last.end = at + 1;
                    *is_scalar &= unit.is_scalar();
                }
                _ => self.pairs.push(Pair { units: at..at + 1, is_scalar: unit.is_scalar() }),
            }
        }
        self.blocks.clear();
        self.couplings.clear();
        self.entries.clear();
        for pair in &self.pairs {
            let units = &units[pair.units.clone()];
            if pair.is_scalar {
                let entry = |i: usize, j: usize| entry(pair_of, jacobian, i, j);
                Scalars::add_block(units, entry, compliance, &mut self.entries);
                continue;
            }
            self.blocks.extend(units.iter().map(|u| block(coupling(u, u), u, &compliance[u.rows()])));
            if units.len() > 1 {
                self.couplings
                    .extend(units.iter().flat_map(|u| units.iter().map(move |v| (u, v))).map(|(u, v)| coupling(u, v)));
            }
        }
    }

    /// Whether rows are solved together.
    pub fn has_linked(&self) -> bool {
        self.linked.is_some()
    }

    /// Solves these rows where the gaps of `x` are `g`, with the multipliers of all others.
    pub fn eliminate(&mut self, x: &mut [f64], g: &[f64]) {
        let from = x.to_vec();
        self.linked.descend(&from, g, x);
    }

    /// `out = argmin over y in K of g . (y - x) + 1/2 (y - x) . B (y - x)`, for `x` in it.
    pub fn descend(&mut self, units: &[Unit], x: &[f64], g: &[f64], out: &mut [f64]) {
        out.copy_from_slice(x);
        self.linked.descend(x, g, out);
        let mut taken = Taken::default();
        for pair in &self.pairs {
            let units = &units[pair.units.clone()];
            if pair.is_scalar {
                let scalars = Scalars::of(units, &self.entries, &mut taken.entries);
                scalars.descend(g, &mut self.rise_of_rows, out);
                continue;
            }
            self.rise.clear();
            self.rise.extend(units.iter().map(|unit| unit.get(g)));
            Blocks::of(units, &self.blocks, &self.couplings, &mut taken).settle(&mut self.rise, out);
        }
    }

    /// `out = argmin over y in K of (y - w) . B (y - w)`.
    pub fn project(&mut self, units: &[Unit], w: &[f64], out: &mut [f64]) {
        self.linked.project(w, out);
        let mut taken = Taken::default();
        for pair in &self.pairs {
            let units = &units[pair.units.clone()];
            if pair.is_scalar {
                let scalars = Scalars::of(units, &self.entries, &mut taken.entries);
                scalars.project(w, &mut self.rise_of_rows, out);
                continue;
            }
            let blocks = Blocks::of(units, &self.blocks, &self.couplings, &mut taken);
            let mut inside = true;
            for unit in blocks.units {
                let (w, near) = (unit.get(w), unit.project(unit.get(w)));
                inside &= near == w;
                unit.put(near, out);
            }
            // Nearly all are their own projection.
            if !inside {
                blocks.slopes(w, out, &mut self.rise);
                blocks.settle(&mut self.rise, out);
            }
        }
    }
}

/// How many blocks, couplings and entries the pairs so far have.
#[derive(Default)]
struct Taken {
    blocks: usize,
    couplings: usize,
    entries: usize,
}

/// The units of a pair with cones.
struct Blocks<'a> {
    units: &'a [Unit],
    blocks: &'a [Block],
    /// `A_uv`, where there are several.
    couplings: &'a [[Triple; 3]],
}

impl<'a> Blocks<'a> {
    /// Those of a pair; the blocks and couplings of pairs are taken in their order.
    fn of(units: &'a [Unit], blocks: &'a [Block], couplings: &'a [[Triple; 3]], taken: &mut Taken) -> Self {
        let count = units.len();
        let first = (taken.blocks, taken.couplings);
        taken.blocks += count;
        taken.couplings += if count > 1 { count * count } else { 0 };
        Blocks { units, blocks: &blocks[first.0..taken.blocks], couplings: &couplings[first.1..taken.couplings] }
    }

    /// `B (y - w)`.
    fn slopes(&self, w: &[f64], y: &[f64], out: &mut Vec<Triple>) {
        out.clear();
        out.resize(self.units.len(), [0.0; 3]);
        for (u, unit) in self.units.iter().enumerate() {
            self.moved(u, plus(unit.get(y), -1.0, unit.get(w)), out);
        }
    }

    /// Adds to the gradients what a move of a unit makes of them.
    fn moved(&self, u: usize, change: Triple, rise: &mut [Triple]) {
        for (v, rise) in rise.iter_mut().enumerate() {
            let part = match u == v {
                true => self.blocks[u].times(change),
                false => self.couplings[v * self.units.len() + u].map(|row| dot(row, change)),
            };
            *rise = plus(*rise, 1.0, part);
        }
    }

    /// Takes `y` in `K`, where the gradients are `rise`, to the solution, exactly for one unit.
    fn settle(&self, rise: &mut [Triple], y: &mut [f64]) {
        let sweeps = if self.units.len() == 1 { 1 } else { SWEEPS };
        let mut most = 0.0;
        for _ in 0..sweeps {
            let mut farthest = 0.0;
            for (u, (unit, block)) in self.units.iter().zip(self.blocks).enumerate().filter(|(_, (unit, _))| unit.live)
            {
                let from = unit.get(y);
                let to = if unit.free { block.descend(from, rise[u]) } else { block.minimize(from, rise[u]) };
                unit.put(to, y);
                if sweeps > 1 {
                    let change = plus(to, -1.0, from);
                    self.moved(u, change, rise);
                    farthest = f64::max(farthest, unit.scale * dot(change, change).sqrt());
                }
            }
            most = f64::max(most, farthest);
            if farthest <= SETTLED * most {
                return;
            }
        }
    }
}

/// The block of a unit.
fn block(mut matrix: [Triple; 3], unit: &Unit, compliance: &[f64]) -> Block {
    let largest = (0..3).map(|i| matrix[i][i]).fold(0.0, f64::max);
    for (i, row) in matrix.iter_mut().enumerate() {
        // Rows that are idle have an entry of their own.
        row[i] += compliance.get(i).copied().unwrap_or(1.0) + REGULARIZATION * largest;
    }
    // What is not live is not used, and its matrix may be zero.
    Block::new(if unit.live { matrix } else { [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }, unit.mu)
}
