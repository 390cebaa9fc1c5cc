//! Removal of bodies at the end of a step: outside or inside a region, or by death at a rate.
//!
//! A body dies in a step of `dt` with the probability `1 - exp(-rate dt)`, so that of bodies that nothing else removes
//! the part `exp(-rate t)` is alive at `t` for every step size, on average. The draw belongs to the seed, the body's
//! id, the step's number and the rule's place in the list (Philox 4x32-10), and so to no order of bodies.
//!
//! Arrays close up without reordering: whoever stays keeps its id and its place among the others. What remains of those
//! that go is their line, an [`Ended`]; with those of the mothers that divided, the ancestry of all that ever lived can
//! be built again.

mod settings;

pub use settings::Removal;

use crate::bodies::{Bodies, Lineage};
use crate::dynamics::draw;
use crate::fixed::Fixed;
use crate::separation::Surface;
use glam::DVec3;

/// The first of the numbers of Philox' blocks that belong to removal: Brownian motion has those before it.
const FIRST_BLOCK: u32 = 2;

/// Most rules of a scene. A block of Philox is drawn for two, and has eight bits for its number beside the step's.
pub(crate) const MOST_RULES: usize = 64;

/// Why a body is no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Cause {
    /// It divided into two.
    Division,
    /// Its centre was outside of a shape.
    Outside,
    /// Its centre was inside of a shape.
    Inside,
    /// It died at a rate.
    Rate,
    /// A change between two steps removed it: one of the scene's `changes`, or its user's.
    Change,
}

impl Cause {
    /// Its name, as a scene and `lineage.csv` have it.
    pub fn name(self) -> &'static str {
        match self {
            Cause::Division => "division",
            Cause::Outside => "outside",
            Cause::Inside => "inside",
            Cause::Rate => "rate",
            Cause::Change => "change",
        }
    }
}

/// A life that ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    /// The step that ended it, from 1.
    pub step: u64,
    /// When: of a division and a change the step's start, else its end.
    pub time: f64,
    /// Whose it was.
    pub line: Lineage,
    /// The index of its group; `u32::MAX` if it had none.
    pub group: u32,
    /// Why.
    pub cause: Cause,
    /// The index in the scene's `removal` of the rule that removed it, if one did.
    pub rule: Option<usize>,
}

/// Where or how often a rule removes.
#[derive(Clone, Debug, PartialEq)]
enum Reach {
    Outside(Vec<Surface>),
    Inside(Vec<Surface>),
    Rate(f64),
}

#[derive(Clone, Debug, PartialEq)]
struct Rule {
    /// The number of the group that it holds for; all where there is none.
    group: Option<u32>,
    reach: Reach,
}

/// The rules of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Removals {
    rules: Vec<Rule>,
    seed: u64,
    fixed: Fixed,
}

impl Removals {
    /// Those of a scene whose groups have these names.
    pub fn new(rules: &[Removal], groups: &[String], planar: bool, seed: u64, fixed: Fixed) -> Removals {
        let number = |name: &String| groups.iter().position(|known| known == name).map_or(u32::MAX, |n| n as u32);
        let reach = |rule: &Removal| match (&rule.outside, &rule.inside) {
            (Some(shape), _) => Reach::Outside(shape.surfaces(planar)),
            (None, Some(shape)) => Reach::Inside(shape.surfaces(planar)),
            (None, None) => Reach::Rate(rule.rate.unwrap_or(0.0)),
        };
        let rule = |rule: &Removal| Rule { group: rule.group.as_ref().map(number), reach: reach(rule) };
        Removals { rules: rules.iter().map(rule).collect(), seed, fixed }
    }

    /// How many rules there are.
    pub fn len(&self) -> usize {
        self.rules.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rules.is_empty()
    }

    /// Whether a rule needs positions.
    pub fn asks_places(&self) -> bool {
        self.rules.iter().any(|rule| !matches!(rule.reach, Reach::Rate(_)))
    }

    /// The rule that removes each body at the end of the step of this number and length, the first that does; `places`
    /// are needed where a rule asks for them.
    pub fn choose(
        &self,
        (lineage, group): (&[Lineage], &[u32]),
        places: Option<&Bodies>,
        (step, dt): (u64, f64),
    ) -> Vec<Option<usize>> {
        let deaths: Vec<f64> = self.rules.iter().map(|rule| rule.probability(dt)).collect();
        let of_body = |i: usize| {
            if self.fixed.holds(lineage[i].id, group[i]) {
                return None;
            }
            let at = places.map(|bodies| bodies.periods.wrapped(bodies.position[i]).0);
            let removes = |(rule, of): (usize, &Rule)| {
                let held = of.group.is_none_or(|group_of| group_of == group[i]);
                held && match &of.reach {
                    Reach::Outside(shape) => at.is_some_and(|at| !contains(shape, at)),
                    Reach::Inside(shape) => at.is_some_and(|at| contains(shape, at)),
                    Reach::Rate(_) => self.draw(lineage[i].id, step, rule) < deaths[rule],
                }
            };
            self.rules.iter().enumerate().position(|(rule, of)| removes((rule, of)))
        };
        (0..lineage.len()).map(of_body).collect()
    }

