//! Which states a page has, and the space that their bodies take.

use super::Pages;
use super::places::Grid;
use crate::record::{States, Watch};
use crate::render::{RenderError, inside, interval};
use glam::DVec3;
use rayon::prelude::*;

/// The states of a page.
pub(super) struct Chosen {
    /// Their numbers among all.
    pub indices: Vec<usize>,
    /// The periods of space, which all states have.
    pub periods: [Option<f64>; 3],
    /// Bodies of the largest.
    pub most: usize,
    /// The steps of centres.
    pub grid: Grid,
}

/// What is known of a state that was looked at.
struct Seen {
    index: usize,
    time: f64,
    bodies: usize,
    periods: [Option<f64>; 3],
    low: DVec3,
    high: DVec3,
    thinnest: f64,
}

impl Chosen {
    /// Looks at all states.
    pub fn of(states: &States, pages: &Pages, watch: Watch<'_>) -> Result<Chosen, RenderError> {
        let mut all: Vec<Seen> = Vec::new();
        let indices: Vec<usize> = (0..states.len()).collect();
        for part in indices.chunks(rayon::current_num_threads().max(1)) {
            if !watch(0, states.len()) {
                return Err(RenderError::Stopped { done: 0, all: states.len() });
            }
            all.extend(part.par_iter().map(|&index| Seen::of(states, index)).collect::<Result<Vec<_>, RenderError>>()?);
        }
        let times = span(&all);
        let kept: Vec<Seen> = all
            .into_iter()
            .filter(|state| inside(state.time, pages.from, pages.to))
            .step_by(pages.every.max(1))
            .collect();
        if kept.is_empty() {
            let interval = interval(pages.from, pages.to);
            return Err(RenderError::Nothing { states: states.len(), interval, first: times[0], last: times[1] });
        }
        let low = kept.iter().fold(DVec3::INFINITY, |low, state| low.min(state.low));
        let high = kept.iter().fold(DVec3::NEG_INFINITY, |high, state| high.max(state.high));
        let thinnest = kept.iter().map(|state| state.thinnest).fold(f64::INFINITY, f64::min);
        Ok(Chosen {
            periods: kept[0].periods,
            most: kept.iter().map(|state| state.bodies).max().unwrap_or(0),
            grid: Grid::new(low, high, thinnest),
            indices: kept.into_iter().map(|state| state.index).collect(),
        })
    }
}

fn span(states: &[Seen]) -> [f64; 2] {
    let times = || states.iter().map(|state| state.time);
    [times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max)]
}

impl Seen {
    fn of(states: &States, index: usize) -> Result<Seen, RenderError> {
        let state = states.read(index)?;
        let bodies = state.bodies.wrapped();
        // What is not finite has no place in a picture; files hold no such numbers.
        let places = || bodies.position.iter().filter(|x| x.is_finite());
        Ok(Seen {
            index,
            time: state.time,
            bodies: bodies.len(),
            periods: bodies.periods.lengths(),
            low: places().fold(DVec3::INFINITY, |low, x| low.min(*x)),
            high: places().fold(DVec3::NEG_INFINITY, |high, x| high.max(*x)),
            thinnest: bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min),
        })
    }
}
