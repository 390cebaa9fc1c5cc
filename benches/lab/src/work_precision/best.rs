//! The cost of errors along each curve, and the cheapest curves.

use super::case::{Row, Sweep};
use super::reference::Reference;
use serde::Serialize;

/// Errors for which the page reports the cost.
pub const ERRORS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];

/// A cost. It is an upper bound if the coarsest run of the curve is already more accurate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// The cost.
    pub value: f64,
    /// Whether it is a bound.
    pub at_most: bool,
}

/// A curve and the cost of an error along it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cheapest {
    /// The curve.
    pub curve: String,
    /// The cost.
    pub cost: Cost,
    /// The largest overlap of smooth surfaces in any of its runs that are within the error, a length.
    pub max_overlap: f64,
}

/// The cheapest ways to an error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Best {
    /// The scene.
    pub problem: &'static str,
    /// The error.
    pub error: f64,
    /// Whether it is so large that the error of the reference is negligible.
    pub certain: bool,
    /// By seconds of wall time.
    pub by_wall: Option<Cheapest>,
    /// By products with `A`.
    pub by_products: Option<Cheapest>,
}

/// A curve of the plots: runs from coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve<'a> {
    /// Its name.
    pub name: String,
    /// Its runs.
    pub rows: Vec<&'a Row>,
}

/// The curves of rows of one problem, in the order in which they begin.
pub fn curves<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Vec<Curve<'a>> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in rows {
        let on = if row.computed_by.starts_with("CPU") { String::new() } else { format!(", {}", row.computed_by) };
        let name = format!("{}{on}", row.curve);
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.rows.push(row),
            None => curves.push(Curve { name, rows: vec![row] }),
        }
    }
    curves
}

impl Curve<'_> {
    /// Returns whether it converges to the exact solution under refinement. A curve of tolerances at one step does not.
    pub fn refines(&self) -> bool {
        self.rows.iter().all(|row| row.sweep != Sweep::Tolerance)
    }

    /// Returns the cost to come within `error` and to stay there under further refinement, by linear interpolation of
    /// logarithms. Returns `None` if the finest run is less accurate.
    ///
    /// A coarse run that is accurate by chance does not count, because this cannot be known beforehand.
    pub fn cost(&self, error: f64, work: impl Fn(&Row) -> f64) -> Option<Cost> {
        let runs = || self.rows.iter().map(|row| (work(row), row.error.unwrap_or(f64::INFINITY)));
        let Some(last_above) = runs().rposition(|(_, of_run)| of_run > error) else {
            return runs().next().map(|(value, _)| Cost { value, at_most: true });
        };
        let [above, within] = [runs().nth(last_above)?, runs().nth(last_above + 1)?];
        let between = (error / above.1).ln() / (within.1 / above.1).ln();
        // There is no such line from or to a run with zero error: the cost of the second run is a bound.
        if !between.is_finite() || above.0 <= 0.0 {
            return Some(Cost { value: within.0, at_most: true });
        }
        Some(Cost { value: above.0 * (within.0 / above.0).powf(between), at_most: false })
    }
}

/// The cheapest ways to each of [`ERRORS`], by rows of one problem with this reference.
pub fn best(problem: &'static str, reference: &Reference, rows: &[&Row]) -> Vec<Best> {
    let curves: Vec<Curve> = curves(rows.iter().copied()).into_iter().filter(Curve::refines).collect();
    let cheapest = |error: f64, work: fn(&Row) -> f64| {
        let costs = curves.iter().filter_map(|curve| {
            let within = curve.rows.iter().filter(|row| row.error.is_some_and(|of_run| of_run <= error));
            let max_overlap = within.map(|row| row.max_overlap).fold(0.0, f64::max);
            Some(Cheapest { curve: curve.name.clone(), cost: curve.cost(error, work)?, max_overlap })
        });
        costs.min_by(|a, b| a.cost.value.total_cmp(&b.cost.value))
    };
    let of = |error: f64| Best {
        problem,
        error,
        certain: reference.settles(error),
        by_wall: cheapest(error, |row| row.wall_seconds),
        by_products: cheapest(error, |row| row.products as f64),
    };
    ERRORS.map(of).into()
}