    /// Why a rule removes.
    pub fn cause(&self, rule: usize) -> Cause {
        match self.rules[rule].reach {
            Reach::Outside(_) => Cause::Outside,
            Reach::Inside(_) => Cause::Inside,
            Reach::Rate(_) => Cause::Rate,
        }
    }

    /// A number from 0 to 1 that belongs to a body, a step and a rule.
    fn draw(&self, id: u64, step: u64, rule: usize) -> f64 {
        let ([id_low, id_high], [step_low, step_high]) = (draw::halves(id), draw::halves(step));
        let block = FIRST_BLOCK + rule as u32 / 2;
        let words = draw::philox(
            [id_low, id_high, step_low, step_high ^ (block << draw::BLOCK_SHIFT)],
            draw::halves(self.seed),
        );
        let first = 2 * (rule % 2);
        let word = (u64::from(words[first + 1]) << 32) | u64::from(words[first]);
        // 53 bits, half-way between two multiples: never 0 and never 1.
        ((word >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }
}

impl Rule {
    fn probability(&self, dt: f64) -> f64 {
        match self.reach {
            Reach::Rate(rate) => -(-rate * dt).exp_m1(),
            _ => 0.0,
        }
    }
}

/// Whether a point is inside of all surfaces of a shape, or on one.
fn contains(shape: &[Surface], at: DVec3) -> bool {
    shape.iter().all(|surface| surface.height(at) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 20,000 bodies under two rules, alone and together, over 40 steps.
    #[test]
    fn the_part_that_lives_is_that_of_the_closed_form() {
        let (n, dt, steps) = (20_000_usize, 0.05, 40_u64);
        for seed in 1..=3 {
            for (rates, total) in [(&[0.6][..], 0.6_f64), (&[0.3, 0.9], 1.2)] {
                let rules: Vec<Removal> = rates.iter().map(|rate| Removal::rate(*rate)).collect();
                let removals = Removals::new(&rules, &[], false, seed, Fixed::default());
                let line = |id: u64| Lineage { id, parent: None, birth: 0.0, generation: 0, birth_length: None };
                let mut alive: Vec<Lineage> = (0..n as u64).map(line).collect();
                for step in 1..=steps {
                    let groups = vec![0; alive.len()];
                    let mut chosen = removals.choose((&alive, &groups), None, (step, dt)).into_iter();
                    alive.retain(|_| chosen.next().flatten().is_none());
                }
                let part = (-total * dt * steps as f64).exp();
                let off = (alive.len() as f64 - n as f64 * part) / (n as f64 * part * (1.0 - part)).sqrt();
                println!("seed {seed}, {rates:?}: {off:.2} standard errors");
                assert!(off.abs() < 4.0, "seed {seed}, {rates:?}: {off}");
            }
        }
    }

    #[test]
    fn draws_are_uniform_and_those_of_rules_and_steps_are_independent() {
        let rules = [Removal::rate(1.0), Removal::rate(1.0), Removal::rate(1.0)];
        let removals = Removals::new(&rules, &[], false, 3, Fixed::default());
        let n = 40_000_u64;
        let (mut sums, mut products) = ([[0.0; 2]; 3], [0.0; 3]);
        for k in 0..n {
            let drawn = [0, 1, 2].map(|rule| removals.draw(k / 200, k % 200, rule) - 0.5);
            for (sum, x) in sums.iter_mut().zip(drawn) {
                sum[0] += x;
                sum[1] += x * x;
            }
            let next = removals.draw(k / 200, k % 200 + 1, 0) - 0.5;
            products[0] += drawn[0] * drawn[1];
            products[1] += drawn[1] * drawn[2];
            products[2] += drawn[0] * next;
        }
        let root = (n as f64).sqrt();
        for [first, second] in sums {
            assert!(first.abs() < 4.0 * root / 12.0_f64.sqrt(), "{first}");
            assert!((second / n as f64 - 1.0 / 12.0).abs() < 4.0 * (1.0 / 180.0_f64).sqrt() / root, "{second}");
        }
        assert!(products.iter().all(|product| product.abs() < 4.0 * root / 12.0), "{products:?}");
    }
}
