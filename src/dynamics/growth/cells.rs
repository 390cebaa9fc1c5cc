//! The growth of cells: the species of a scene, and each cell's own values.

use super::{DivisionRule, GrowingShape, Growth, LEAST_CELLS_A_TASK, OnNoRoom, Turn};
use crate::bodies::{Bodies, Lineage, OwnGrowth};
use crate::dynamics::pressures;
use crate::fields::{Concentration, Fields, Nutrient};
use crate::shape::Shape;
use crate::warm::Warm;
use rand::RngExt;
use rayon::prelude::*;

/// Where in a cell's random stream its own targets and rate are, in words of 32 bits: its turns when it divides take
/// the first eight at most.
const OWN_WORDS: u128 = 64;

/// The relative tolerance of an age: times are sums of steps, and rounding must not cost another step.
const AGE_ROUNDING: f64 = 1e-9;

/// How the cells of a scene grow. What is random of a cell is drawn from a stream of the seed that belongs to its id
/// (ChaCha, which counts: any part of any stream is there without those before it), so that it depends on nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    species: Vec<Growth>,
    /// The species of each group by its number, and that of all other bodies.
    of_group: Vec<Option<usize>>,
    of_others: Option<usize>,
    /// Whether the scene is planar.
    pub planar: bool,
    /// The scene's seed.
    pub seed: u64,
    fields: Fields,
}

/// When a cell divides: at a step's start where it has the length and the time has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Due {
    /// The length.
    pub length: f64,
    /// The time.
    pub time: f64,
}

impl Due {
    /// Whether a cell of this length divides at this time.
    pub fn reached(&self, length: f64, time: f64) -> bool {
        length >= self.length && time >= self.time
    }
}

/// The growth of one species.
#[derive(Clone, Copy, Debug)]
pub struct Species<'a> {
    /// Its settings.
    pub growth: &'a Growth,
    seed: u64,
}

impl Cells {
    /// Those of a scene with these species, whose groups have these names.
    pub fn new(species: &[Growth], groups: &[String], planar: bool, seed: u64) -> Cells {
        let named = |name: &String| species.iter().position(|growth| growth.group.as_ref() == Some(name));
        let of_others = species.iter().position(|growth| growth.group.is_none());
        Cells {
            of_group: groups.iter().map(|name| named(name).or(of_others)).collect(),
            of_others,
            species: species.to_vec(),
            planar,
            seed,
            fields: Fields::default(),
        }
    }

    /// With the fields of the scene, from which they may grow.
    pub fn with_fields(self, fields: Fields) -> Cells {
        Cells { fields, ..self }
    }

    /// The growth of the bodies of a group; none if they do not grow.
    pub fn of(&self, group: u32) -> Option<Species<'_>> {
        let at = self.of_group.get(group as usize).copied().unwrap_or(self.of_others)?;
        Some(Species { growth: &self.species[at], seed: self.seed })
    }

    /// The growth and the length of a body of this group and shape, if it grows.
    pub fn of_body(&self, group: u32, shape: &Shape) -> Option<(Species<'_>, f64)> {
        let species = self.of(group)?;
        Some((species, species.growth.length_of(shape)?))
    }

    /// Whether ellipsoids grow.
    pub fn grow_ellipsoids(&self) -> bool {
        self.species.iter().any(|growth| growth.shape == GrowingShape::Ellipsoid)
    }

    /// All species.
    pub fn species(&self) -> &[Growth] {
        &self.species
    }

    /// What growth does where a container is full: of a valid scene the same for all species.
    pub fn on_no_room(&self) -> OnNoRoom {
        self.species.first().map_or(OnNoRoom::default(), |growth| growth.on_no_room)
    }

    /// Whether the growth of all species stops under a pressure without bound.
    pub fn all_stop_under_pressure(&self) -> bool {
        self.species.iter().all(|growth| growth.stress_sensitivity > 0.0)
    }

    /// Whether divisions make bonds.
    pub fn bond_daughters(&self) -> bool {
        self.species.iter().any(|growth| growth.bond_daughters.is_some())
    }

    /// Whether pressure slows the growth of any cell.
    pub fn feels_pressure(&self) -> bool {
        self.species.iter().any(|growth| growth.stress_sensitivity != 0.0)
    }

    /// Whether pressure or want slows the growth of any cell.
    pub fn may_be_slowed(&self) -> bool {
        self.feels_pressure() || self.species.iter().any(|growth| growth.nutrient.is_some())
    }

    /// What slows the growth of each body in the step after the one that left `bodies`, `warm` and these
    /// concentrations: its rate is multiplied by `e^-slowing`. Empty where nothing slows the growth of the scene's
    /// cells.
    pub fn slowing(&self, bodies: &Bodies, warm: &[Warm], fields: &[Concentration]) -> Vec<f64> {
        if !self.may_be_slowed() {
            return Vec::new();
        }
        let pressures = if self.feels_pressure() { pressures(bodies, warm, self.planar) } else { Vec::new() };
        let of = |i: usize| {
            let Some(species) = self.of(bodies.group[i]) else { return 0.0 };
            let pressed = pressures.get(i).map_or(0.0, |pressure| species.slowing_by(*pressure));
            let want = |nutrient: &Nutrient| {
                let seen = self.fields.seen(&nutrient.field, fields, bodies, i)?;
                Some(((nutrient.half + seen) / seen).ln())
            };
            pressed + species.growth.nutrient.as_ref().and_then(want).unwrap_or(0.0)
        };
        (0..bodies.len()).into_par_iter().with_min_len(LEAST_CELLS_A_TASK).map(of).collect()
    }

    /// Gives cells that divide by what they have added, and do not know their length at birth, the length that they
    /// have: those that a run starts with.
    pub fn settle(&self, bodies: &mut Bodies) {
        for i in 0..bodies.len() {
            let own = self.of_body(bodies.group[i], &bodies.shape[i]);
            let adds = own.filter(|(species, _)| species.growth.rule == DivisionRule::Adder);
            let line = &mut bodies.lineage[i];
            if let (Some((_, length)), None) = (adds, line.birth_length) {
                line.birth_length = Some(length);
            }
        }
    }
}

