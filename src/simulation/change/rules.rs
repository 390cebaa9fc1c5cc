//! Cells whose growth, division and state a user's rules decide, step by step.

use super::{Change, ChangeError, Limits, Share, Simulation, Values, Which, parts_first};
use crate::bodies::{Bodies, OwnGrowth};
use crate::dynamics::{DivisionRule, pressures};
use crate::scene::Scene;
use crate::step::{Divided, Fault, State, StepReport};
use crate::warm::Warm;
use std::collections::{BTreeMap, HashMap};

/// What rules see of all bodies before a step.
#[derive(Clone, Copy)]
pub struct CellState<'a> {
    /// The bodies.
    pub bodies: &'a Bodies,
    /// The time.
    pub time: f64,
    warm: &'a [Warm],
}

impl CellState<'_> {
    /// The pressure of each body by the contact forces of the last step, as for `growth.stress_sensitivity`: force over
    /// area, in a planar scene over length; zero for a body that does not grow.
    pub fn pressures(&self) -> Vec<f64> {
        pressures(self.bodies, self.warm, self.bodies.planar)
    }

    /// The contact forces behind the pressures.
    #[cfg(feature = "python")]
    pub(crate) fn warm(&self) -> &[Warm] {
        self.warm
    }
}

/// What rules may change, one entry for each body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellValues {
    /// Relative growth rates without pressure; zero for a body that does not grow. See [`Values::Rate`].
    pub rate: Vec<f64>,
    /// Tip-to-tip lengths at which cells divide; infinite for a timer and for a body that does not grow. See
    /// [`Values::DivisionLength`].
    pub division_length: Vec<f64>,
    /// Indices into the scene's group names, or [`NO_GROUP`](crate::bodies::NO_GROUP).
    pub group: Vec<u32>,
    /// Named columns of the user's own.
    pub columns: BTreeMap<String, Vec<f64>>,
}

/// One cell at a division. What is changed of a mother has no effect.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Its id. Changing it has no effect.
    pub id: u64,
    /// Its tip-to-tip length: a mother's before the step, a daughter's after it. Daughters may have other lengths than
    /// these, with the same sum: the place where their mother was cut then moves along them, and their outer tips stay.
    pub length: f64,
    /// As [`CellValues::rate`].
    pub rate: f64,
    /// As [`CellValues::division_length`].
    pub division_length: f64,
    /// As [`CellValues::group`].
    pub group: u32,
    /// As [`CellValues::columns`].
    pub columns: BTreeMap<String, f64>,
}

/// Rules by which cells grow, divide and change, in place of those of the scene's `growth`, or beside them.
///
/// They must depend on their arguments alone, and keep what they remember in columns: then a simulation that resumes a
/// saved state goes on to the same bits. An error ends the step with the state before it, as do values that are not
/// allowed.
///
/// ```
/// use relcp::scene::{Generate, Growth, Time};
/// use relcp::simulation::{Cell, CellState, CellValues, Rules};
/// use relcp::{Scene, Simulation};
///
/// /// Cells grow slower under pressure; the longer a cell was at its division, the later its daughters divide.
/// struct Crowded;
///
/// impl Rules for Crowded {
///     fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
///         for (rate, pressure) in cells.rate.iter_mut().zip(state.pressures()) {
///             *rate = 1.0 / (1.0 + pressure.max(0.0));
///         }
///         Ok(())
///     }
///
///     fn divide(&mut self, mother: &Cell, daughters: [&mut Cell; 2]) -> Result<(), String> {
///         for daughter in daughters {
///             daughter.division_length = 3.0 + 0.2 * mother.length;
///         }
///         Ok(())
///     }
/// }
///
/// let mut scene = Scene::new("colony", Time::new(0.02, 2.0));
/// scene.planar = true;
/// scene.growth = vec![Growth::new(1.0, 4.0)];
/// scene.generate = vec![Generate::founder(0.5, 2.0)];
/// let mut simulation = Simulation::new(scene)?;
/// simulation.set_rules(Box::new(Crowded));
/// while !simulation.done() {
///     simulation.step()?;
/// }
/// assert!(simulation.bodies() > 2);
/// # Ok::<(), relcp::Error>(())
/// ```
pub trait Rules: Send {
    /// Called before each step; new values act in that step.
    ///
    /// # Errors
    /// A message.
    fn update(&mut self, _state: &CellState<'_>, _cells: &mut CellValues) -> Result<(), String> {
        Ok(())
    }

