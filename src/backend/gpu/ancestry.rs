//! The identities of the bodies and their growth, on the host. From them the host determines which bodies divide.

use super::Setup;
use crate::bodies::{Bodies, Columns, Lineage, OwnGrowth};
use crate::dynamics::Cells;
use crate::dynamics::bonds::daughters::{join, part};
use crate::dynamics::growth::{Due, Species, daughters};
use crate::shape::Shape;
use crate::step::State;

/// How a body grows, in scenes with growth.
#[derive(Clone, Copy)]
pub(super) struct Growing {
    /// Its growing length (NaN for a body that does not grow), and the condition on which it divides.
    pub length: f64,
    due: Due,
    /// The shape whose thickness or tips a dividing body has; its length is not used.
    shape: Shape,
    /// What of its growth is its own.
    own: OwnGrowth,
    /// Its rate of growth in the step, and the factor of its length over a part of a step. The factor is computed only
    /// when the rate changes: an exponential costs more than all other work of the host for a body.
    rate: f64,
    factor: f64,
}

/// The identities of the bodies. Divisions change them at a step's start, and growth when a step is accepted. Until
/// then divisions can be undone.
pub(super) struct Ancestry {
    pub lineage: Vec<Lineage>,
    pub group: Vec<u32>,
    /// The values that single bodies have of their own.
    columns: Columns,
    /// Empty in scenes without growth.
    pub growing: Vec<Growing>,
    pub next_id: u64,
    /// The length of a part of a step; bodies grow in each part.
    interval: f64,
    /// The number of bodies and the next id in the last accepted state, and the mothers of the present step as they
    /// were in that state.
    accepted: (usize, u64),
    mothers: Vec<(usize, Lineage, Growing)>,
    /// The values before divisions that made bonds of daughters.
    unbonded: Option<Columns>,
    /// The bodies that divide at the start of the next step, found while the lengths are computed.
    due: Vec<usize>,
    /// Bodies whose rates have changed since the last call of `changed_growths`; a body may be listed more than once.
    changed: Vec<usize>,
}

impl Growing {
    fn new(
        species: &Species<'_>,
        interval: f64,
        line: &Lineage,
        (length, shape, own): (f64, Shape, OwnGrowth),
        slowing: f64,
    ) -> Growing {
        let rate = species.rate_of(line.id, own, slowing);
        Growing { length, due: species.due(line, &shape, own), shape, own, rate, factor: (rate * interval).exp() }
    }

    /// The radii of curvature of the tips of an ellipsoid that grows; zero for other bodies.
    pub fn tips(&self) -> [f64; 2] {
        self.shape.tips().filter(|_| !self.length.is_nan()).unwrap_or_default()
    }

    /// The entry of a body that does not grow.
    fn none(shape: Shape) -> Growing {
        let due = Due { length: f64::INFINITY, time: f64::INFINITY };
        Growing { length: f64::NAN, due, shape, own: OwnGrowth::default(), rate: 0.0, factor: 1.0 }
    }
}

impl Ancestry {
    /// The identities of the bodies of a state. `prescribed` has the lengths of growing bodies.
    pub fn of(setup: &Setup, state: &State, prescribed: impl Iterator<Item = f64>) -> Ancestry {
        let (interval, bodies) = (setup.length_of(setup.first_part()), &state.bodies);
        let growing = |cells: &Cells| {
            let own = |(i, length): (usize, f64)| match cells.of_body(bodies.group[i], &bodies.shape[i]) {
                Some((species, _)) => {
                    let body = (length, bodies.shape[i], bodies.columns.growth(i));
                    Growing::new(&species, interval, &bodies.lineage[i], body, 0.0)
                }
                None => Growing::none(bodies.shape[i]),
            };
            prescribed.take(bodies.len()).enumerate().map(own).collect()
        };
        let growing: Vec<_> = setup.growth.as_ref().map(growing).unwrap_or_default();
        let mut ancestry = Ancestry {
            lineage: bodies.lineage.clone(),
            group: bodies.group.clone(),
            columns: bodies.columns.clone(),
            changed: (0..growing.len()).collect(),
            growing,
            next_id: state.next_id,
            interval,
            accepted: (bodies.len(), state.next_id),
            mothers: Vec::new(),
            unbonded: None,
            due: Vec::new(),
        };
        ancestry.lengthen(0, setup.time.after(state.step));
        ancestry
    }

    /// The bodies that divide at the start of the next step.
    pub fn due(&self) -> &[usize] {
        &self.due
    }

