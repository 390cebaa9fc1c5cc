//! Measures of recorded states, as reported in papers on colonies, packings and nematic order.
//!
//! Each [`Measure`] has its own file, and [`ALL`] is their table. A measure reads one state as a [`View`] and returns
//! values for the state's row of `measures.csv`. Some also return a profile: rows over distance, length or size. A
//! measure that is not defined for a state is omitted with the reason ([`LeftOut`]); an undefined value is an empty
//! cell, never 0 or NaN. Formulas with their sources: `docs/measures.md`.
//!
//! ```
//! use relcp::record::States;
//! use relcp::measure::{Settings, measure, select};
//! let states = States::open("three-capsules")?;
//! let measured = measure("three-capsules", &states, &select(&["radius".into()])?, &Settings::default(), &mut |_done,
//! _all| true)?; assert!(measured.value(0, "radius_outermost").is_some_and(|radius| radius > 0.0));
//! # Ok::<(), relcp::Error>(())
//! ```

mod axis;
mod bins;
mod bonds;
mod clusters;
mod collect;
mod contacts;
mod correlation;
mod density;
mod dissipation;
mod error;
mod fields;
mod force_chains;
mod frame;
mod friction;
pub(crate) mod groups;
mod hull;
mod interior;
mod length;
mod microdomains;
mod msd;
mod nematic;
mod output;
mod packing;
mod plot;
mod radius;
mod removal;
mod segregation;
mod shear_stress;
mod stress;
#[cfg(test)]
mod tests;
mod tracks;
mod velocity_correlation;
mod view;
mod walls;

pub use axis::axis;
pub use collect::{Measured, measure, measure_last};
pub use error::MeasureError;
pub use frame::Frame;
pub(crate) use frame::scene_behind;
pub(crate) use output::field;
pub use output::{Document, write};
pub use tracks::{Point, Track, Tracks};
pub use view::View;

/// The largest number of pairs for C(r) of one state. Up to 8,192 bodies have no more; for 131,072 bodies they take 0.7
/// s of a core at 2.5 GHz.
pub const CORRELATION_PAIRS: usize = 1 << 25;

/// The default angle: two touching bodies belong to one microdomain if their axes differ by less than this, in degrees.
/// The sizes depend on this choice, as `docs/measures.md` shows.
pub const DOMAIN_ANGLE: f64 = 3.0;

/// The settings of the measures.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Settings {
    /// Width of distance bins; without it the median thickness of the bodies.
    pub bin: Option<f64>,
    /// Radius of the neighbourhood of the local order; without it the median largest extent of the bodies.
    pub neighbourhood: Option<f64>,
    /// Largest angle between touching bodies of one microdomain, in degrees.
    pub domain_angle_degrees: f64,
    /// Pairs nearer than this touch; without it [`crate::record::TOUCHING`] of the least thickness.
    pub cutoff: Option<f64>,
    /// The seed of the selected bodies if C(r) is sampled.
    pub seed: u64,
    /// The largest number of pairs for C(r) of a state.
    pub correlation_pairs: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            bin: None,
            neighbourhood: None,
            domain_angle_degrees: DOMAIN_ANGLE,
            cutoff: None,
            seed: 1,
            correlation_pairs: CORRELATION_PAIRS,
        }
    }
}

/// A column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Column {
    /// Its name, unique in the table.
    pub name: &'static str,
    /// Its description.
    pub what: &'static str,
}

/// The columns of a profile, and which of them are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// The columns; the first is drawn along x.
    pub columns: &'static [Column],
    /// The column drawn along y.
    pub drawn: usize,
    /// The column with the counts of a row, if it has one.
    pub counts: Option<Counts>,
    /// What it is drawn as.
    pub marks: Marks,
}

/// What a profile is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// Curves over a distance, a length or a time, of several states.
    Curves,
    /// Bars over a whole number, of several states.
    Bars,
    /// A bar for each kind, of the last state.
    Kinds,
}