    /// Called after a step for each cell that divided in it, in the order of the mothers, before bodies are removed.
    /// Daughters have inherited their mother's own values, and the halves of her length; the first is the one at her
    /// lower end, the start of body z. New values act from the next step on.
    ///
    /// # Errors
    /// A message.
    fn divide(&mut self, _mother: &Cell, _daughters: [&mut Cell; 2]) -> Result<(), String> {
        Ok(())
    }
}

impl Simulation {
    /// Has cells grow and divide by these rules from the next step on, in place of earlier ones. On a device the state
    /// is read back in each step for them, and written where they change it.
    pub fn set_rules(&mut self, rules: Box<dyn Rules>) {
        self.rules = Some(rules);
    }

    /// Ends the rules. Values that cells have of their own stay.
    pub fn take_rules(&mut self) -> Option<Box<dyn Rules>> {
        self.rules.take()
    }

    /// What rules may change, as it is now.
    ///
    /// # Errors
    /// As [`Simulation::state`].
    pub fn cell_values(&mut self) -> Result<CellValues, Fault> {
        let limits = self.limits.get_or_insert_with(|| Box::new(Limits::of(&self.scene)));
        Ok(CellValues::of(limits, &self.backend.state()?.bodies))
    }

    /// Takes a step by rules. After a fault the state is that before.
    pub(in super::super) fn step_by(&mut self, rules: &mut dyn Rules) -> Result<StepReport, Fault> {
        let before = self.backend.state()?.clone();
        let stepped = self.updated_step(rules, &before);
        if stepped.is_err() && self.backend.state().is_ok_and(|state| *state != before) {
            self.backend.restore(&before)?;
        }
        stepped
    }

    fn updated_step(&mut self, rules: &mut dyn Rules, before: &State) -> Result<StepReport, Fault> {
        let (step, time) = (before.step + 1, self.time());
        let failed = |no: ChangeError| in_rule(step, "update", no);
        let old = self.cell_values()?;
        let mut cells = old.clone();
        let state = CellState { bodies: &before.bodies, time, warm: &before.warm };
        rules.update(&state, &mut cells).map_err(|what| raised(step, "update", &what))?;
        let change = cells.changed_from(&old).map_err(failed)?;
        self.change_by_rule(&change).map_err(failed)?;
        let report = self.advance()?;
        let change = self.divisions(rules, before)?;
        self.change_by_rule(&change).map_err(|no| in_rule(step, "divide", no))?;
        self.finish(report)
    }

    /// Applies a change by rules.
    fn change_by_rule(&mut self, change: &Change) -> Result<(), ChangeError> {
        let applied = self.applied(change)?;
        if applied.lengthened && self.device().is_some() {
            self.rebuild(&applied.state)?;
        } else if applied.differs {
            self.backend.restore(&applied.state)?;
        }
        if applied.lengthened {
            self.plan.parts_first = parts_first(&self.scene, &self.scene.model(), &self.plan, &applied.state);
        }
        Ok(())
    }

    /// What the rules decide of the cells that divided in the last step.
    fn divisions(&mut self, rules: &mut dyn Rules, before: &State) -> Result<Change, Fault> {
        let step = before.step + 1;
        let divided = self.backend.divided(&before.bodies.lineage)?;
        if divided.is_empty() {
            return Ok(Change::new());
        }
        let limits = self.limits.get_or_insert_with(|| Box::new(Limits::of(&self.scene)));
        let bodies = &self.backend.state()?.bodies;
        let (mothers, daughters) = (CellValues::of(limits, &before.bodies), CellValues::of(limits, bodies));
        let (mut decided, mut shared) = (daughters.clone(), Vec::new());
        let born = before.bodies.len()..bodies.len();
        let upper: HashMap<u64, usize> = born.filter_map(|i| Some((bodies.lineage[i].parent?, i))).collect();
        for Divided { number, line, .. } in divided {
            let lower = number as usize;
            // Where a daughter divided in the same step, no pair is left to decide on.
            let is_hers = bodies.lineage[lower].parent == Some(line.id);
            let Some(upper) = upper.get(&line.id).copied().filter(|_| is_hers) else { continue };
            let mother = mothers.cell(&before.bodies, lower);
            let mut pair = [lower, upper].map(|i| daughters.cell(bodies, i));
            let [first, second] = &mut pair;
            let decision = rules.divide(&mother, [first, second]);
            decision.map_err(|what| raised(step, &format!("divide of cell {}", line.id), &what))?;
            let lengths = [pair[0].length, pair[1].length];
            if lengths != [lower, upper].map(|i| bodies.shape[i].major_axis()) {
                shared.push(Share { daughters: [lower, upper], lengths });
            }
            for (i, cell) in [lower, upper].into_iter().zip(pair) {
                decided.put(i, cell);
            }
        }
        let change = decided.changed_from(&daughters).map_err(|no| in_rule(step, "divide", no))?;
        Ok(shared.into_iter().fold(change, Change::share))
    }
}

