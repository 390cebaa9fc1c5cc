//! The alignment of cells after each division.

use super::{Run, SHOWN};
use relcp::scene::Method;
use relcp::simulation::Simulation;
use serde::Serialize;

/// The measured quantities, with their names in `relcp measure`.
pub(super) const COLUMNS: [&str; 5] =
    ["nematic_order", "nematic_local", "correlation_length", "domain_mean", "radius_gyration"];

/// The alignment of the cells of a run after a division.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Generation {
    /// The time.
    pub time: f64,
    /// Cells.
    pub bodies: usize,
    /// Nematic order of all cells.
    pub nematic_order: Option<f64>,
    /// Mean nematic order of the cells' neighbourhoods.
    pub nematic_local: Option<f64>,
    /// Where the correlation of orientations has fallen to 1/e, a length.
    pub correlation_length: Option<f64>,
    /// Mean number of cells of a microdomain.
    pub domain_mean: Option<f64>,
    /// Radius of gyration of the centres.
    pub gyration: Option<f64>,
}

impl Generation {
    pub(super) fn new(simulation: &Simulation, found: [Option<f64>; 5]) -> Self {
        let [nematic_order, nematic_local, correlation_length, domain_mean, gyration] = found;
        let (time, bodies) = (simulation.time(), simulation.bodies());
        Generation { time, bodies, nematic_order, nematic_local, correlation_length, domain_mean, gyration }
    }
}

/// A quantity by ReLCP and with sub-spheres, means over the seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Morphology {
    /// Cells.
    pub bodies: usize,
    /// The quantity.
    pub quantity: &'static str,
    /// By ReLCP.
    pub relcp: f64,
    /// The standard deviation over the seeds; none of one.
    pub relcp_deviation: Option<f64>,
    /// Seeds.
    pub relcp_seeds: usize,
    /// With sub-spheres.
    pub spheres: f64,
    /// The standard deviation over the seeds.
    pub spheres_deviation: Option<f64>,
    /// Seeds.
    pub spheres_seeds: usize,
}

impl Morphology {
    /// The difference over what it may differ by from chance: the root of the sum of the squared standard errors. None
    /// of single seeds.
    pub fn significance(&self) -> Option<f64> {
        let error = |deviation: f64, seeds: usize| deviation * deviation / seeds as f64;
        let chance =
            error(self.relcp_deviation?, self.relcp_seeds) + error(self.spheres_deviation?, self.spheres_seeds);
        Some((self.spheres - self.relcp) / chance.sqrt()).filter(|ratio| ratio.is_finite())
    }
}

type Quantity = (&'static str, fn(&Generation) -> Option<f64>);

const QUANTITIES: [Quantity; 5] = [
    ("correlation length", |of| of.correlation_length),
    ("local nematic order", |of| of.nematic_local),
    ("nematic order", |of| of.nematic_order),
    ("cells of a microdomain", |of| of.domain_mean),
    ("radius of gyration", |of| of.gyration),
];

/// Every quantity after every division that both methods have; first the correlation length, then the others, each from
/// few cells to many.
pub(super) fn morphology(runs: &[Run]) -> Vec<Morphology> {
    let most = runs.iter().flat_map(|run| &run.generations).map(|of| of.bodies).max().unwrap_or(0);
    let counts = (1..usize::BITS).map(|k| 1usize << k).take_while(|bodies| *bodies <= most);
    let counts: Vec<usize> = counts.collect();
    let of = |method: Method, bodies: usize, quantity: fn(&Generation) -> Option<f64>| -> Vec<f64> {
        let of_method = runs.iter().filter(|run| run.case.method == method);
        of_method.flat_map(|run| &run.generations).filter(|of| of.bodies == bodies).filter_map(quantity).collect()
    };
    QUANTITIES
        .iter()
        .flat_map(|(name, quantity)| counts.iter().map(move |bodies| (*name, *quantity, *bodies)))
        .filter_map(|(quantity, get, bodies)| {
            let (own, other) = (of(Method::Relcp, bodies, get), of(Method::Multisphere { count: SHOWN }, bodies, get));
            Some(Morphology {
                bodies,
                quantity,
                relcp: mean(&own)?,
                relcp_deviation: deviation(&own),
                relcp_seeds: own.len(),
                spheres: mean(&other)?,
                spheres_deviation: deviation(&other),
                spheres_seeds: other.len(),
            })
        })
        .collect()
}

/// None of nothing.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The standard deviation of what the values are a sample of; none of fewer than two.
pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}
