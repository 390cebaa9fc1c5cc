//! Fields: concentrations on grids that diffuse, decay, and are taken up and secreted by bodies.
//!
//! A field changes between two steps of the bodies. Over the step that has just ended, with the bodies where they then
//! are: first each grid cell exchanges with the bodies in it, by an implicit Euler step that leaves no cell below zero
//! and takes from the grid what it gives to the bodies; then the field diffuses along each axis in turn, by implicit
//! Euler steps; then it decays. Held cells of the grid keep their concentration. So it is of first order in the step
//! and of second order in the spacing, and stable at any. A body is in the grid cells about points on its axis, with
//! parts that are linear in the distance.
//!
//! Cells may grow by what there is ([`Nutrient`]): in the next step, with the concentration where they then are.

mod diffusion;
mod exchange;
mod grid;
mod held;
mod settings;

pub use grid::Grid;
pub use settings::{Border, Borders, Exchange, Field, Held, Nutrient};

use crate::bodies::Bodies;
use crate::shape::Shape;
use diffusion::{Ends, diffuse};
use exchange::after_uptake;
use glam::{DQuat, DVec3};
use held::{HeldCells, held_cells, hold};
use std::collections::BTreeMap;

/// A field of a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Concentration {
    /// The name of the field in its scene.
    pub name: String,
    /// Its grid.
    pub grid: Grid,
    /// The concentration in each cell, x fastest, then y, then z.
    pub values: Vec<f64>,
}

/// The fields of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    list: Vec<(String, Field)>,
    /// Of each of them the cells that are held.
    held: Vec<HeldCells>,
    groups: Vec<String>,
    periodic: [bool; 3],
    planar: bool,
    /// Whether ellipsoids are in the cells along their z, not only in those about their centres: where they grow.
    along_ellipsoids: bool,
}

/// The part of an ellipsoid's z axis along which it counts as evenly spread, with its second moment there: in space,
/// where that is a fifth of its squared semi-axis, and in the plane, where it is a fourth.
const SPREAD: f64 = 0.774_596_669_241_483_4;
const SPREAD_IN_PLANE: f64 = 0.866_025_403_784_438_6;

impl Concentration {
    /// The amount in all cells: in a planar scene concentration times area, else times volume.
    pub fn amount(&self, planar: bool) -> f64 {
        self.grid.size_of_cell(planar) * self.values.iter().sum::<f64>()
    }
}

impl Grid {
    /// The volume of a cell, in a planar scene its area.
    fn size_of_cell(&self, planar: bool) -> f64 {
        self.spacing.powi(if planar { 2 } else { 3 })
    }
}

impl Field {
    /// Its grid.
    pub fn grid(&self) -> Grid {
        Grid { cells: self.cells, spacing: self.spacing, center: self.center }
    }

    /// Its concentration at the start.
    fn start(&self, name: &str, held: &[Option<f64>]) -> Concentration {
        let grid = self.grid();
        let given = (self.values.len() == grid.len()).then(|| self.values.clone());
        let mut values = given.unwrap_or_else(|| vec![self.initial; grid.len()]);
        hold(&mut values, held);
        Concentration { name: name.into(), grid, values }
    }
}

impl Fields {
    /// Those of a scene whose groups have these names.
    pub fn new(fields: &BTreeMap<String, Field>, groups: &[String], periodic: [bool; 3], planar: bool) -> Fields {
        let list: Vec<(String, Field)> = fields.iter().map(|(name, field)| (name.clone(), field.clone())).collect();
        let held = list.iter().map(|(_, field)| held_cells(&field.grid(), &field.held, planar)).collect();
        Fields { list, held, groups: groups.to_vec(), periodic, planar, along_ellipsoids: false }
    }

    /// With ellipsoids in the cells along their z.
    pub fn with_ellipsoids_along(self, along_ellipsoids: bool) -> Fields {
        Fields { along_ellipsoids, ..self }
    }

