//! The rules of fields.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Border, Exchange, Field, Growth, Held, Scene};
use super::{number, positive};
use crate::digits::{exact, few};

/// Most cells of a field: 128 MiB a state.
const MOST_CELLS: u64 = 1 << 24;

/// Most characters of a name, which files have.
const MOST_NAME: usize = 40;

/// Most regions that a field is held in: each is compared with each cell of its grid.
const MOST_HELD: usize = 1_000;

/// A grid along a periodic axis is as long as the period up to this part of it.
const SAME_LENGTH: f64 = 1e-9;

impl Scene {
    pub(super) fn check_fields(&self, key: &Key) -> Result<(), SceneError> {
        for (name, field) in &self.fields {
            let key = key.field(name);
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if name.is_empty() || name.len() > MOST_NAME || !name.chars().all(plain) {
                let message = format!("must be a name of 1 to {MOST_NAME} letters, digits, `_` and `-`");
                return Err(SceneError::bad(key, message));
            }
            self.check_grid(&key, field)?;
            for (name, value) in [("diffusion", field.diffusion), ("decay", field.decay), ("initial", field.initial)] {
                not_negative(&key.field(name), value)?;
            }
            check_values(&key, field)?;
            self.check_borders(&key.field("boundary"), field)?;
            self.check_held(&key.field("held"), &field.held)?;
            for (i, exchange) in field.exchange.iter().enumerate() {
                let list = key.field("exchange");
                let key = list.index(i);
                check_exchange(&key, exchange)?;
                self.check_group(&key, exchange.group.as_deref())?;
            }
        }
        Ok(())
    }

    fn check_grid(&self, key: &Key, field: &Field) -> Result<(), SceneError> {
        positive(&key.field("spacing"), field.spacing)?;
        field.center.iter().try_for_each(|x| number(&key.field("center"), *x))?;
        let cells = key.field("cells");
        if let Some(axis) = field.cells.iter().position(|count| *count == 0) {
            return Err(SceneError::bad(cells.index(axis), "must be at least 1"));
        }
        let count = field.cells.iter().fold(1_u64, |all, count| all.saturating_mul(u64::from(*count)));
        if count > MOST_CELLS {
            let message = format!("{} cells; at most {MOST_CELLS}", few(count as f64));
            return Err(SceneError::new(FaultKind::TooLarge, cells, message));
        }
        if self.planar && field.cells[2] != 1 {
            return Err(SceneError::bad(cells.index(2), "must be 1 in a planar scene, whose fields are in its plane"));
        }
        let Some(cell) = self.periodic else { return Ok(()) };
        if cell.changes() {
            let message = "conflicts with `fields`, whose grids do not move: the cell must keep its lengths and angles";
            return Err(SceneError::bad(Key::ROOT.field("periodic"), message));
        }
        for (axis, length) in cell.lengths.into_iter().enumerate() {
            let own = f64::from(field.cells[axis]) * field.spacing;
            let Some(length) = length.filter(|length| (own / length - 1.0).abs() > SAME_LENGTH) else { continue };
            let message = format!(
                "gives a grid of length {}, but space is periodic along this axis, with the period {}",
                exact(own),
                exact(length)
            );
            return Err(SceneError::bad(cells.index(axis), message));
        }
        Ok(())
    }

    fn check_borders(&self, key: &Key, field: &Field) -> Result<(), SceneError> {
        let periodic = self.periodic.map_or([None; 3], |cell| cell.lengths);
        for ((name, borders), period) in ["x", "y", "z"].into_iter().zip(field.boundary.each()).zip(periodic) {
            for (i, border) in borders.into_iter().enumerate() {
                let Border::Value(value) = border else { continue };
                let pair = key.field(name);
                let key = pair.index(i);
                not_negative(&key.field("value"), value)?;
                if period.is_some() {
                    return Err(SceneError::bad(key, "has no meaning: space is periodic along this axis"));
                }
                if self.planar && name == "z" {
                    return Err(SceneError::bad(key, "has no meaning in a planar scene"));
                }
            }
        }
        Ok(())
    }

    /// Regions of a shape that neither moves nor touches bodies.
    fn check_held(&self, list: &Key, held: &[Held]) -> Result<(), SceneError> {
        if held.len() > MOST_HELD {
            let message = format!("{} regions; at most {MOST_HELD}", held.len());
            return Err(SceneError::new(FaultKind::TooLarge, list, message));
        }
        for (i, held) in held.iter().enumerate() {
            let key = list.index(i);
            self.check_region(&key.field("inside"), &held.inside)?;
            not_negative(&key.field("value"), held.value)?;
        }
        Ok(())
    }

    /// What cells grow by.
    pub(super) fn check_nutrient(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        let Some(nutrient) = &growth.nutrient else { return Ok(()) };
        positive(&key.field("half"), nutrient.half)?;
        if self.fields.contains_key(&nutrient.field) {
            return Ok(());
        }
        let known: Vec<String> = self.fields.keys().map(|name| format!("`{name}`")).collect();
        let message = match known.is_empty() {
            true => "names a field, but the scene has no `fields`".to_owned(),
            false => format!("`{}` is none of the scene's fields: {}", nutrient.field, known.join(", ")),
        };
        Err(SceneError::bad(key.field("field"), message))
    }
}

fn not_negative(key: &Key, value: f64) -> Result<(), SceneError> {
    number(key, value)?;
    if value < 0.0 {
        return Err(SceneError::bad(key, format!("must not be negative, not {}", exact(value))));
    }
    Ok(())
}

fn check_values(key: &Key, field: &Field) -> Result<(), SceneError> {
    let (key, count) = (key.field("values"), field.count());
    if !field.values.is_empty() && field.values.len() as u64 != count {
        let message = format!("has {} numbers, but the grid has {count} cells", field.values.len());
        return Err(SceneError::bad(key, message));
    }
    field.values.iter().enumerate().try_for_each(|(i, value)| not_negative(&key.index(i), *value))
}

fn check_exchange(key: &Key, exchange: &Exchange) -> Result<(), SceneError> {
    let given = [("uptake", exchange.uptake), ("half", exchange.half), ("secretion", exchange.secretion)];
    for (name, value) in given {
        value.map_or(Ok(()), |value| positive(&key.field(name), value))?;
    }
    match (exchange.uptake, exchange.half, exchange.secretion) {
        (Some(_), Some(_), None) | (None, None, Some(_)) => Ok(()),
        (Some(_), None, None) => Err(SceneError::bad(key.field("half"), "is missing; `uptake` needs it")),
        (None, Some(_), _) => Err(SceneError::bad(key.field("half"), "has no meaning without `uptake`")),
        (Some(_), _, Some(_)) => {
            let message = "conflicts with `uptake`: an entry has only one of them; make two entries";
            Err(SceneError::bad(key.field("secretion"), message))
        }
        (None, None, None) => Err(SceneError::bad(key, "must have `uptake` or `secretion`")),
    }
}
