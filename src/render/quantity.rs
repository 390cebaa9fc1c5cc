//! The quantities that a run's pictures show by colour: a value per body, from one recorded state.

use crate::bodies::Bodies;
use crate::measure::groups::number;
use crate::measure::{Frame, LeftOut, Settings, View};
use crate::record::Snapshot;

/// The quantity that a body's colour shows in the pictures of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// The direction of its axis: half a turn in the x-y plane is a full turn of the hue, which pales out of that
    /// plane.
    #[default]
    Orientation,
    /// Time since its birth.
    Age,
    /// Divisions since its founder.
    Generation,
    /// Its longest extent, for a rod from tip to tip.
    Length,
    /// Its centre's speed.
    Speed,
    /// The number of bodies that it touches.
    Contacts,
    /// Its deepest overlap with another body.
    Overlap,
    /// The sum of the magnitudes of the contact forces on it. Needs output.forces.
    Force,
    /// Its contact pressure: the virial of the contact forces on it over its own volume, in a planar run its area.
    /// Needs output.forces.
    Pressure,
    /// The number of its group in the scene's order, from 1; 0 for a body without one.
    Group,
    /// Nothing.
    Plain,
}

/// How the ends of a scale follow from a quantity's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// From the smallest to the largest.
    Least,
    /// From zero to the largest.
    Zero,
    /// From zero to the 99th percentile, so that a few outliers do not use most of the scale.
    Most,
}

impl Quantity {
    /// All quantities.
    pub(crate) const ALL: [Quantity; 11] = [
        Quantity::Orientation,
        Quantity::Age,
        Quantity::Generation,
        Quantity::Length,
        Quantity::Speed,
        Quantity::Contacts,
        Quantity::Overlap,
        Quantity::Force,
        Quantity::Pressure,
        Quantity::Group,
        Quantity::Plain,
    ];

    /// Its name in options.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Orientation => "orientation",
            Quantity::Age => "age",
            Quantity::Generation => "generation",
            Quantity::Length => "length",
            Quantity::Speed => "speed",
            Quantity::Contacts => "contacts",
            Quantity::Overlap => "overlap",
            Quantity::Force => "force",
            Quantity::Pressure => "pressure",
            Quantity::Group => "group",
            Quantity::Plain => "plain",
        }
    }

    /// The ends of its scale; `None` for a quantity without a scale.
    pub(crate) fn ends(self) -> Option<Ends> {
        match self {
            Quantity::Orientation | Quantity::Plain => None,
            Quantity::Length | Quantity::Group => Some(Ends::Least),
            Quantity::Age | Quantity::Generation | Quantity::Contacts => Some(Ends::Zero),
            Quantity::Speed | Quantity::Overlap | Quantity::Force | Quantity::Pressure => Some(Ends::Most),
        }
    }

    /// Whether it is meaningless in a run without births.
    pub(crate) fn is_of_births(self) -> bool {
        matches!(self, Quantity::Age | Quantity::Generation)
    }

    /// Its value for each body; none for a quantity without a scale.
    ///
    /// # Errors
    /// [`LeftOut`] if the state does not have it.
    pub fn of(self, state: &Snapshot, frame: &Frame) -> Result<Vec<f64>, LeftOut> {
        match self {
            // Quantities without contacts need no view.
            Quantity::Orientation | Quantity::Plain => Ok(Vec::new()),
            _ => self.of_view(&View::new(state, frame, &Settings::default())),
        }
    }

    /// As [`Quantity::of`], for a view of a state, so that several quantities share its contacts.
    ///
    /// # Errors
    /// As [`Quantity::of`].
    pub(crate) fn of_view(self, view: &View<'_>) -> Result<Vec<f64>, LeftOut> {
        let (state, bodies) = (view.state, view.bodies());
        Ok(match self {
            Quantity::Orientation | Quantity::Plain => Vec::new(),
            Quantity::Age => bodies.lineage.iter().map(|line| state.time - line.birth).collect(),
            Quantity::Generation => bodies.lineage.iter().map(|line| f64::from(line.generation)).collect(),
            Quantity::Length => bodies.shape.iter().map(|shape| shape.major_axis()).collect(),
            Quantity::Speed => bodies.velocity.iter().map(|velocity| velocity.length()).collect(),
            Quantity::Contacts => sums(bodies.len(), view.touching().map(|contact| (contact.pair, 1.0))),
            Quantity::Group => bodies.group.iter().map(|group| f64::from(number(*group))).collect(),
            Quantity::Overlap => overlaps(bodies),
            Quantity::Force | Quantity::Pressure if state.step == 0 && state.warm.is_some() => vec![0.0; bodies.len()],
            Quantity::Force => sums(bodies.len(), view.pushing()?.map(|contact| (contact.pair, contact.gamma))),
            Quantity::Pressure => {
                let virials = view.virials()?;
                virials.iter().zip(&view.volumes).map(|(virial, volume)| virial / (view.dimension() * volume)).collect()
            }
        })
    }
}

/// For each body, the sum over its pairs.
fn sums(bodies: usize, pairs: impl Iterator<Item = ([usize; 2], f64)>) -> Vec<f64> {
    let mut sums = vec![0.0; bodies];
    pairs.for_each(|(pair, value)| pair.iter().for_each(|&body| sums[body] += value));
    sums
}

fn overlaps(bodies: &Bodies) -> Vec<f64> {
    let mut deepest = vec![0.0_f64; bodies.len()];
    for near in crate::step::contacts(bodies, 0.0) {
        near.bodies.iter().for_each(|&body| deepest[body] = deepest[body].max(-near.separation));
    }
    deepest
}