/// The counts of the rows of a profile, and how errors follow from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counts {
    /// The column of these counts.
    pub column: usize,
    /// How the error of the drawn column follows from them.
    pub spread: Spread,
}

/// The source of the error of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// The row is proportional to its count: the relative error is one over its root.
    OfCount,
    /// The row is a mean over its count of values with this standard deviation.
    OfMean(f64),
    /// This column has the error.
    Column(usize),
}

/// What a measure is called and what it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct About {
    /// Its name: what [`select`] takes, and what its profile's file is called.
    pub name: &'static str,
    /// A description in one line.
    pub line: &'static str,
    /// Its columns.
    pub columns: &'static [Column],
    /// Its profile, if it has one.
    pub profile: Option<Profile>,
    /// The columns to be drawn over time, one panel for each list; the figure is named after the first column of all.
    pub plots: &'static [&'static [&'static str]],
}

/// A cell of a table; `None` if the state does not define it.
pub type Cell = Option<f64>;

/// The result of a measure for one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// One value per column.
    pub values: Vec<Cell>,
    /// The rows of the profile.
    pub rows: Vec<Vec<Cell>>,
    /// Notes: why parts are missing, and caveats.
    pub remark: Option<String>,
}

/// Why a measure is omitted for a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut(pub String);

impl From<&str> for LeftOut {
    fn from(reason: &str) -> Self {
        LeftOut(reason.into())
    }
}

/// A measure.
pub trait Measure: Sync {
    /// What it is called and what it has.
    fn about(&self) -> &'static About;
    /// Its name.
    fn name(&self) -> &'static str {
        self.about().name
    }
    /// Its columns.
    fn columns(&self) -> &'static [Column] {
        self.about().columns
    }
    /// Its profile, if it has one.
    fn profile(&self) -> Option<Profile> {
        self.about().profile
    }
    /// Measures a state.
    ///
    /// # Errors
    /// [`LeftOut`] if the state lacks the required data.
    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut>;
    /// Adds values that need more than one state; `found` has the result of each time.
    fn over_time(&self, _times: &[f64], _found: &mut [Result<Found, LeftOut>]) {}
    /// Whether it needs the tracks of bodies.
    fn follows(&self) -> bool {
        false
    }
    /// Adds values that need tracks, if any; a profile by lag time belongs to the last state.
    fn along(&self, _times: &[f64], _tracks: &Tracks, _found: &mut [Result<Found, LeftOut>]) {}
}

/// The measures. To add one, write its file and list it here.
pub static ALL: [&dyn Measure; 21] = [
    &nematic::Nematic,
    &correlation::Correlation,
    &radius::Radius,
    &packing::Packing,
    &density::Density,
    &length::Length,
    &contacts::Contacts,
    &stress::Stress,
    &shear_stress::ShearStress,
    &force_chains::ForceChains,
    &friction::Friction,
    &walls::OnWalls,
    &fields::OfFields,
    &bonds::OfBonds,
    &microdomains::Microdomains,
    &dissipation::Dissipation,
    &msd::Msd,
    &velocity_correlation::VelocityCorrelation,
    &groups::Groups,
    &segregation::Segregation,
    &removal::Removed,
];

/// The measures of these names, in the order of the table; all if no name is given.
///
/// # Errors
/// [`MeasureError::Unknown`] for a name that no measure has.
pub fn select(names: &[String]) -> Result<Vec<&'static dyn Measure>, MeasureError> {
    if let Some(name) = names.iter().find(|name| ALL.iter().all(|measure| measure.name() != name.as_str())) {
        return Err(MeasureError::Unknown { name: name.clone() });
    }
    let asked = |measure: &&&dyn Measure| names.is_empty() || names.iter().any(|name| name == measure.name());
    Ok(ALL.iter().filter(asked).copied().collect())
}

/// A number as a cell; empty if it is not finite.
fn cell(value: f64) -> Cell {
    value.is_finite().then_some(value)
}

/// A count as a cell.
fn count(value: usize) -> Cell {
    Some(value as f64)
}