    /// Divides a body at `time`. Returns its index, the index of the upper daughter, and the length of both.
    pub fn divide(&mut self, species: &Species<'_>, mother: usize, time: f64, slowing: f64) -> (usize, usize, f64) {
        let (upper, line, own) = (self.lineage.len(), self.lineage[mother], self.growing[mother]);
        self.mothers.push((mother, line, own));
        let half = 0.5 * own.length;
        let lines = daughters(&line, time, &mut self.next_id, species.birth_length(half));
        let born = (half, own.shape, own.own);
        let [first, second] = lines.each_ref().map(|line| Growing::new(species, self.interval, line, born, slowing));
        self.lineage[mother] = lines[0];
        self.lineage.push(lines[1]);
        self.group.push(self.group[mother]);
        let bonded = species.growth.bond_daughters.is_some();
        if bonded && self.unbonded.is_none() {
            self.unbonded = Some(self.columns.clone());
        }
        self.columns.push_like(mother);
        if bonded {
            join(&mut self.columns, self.lineage.len(), line.id, [mother, upper]);
        }
        self.growing[mother] = first;
        self.growing.push(second);
        if first.rate != own.rate {
            self.changed.push(mother);
        }
        self.changed.push(upper);
        (mother, upper, half)
    }

    /// Sets the growth rates, each slowed by this.
    pub fn slow(&mut self, cells: &Cells, slowing: &[f64]) {
        for (body, (own, slowing)) in self.growing.iter_mut().zip(slowing).enumerate() {
            let Some(species) = cells.of(self.group[body]).filter(|_| !own.length.is_nan()) else { continue };
            let rate = species.rate_of(self.lineage[body].id, own.own, *slowing);
            if rate != own.rate {
                (own.rate, own.factor) = (rate, (rate * self.interval).exp());
                self.changed.push(body);
            }
        }
    }

    /// Undoes the divisions of a step that was not accepted.
    pub fn undo(&mut self) {
        let (bodies, next_id) = self.accepted;
        self.lineage.truncate(bodies);
        self.group.truncate(bodies);
        self.columns = self.accepted_columns();
        self.unbonded = None;
        self.growing.truncate(bodies);
        self.next_id = next_id;
        self.changed.retain(|body| *body < bodies);
        while let Some((mother, line, own)) = self.mothers.pop() {
            (self.lineage[mother], self.growing[mother]) = (line, own);
            self.changed.push(mother);
        }
    }

    /// Grows all bodies over an accepted step of `parts` that ends at `time`, part by part, with the same bits as on
    /// the CPU, because lengths determine divisions.
    pub fn accept(&mut self, parts: usize, time: f64) {
        self.mothers.clear();
        self.unbonded = None;
        self.accepted = (self.lineage.len(), self.next_id);
        self.lengthen(parts, time);
    }

    fn lengthen(&mut self, parts: usize, time: f64) {
        self.due.clear();
        for (body, own) in self.growing.iter_mut().enumerate() {
            for _ in 0..parts {
                own.length *= own.factor;
            }
            if own.due.reached(own.length, time) {
                self.due.push(body);
            }
        }
    }

    /// Sets the lengths of bodies to those stored here, which have the bits of the CPU. The device rounds its lengths.
    pub fn write_lengths(&self, bodies: &mut Bodies) {
        for (shape, own) in bodies.shape.iter_mut().zip(&self.growing) {
            *shape = shape.grown(own.length).unwrap_or(*shape);
        }
    }

    /// Sets the radii of ellipsoids that grow to those at the lengths of these shapes, which a device rounds.
    pub fn write_radii(&self, shapes: &mut [Shape]) {
        for (shape, own) in shapes.iter_mut().zip(&self.growing).filter(|(_, own)| !own.length.is_nan()) {
            if let Shape::Ellipsoid { radii: [.., half] } = *shape {
                *shape = own.shape.grown(2.0 * half).unwrap_or(*shape);
            }
        }
    }

    /// By how much each body grows in a part of the present step; empty in scenes without growth.
    pub fn lengthened(&self) -> Vec<f64> {
        let longer = |own: &Growing| own.length * (own.rate * self.interval).exp_m1();
        self.growing.iter().map(|own| if own.length.is_nan() { 0.0 } else { longer(own) }).collect()
    }

    /// The prescribed lengths of the last accepted state; zero for bodies that do not grow.
    pub fn accepted_lengths(&self) -> Vec<f64> {
        let mut growing = self.growing[..self.accepted.0.min(self.growing.len())].to_vec();
        for (mother, _, own) in &self.mothers {
            growing[*mother] = *own;
        }
        growing.iter().map(|own| if own.length.is_nan() { 0.0 } else { own.length }).collect()
    }

    /// What single bodies have of their own in the present step.
    pub fn columns(&self) -> Columns {
        self.columns.clone()
    }