    /// The length of a body's axis along which it is in cells, and its pose.
    fn place(&self, bodies: &Bodies, i: usize) -> (f64, DVec3, DQuat) {
        let length = match bodies.shape[i] {
            Shape::Ellipsoid { radii: [.., z] } if self.along_ellipsoids => {
                2.0 * z * if self.planar { SPREAD_IN_PLANE } else { SPREAD }
            }
            shape => shape.rod_length().unwrap_or(0.0),
        };
        (length, bodies.position[i], bodies.orientation[i])
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The concentrations that a simulation begins with: those of the state, where it has the field with the same grid,
    /// else those of the scene.
    pub fn start(&self, state: &[Concentration]) -> Vec<Concentration> {
        let of = |((name, field), held): (&(String, Field), &HeldCells)| {
            let known = state.iter().find(|of| of.name == *name && of.grid == field.grid());
            known.cloned().unwrap_or_else(|| field.start(name, held))
        };
        self.list.iter().zip(&self.held).map(of).collect()
    }

    /// The concentration at a body, of the field `name` of a state; none without such a field.
    pub fn seen(&self, name: &str, state: &[Concentration], bodies: &Bodies, i: usize) -> Option<f64> {
        let Concentration { grid, values, .. } = state.iter().find(|of| of.name == name)?;
        let mut sum = 0.0;
        grid.shares(self.place(bodies, i), self.periodic, |(cell, part)| sum += part * values[cell]);
        Some(sum)
    }

    /// Takes the fields of a state over a step of `dt`, with the bodies at its end.
    pub fn advance(&self, state: &mut [Concentration], bodies: &Bodies, dt: f64) {
        for (((_, field), held), own) in self.list.iter().zip(&self.held).zip(state) {
            self.exchange(field, own, bodies, dt);
            hold(&mut own.values, held);
            let strength = field.diffusion * dt / (field.spacing * field.spacing);
            for (axis, borders) in field.boundary.each().into_iter().enumerate() {
                let ends = if self.periodic[axis] { Ends::Periodic } else { Ends::Borders(borders) };
                diffuse((&own.grid, held), &mut own.values, axis, strength, ends);
            }
            if field.decay > 0.0 {
                let left = 1.0 / (1.0 + field.decay * dt);
                own.values.iter_mut().for_each(|value| *value *= left);
                hold(&mut own.values, held);
            }
        }
    }

    /// What bodies take up and secrete in `dt`. Bodies are taken in order, so that sums have the same bits always.
    fn exchange(&self, field: &Field, own: &mut Concentration, bodies: &Bodies, dt: f64) {
        if field.exchange.is_empty() {
            return;
        }
        let (grid, cells) = (own.grid, own.grid.len());
        let per_cell = dt / grid.size_of_cell(self.planar);
        let mut most = vec![0.0; cells * field.exchange.len()];
        for (k, exchange) in field.exchange.iter().enumerate() {
            let group = exchange.group.as_ref().map(|name| self.groups.iter().position(|group| group == name));
            let of = &mut most[k * cells..(k + 1) * cells];
            for i in 0..bodies.len() {
                if group.is_some_and(|group| group != Some(bodies.group[i] as usize)) {
                    continue;
                }
                let shape = &bodies.shape[i];
                let size = if self.planar { shape.section(bodies.orientation[i]) } else { shape.volume() };
                let amount = exchange.uptake.or(exchange.secretion).unwrap_or(0.0) * size * per_cell;
                grid.shares(self.place(bodies, i), self.periodic, |(cell, part)| of[cell] += amount * part);
            }
        }
        let mut uptakes = Vec::with_capacity(field.exchange.len());
        for (cell, value) in own.values.iter_mut().enumerate() {
            uptakes.clear();
            for (k, exchange) in field.exchange.iter().enumerate() {
                let amount = most[k * cells + cell];
                match (exchange.uptake, exchange.half) {
                    (Some(_), Some(half)) if amount > 0.0 => uptakes.push((amount, half)),
                    (Some(_), _) => {}
                    (None, _) => *value += amount,
                }
            }
            if !uptakes.is_empty() {
                *value = after_uptake(*value, &uptakes);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::scene::{Body, Time};
    use crate::shape::Shape;

    /// Rods in a closed grid, of which one group takes up and the other secretes.
    fn rods(planar: bool) -> (Fields, Bodies, Vec<Concentration>) {
        let mut scene = Scene::new("fed", Time::new(0.1, 1.0));
        scene.planar = planar;
        for (i, group) in ["a", "b", "a"].into_iter().enumerate() {
            let shape = Shape::Spherocylinder { diameter: 0.5, length: 2.0 };
            let mut rod = Body::new(shape, [0.0, 1.0 * i as f64 - 1.0, 0.0]);
            rod.axis = Some([1.0, 0.2, 0.0]);
            rod.group = Some(group.into());
            scene.bodies.push(rod);
        }
        let mut field = Field::new([8, 8, if planar { 1 } else { 4 }], 0.6, 0.7);
        field.initial = 0.4;
        field.exchange = vec![
            Exchange { group: Some("a".into()), uptake: Some(0.9), half: Some(0.2), secretion: None },
            Exchange { group: Some("b".into()), secretion: Some(0.1), ..Exchange::default() },
        ];
        scene.fields.insert("food".into(), field);
        let (fields, bodies) = (scene.fields(), scene.build().unwrap());
        let start = fields.start(&[]);
        (fields, bodies, start)
    }

    /// What is secreted comes in, and without uptake nothing is lost.
    #[test]
    fn the_amount_in_a_closed_grid_is_kept_to_rounding() {
        for planar in [true, false] {
            let (mut fields, bodies, mut state) = rods(planar);
            fields.list[0].1.exchange.remove(0);
            let before = state[0].amount(planar);
            for _ in 0..100 {
                fields.advance(&mut state, &bodies, 0.1);
            }
            let size = match planar {
                true => bodies.shape[1].section(bodies.orientation[1]),
                false => bodies.shape[1].volume(),
            };
            let expected = before + 100.0 * 0.1 * 0.1 * size;
            let found = state[0].amount(planar);
            assert!((found / expected - 1.0).abs() < 1e-12, "{planar}: {found} {expected}");
        }
    }

    #[test]
    fn uptake_leaves_no_cell_below_zero_at_any_step_and_takes_all_in_the_end() {
        for dt in [0.01, 1.0, 1e6] {
            let (mut fields, bodies, mut state) = rods(true);
            fields.list[0].1.exchange.remove(1);
            let mut before = state[0].amount(true);
            for _ in 0..50 {
                fields.advance(&mut state, &bodies, dt);
                let now = state[0].amount(true);
                assert!(state[0].values.iter().all(|value| *value >= 0.0) && now <= before, "{dt}");
                before = now;
            }
            assert!(dt < 1e3 || before < 1e-6, "{dt}: {before}");
        }
    }

    /// Over one grid cell the uptake is that of Monod's law, and its error is of first order in the step.
    #[test]
    fn uptake_follows_monods_law_to_first_order_in_the_step() {
        let left = |steps: u32| {
            let (mut fields, bodies, _) = rods(true);
            let field = &mut fields.list[0].1;
            (field.cells, field.spacing, field.diffusion) = ([1, 1, 1], 5.0, 0.0);
            field.exchange.remove(1);
            let mut state = fields.start(&[]);
            (0..steps).for_each(|_| fields.advance(&mut state, &bodies, 2.0 / f64::from(steps)));
            state[0].values[0]
        };
        // `h ln(c / c0) + c - c0 = -u t`, by bisection; two rods take up.
        let (start, half, time) = (0.4, 0.2, 2.0);
        let (_, bodies, _) = rods(true);
        let rate = 0.9 * 2.0 * bodies.shape[0].section(bodies.orientation[0]) / 25.0;
        let (mut low, mut high) = (1e-12, start);
        for _ in 0..200 {
            let c: f64 = 0.5 * (low + high);
            if half * (c / start).ln() + c - start + rate * time > 0.0 { high = c } else { low = c }
        }
        let [coarse, fine] = [20, 40].map(|steps| (left(steps) - low).abs());
        println!("{low}: {coarse:.2e} {fine:.2e}");
        assert!(coarse < 1e-2 * low && (coarse / fine - 2.0).abs() < 0.1, "{coarse} {fine}");
    }

    #[test]
    fn a_body_sees_a_linear_field_at_its_centre() {
        let (fields, bodies, mut state) = rods(true);
        let grid = state[0].grid;
        state[0].values = (0..grid.len()).map(|cell| 1.0 + 0.3 * grid.center_of(cell)[1]).collect();
        for i in 0..3 {
            let seen = fields.seen("food", &state, &bodies, i).unwrap();
            assert!((seen - 1.0 - 0.3 * bodies.position[i].y).abs() < 1e-12, "{i}: {seen}");
        }
        assert_eq!(fields.seen("none", &state, &bodies, 0), None);
    }
}
