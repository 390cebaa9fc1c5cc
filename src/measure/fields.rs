//! Concentrations of the scene's fields: their mean, least and largest value, and the amount in the grid.

use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};
use crate::fields::Concentration;

const COLUMNS: [Column; 4] = [
    Column { name: "field_mean", what: "mean concentration of the first field, by name" },
    Column { name: "field_least", what: "least concentration in a grid cell of it" },
    Column { name: "field_most", what: "largest concentration in a grid cell of it" },
    Column { name: "field_amount", what: "amount in its grid: concentration times volume, in the plane times area" },
];

const PROFILE: [Column; 5] = [
    Column { name: "field", what: "the field's place among those of the scene in the order of their names, from 0" },
    Column { name: "mean", what: "mean concentration" },
    Column { name: "least", what: "least concentration in a grid cell" },
    Column { name: "most", what: "largest concentration in a grid cell" },
    Column { name: "amount", what: "amount in the grid: concentration times volume, in the plane times area" },
];

/// Concentrations of fields.
pub(super) struct OfFields;

impl Measure for OfFields {
    fn about(&self) -> &'static About {
        &About {
            name: "fields",
            line: "mean, least and largest concentration of each field, and the amount in its grid",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Kinds }),
            plots: &[&["field_mean", "field_least", "field_most"], &["field_amount"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let fields = &view.state.fields;
        let Some(first) = fields.first() else { return Err("the scene has no fields".into()) };
        let row = |(i, of): (usize, &Concentration)| [vec![count(i)], summed(of, view.planar())].concat();
        let names: Vec<&str> = fields.iter().map(|of| of.name.as_str()).collect();
        let remark = (names.len() > 1).then(|| format!("fields, in order: {}", names.join(", ")));
        Ok(Found { values: summed(first, view.planar()), rows: fields.iter().enumerate().map(row).collect(), remark })
    }
}

/// The mean, least and largest concentration, and the amount.
fn summed(of: &Concentration, planar: bool) -> Vec<Cell> {
    let values = || of.values.iter().copied();
    let mean = values().sum::<f64>() / of.values.len() as f64;
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    vec![cell(mean), cell(least), cell(most), cell(of.amount(planar))]
}