impl Species<'_> {
    /// What the cell `id` divides at: a length, an added length or a time since its birth.
    pub fn target(&self, id: u64) -> f64 {
        match self.growth.target() {
            (_, mean, 0.0) => mean,
            (_, mean, noise) => mean * (1.0 + noise * self.own(id)[0]),
        }
    }

    /// When a cell divides whose growth is its own to this part.
    pub fn due(&self, line: &Lineage, shape: &Shape, own: OwnGrowth) -> Due {
        let now = f64::NEG_INFINITY;
        if let Some(length) = own.division_length {
            return Due { length: length.max(2.0 * shape.shortest_length()), time: now };
        }
        let target = self.target(line.id);
        match self.growth.rule {
            DivisionRule::Sizer => Due { length: target, time: now },
            // `Cells::settle` has seen to the length at birth.
            DivisionRule::Adder => Due { length: line.birth_length.unwrap_or(f64::INFINITY) + target, time: now },
            DivisionRule::Timer => {
                Due { length: 2.0 * shape.shortest_length(), time: line.birth + target * (1.0 - AGE_ROUNDING) }
            }
        }
    }

    /// The relative growth per time of the cell `id`, slowed by the factor `e^-slowing`.
    pub fn rate(&self, id: u64, slowing: f64) -> f64 {
        self.rate_of(id, OwnGrowth::default(), slowing)
    }

    /// That of a cell whose growth is its own to this part.
    pub fn rate_of(&self, id: u64, own: OwnGrowth, slowing: f64) -> f64 {
        own.rate.unwrap_or_else(|| self.free_rate(id)) * (-slowing).exp()
    }

    /// What a pressure slows growth by. Contacts only push; where the axes of two rods nearly cross, a virial may be
    /// negative, without bound.
    pub fn slowing_by(&self, pressure: f64) -> f64 {
        match self.growth.stress_sensitivity > 0.0 {
            true => self.growth.stress_sensitivity * pressure.max(0.0),
            false => 0.0,
        }
    }

    /// Its rate without pressure, with its own draw.
    pub fn free_rate(&self, id: u64) -> f64 {
        match self.growth.rate_noise > 0.0 {
            true => self.growth.rate * (1.0 + self.growth.rate_noise * self.own(id)[1]),
            false => self.growth.rate,
        }
    }

    /// The length at birth of a daughter, if her rule needs it.
    pub fn birth_length(&self, length: f64) -> Option<f64> {
        (self.growth.rule == DivisionRule::Adder).then_some(length)
    }

    /// The cell's own draws, uniform from -1 to 1: one for what it divides at, one for its rate.
    fn own(&self, id: u64) -> [f64; 2] {
        let mut random = Turn::stream(self.seed, id);
        random.set_word_pos(OWN_WORDS);
        [(); 2].map(|()| 2.0 * random.random::<f64>() - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_under_a_negative_pressure_grows_no_faster_than_a_free_one() {
        let growth = Growth { stress_sensitivity: 0.05, ..Growth::new(1.3, 4.0) };
        let cells = Cells::new(&[growth], &[], true, 1);
        let species = cells.of(0).unwrap();
        let rate = |pressure: f64| species.rate(7, species.slowing_by(pressure));
        assert_eq!([0.0, -1e6, f64::NEG_INFINITY].map(rate), [1.3; 3]);
        assert!(rate(10.0) < 1.0);
    }

    #[test]
    fn a_body_grows_as_its_group_does_or_as_all_others() {
        let of = |group: &str, rate: f64| Growth { group: Some(group.into()), ..Growth::new(rate, 4.0) };
        let groups = ["a", "b", "c"].map(str::to_owned);
        let rate = |cells: &Cells, group: u32| cells.of(group).map(|species| species.growth.rate);
        let some = Cells::new(&[of("b", 1.0), of("a", 2.0)], &groups, true, 1);
        assert_eq!([0, 1, 2, u32::MAX].map(|group| rate(&some, group)), [Some(2.0), Some(1.0), None, None]);
        let all = Cells::new(&[of("b", 1.0), Growth::new(3.0, 4.0)], &groups, true, 1);
        assert_eq!([0, 1, 2, u32::MAX].map(|group| rate(&all, group)), [3.0, 1.0, 3.0, 3.0].map(Some));
    }
}