/// The fault of a rule that failed.
fn raised(step: u64, rule: &str, what: &str) -> Fault {
    Fault::Rules { step, what: format!("rules, {rule}: {what}") }
}

/// The fault of values that a rule may not set.
fn in_rule(step: u64, rule: &str, no: ChangeError) -> Fault {
    match no {
        ChangeError::Fault(fault) => fault,
        no => raised(step, rule, &no.by_body().to_string()),
    }
}

impl CellValues {
    /// Those of bodies of a scene, such as those of a recorded state.
    pub fn in_scene(scene: &Scene, bodies: &Bodies) -> CellValues {
        CellValues::of(&Limits::of(scene), bodies)
    }

    fn of(limits: &Limits, bodies: &Bodies) -> CellValues {
        let (mut rate, mut division_length) = (Vec::with_capacity(bodies.len()), Vec::with_capacity(bodies.len()));
        for i in 0..bodies.len() {
            let Some(species) = limits.species(bodies, i) else {
                rate.push(0.0);
                division_length.push(f64::INFINITY);
                continue;
            };
            let (own, line) = (bodies.columns.growth(i), &bodies.lineage[i]);
            rate.push(own.rate.unwrap_or_else(|| species.free_rate(line.id)));
            let by_rule = || match species.growth.rule {
                DivisionRule::Timer => f64::INFINITY,
                _ => species.due(line, &bodies.shape[i], OwnGrowth::default()).length,
            };
            division_length.push(own.division_length.unwrap_or_else(by_rule));
        }
        let columns = bodies.columns.named().map(|(name, values)| (name.to_owned(), values.to_vec())).collect();
        CellValues { rate, division_length, group: bodies.group.clone(), columns }
    }

    fn cell(&self, bodies: &Bodies, i: usize) -> Cell {
        Cell {
            id: bodies.lineage[i].id,
            length: bodies.shape[i].major_axis(),
            rate: self.rate[i],
            division_length: self.division_length[i],
            group: self.group[i],
            columns: self.columns.iter().map(|(name, values)| (name.clone(), values[i])).collect(),
        }
    }

    fn put(&mut self, i: usize, cell: Cell) {
        (self.rate[i], self.division_length[i], self.group[i]) = (cell.rate, cell.division_length, cell.group);
        let bodies = self.rate.len();
        for (name, value) in cell.columns {
            self.columns.entry(name).or_insert_with(|| vec![0.0; bodies])[i] = value;
        }
    }

    /// The change from old values to these. Groups come first, as they say who grows.
    fn changed_from(&self, old: &CellValues) -> Result<Change, ChangeError> {
        let mut change = Change::new();
        if let Some((which, group)) = rows("group", &self.group, &old.group)? {
            change = change.set(which, Values::Group(group));
        }
        if let Some((which, rate)) = rows("rate", &self.rate, &old.rate)? {
            change = change.set(which, Values::Rate(rate));
        }
        if let Some((which, length)) = rows("division_length", &self.division_length, &old.division_length)? {
            change = change.set(which, Values::DivisionLength(length));
        }
        for (name, values) in &self.columns {
            if old.columns.get(name).is_none_or(|old| old != values) {
                change = change.set(Which::All, Values::Column(name.clone(), values.clone()));
            }
        }
        Ok(change)
    }
}

/// The rows that differ.
fn rows<T: Copy + PartialEq>(what: &str, new: &[T], old: &[T]) -> Result<Option<(Which, Vec<T>)>, ChangeError> {
    if new.len() != old.len() {
        return Err(ChangeError::Count { what: what.into(), found: new.len(), expected: old.len() });
    }
    let differs: Vec<usize> = (0..new.len()).filter(|i| new[*i] != old[*i]).collect();
    let values = differs.iter().map(|i| new[*i]).collect();
    Ok((!differs.is_empty()).then_some((Which::Indices(differs), values)))
}