    /// That of the last accepted state.
    pub fn accepted_columns(&self) -> Columns {
        let mut columns = self.unbonded.as_ref().unwrap_or(&self.columns).clone();
        columns.resize(self.accepted.0);
        columns
    }

    /// Breaks bonds of daughters, from the upper end of one body to the lower end of another.
    pub fn part(&mut self, broken: &[[usize; 2]]) {
        let bodies = self.lineage.len();
        broken.iter().for_each(|pair| part(&mut self.columns, bodies, *pair));
    }

    /// The lineages and groups of the last accepted state, and its next id.
    pub fn accepted(&self) -> (Vec<Lineage>, Vec<u32>, u64) {
        let (bodies, next_id) = self.accepted;
        let mut lineage = self.lineage[..bodies].to_vec();
        for (mother, line, _) in &self.mothers {
            lineage[*mother] = *line;
        }
        (lineage, self.group[..bodies].to_vec(), next_id)
    }

    /// Ranges of consecutive bodies whose rates have changed since the last call, each with the bodies' relative growth
    /// in a part of a step. With `all`, every body counts as changed.
    pub fn changed_growths(&mut self, all: bool) -> Vec<(usize, Vec<f64>)> {
        let mut changed = std::mem::take(&mut self.changed);
        if all {
            changed = (0..self.growing.len()).collect();
        }
        changed.sort_unstable();
        changed.dedup();
        let growth = |body: &usize| (self.growing[*body].rate * self.interval).exp_m1();
        let runs = changed.chunk_by(|a, b| a + 1 == *b);
        runs.map(|run| (run[0], run.iter().map(growth).collect())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn colony(noise: &str) -> (Cells, Ancestry) {
        let scene = Scene::load("colony", [noise]).unwrap();
        let model = scene.model();
        let state = State::new(scene.clone().build().unwrap());
        let setup = Setup::new(&model, &state.bodies.shape, crate::gpu::Precision::F32).unwrap();
        let lengths: Vec<_> = state.bodies.shape.iter().filter_map(|shape| shape.growing_length()).collect();
        (model.cells.unwrap(), Ancestry::of(&setup, &state, lengths.into_iter()))
    }

    fn lengths(of: &Ancestry) -> Vec<u64> {
        of.growing.iter().map(|own| own.length.to_bits()).collect()
    }

    #[test]
    fn divisions_of_a_step_that_fails_leave_no_trace() {
        let (cells, mut of) = colony("growth.rate_noise=0.3");
        assert_eq!(of.changed_growths(false), [(0, of.changed_growths(true)[0].1.clone())]);
        assert!(of.changed_growths(false).is_empty(), "nothing has changed since");
        while of.due().is_empty() {
            of.accept(1, 0.0);
        }
        let before = (of.lineage.clone(), of.group.clone(), lengths(&of), of.next_id, of.changed_growths(true));
        let (mother, upper, half) = of.divide(&cells.of(of.group[0]).unwrap(), 0, 1.0, 0.0);
        assert_eq!((mother, upper, 2.0 * half), (0, 1, f64::from_bits(before.2[0])));
        let changed = of.changed_growths(false);
        assert!(changed.len() == 1 && changed[0].1.len() == 2 && changed[0].1[0] != changed[0].1[1], "{changed:?}");
        assert_eq!(of.accepted(), (before.0.clone(), before.1.clone(), before.3));
        of.undo();
        assert_eq!(
            (of.lineage.clone(), of.group.clone(), lengths(&of), of.next_id),
            (before.0, before.1, before.2, before.3)
        );
        assert_eq!(of.changed_growths(false), before.4, "the mother's rate is written again");
    }

    #[test]
    fn a_daughter_of_the_same_rate_is_the_only_one_written() {
        let (cells, mut of) = colony("growth.division_length_noise=0.1");
        of.changed_growths(false);
        of.divide(&cells.of(of.group[0]).unwrap(), 0, 1.0, 0.0);
        let changed = of.changed_growths(false);
        assert!(changed.len() == 1 && changed[0].0 == 1 && changed[0].1.len() == 1, "{changed:?}");
    }

    #[test]
    fn lengths_grow_by_the_bits_of_the_cpu() {
        let (cells, mut of) = colony("growth.rate_noise=0.3");
        let (mut expected, id) = (of.growing[0].length, of.lineage[0].id);
        for _ in 0..100 {
            of.accept(2, 0.0);
            for _ in 0..2 {
                expected *= (cells.of(of.group[0]).unwrap().rate(id, 0.0) * of.interval).exp();
            }
        }
        assert_eq!(lengths(&of), [expected.to_bits()]);
    }
}
