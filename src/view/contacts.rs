//! The contacts of a state, as an export has them, and those with walls: which bodies, how hard they push, how far
//! apart they are, and where.

use super::columns::Block;
use super::header::StateHeader;
use super::places::Grid;
use crate::bodies::Bodies;
use crate::measure::View;
use crate::record::Snapshot;
use crate::walls::{Walls, surface_of};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// The most contacts of all states together; a state may have its part of them, and the last one has all of its own.
const MOST: usize = 1_000_000;

/// A contact.
struct Touch {
    /// The body, by its row in the state.
    a: usize,
    /// The other one; past the last body, the wall of that number.
    b: usize,
    /// Not a number where it is not known.
    force: f64,
    /// The signed distance.
    gap: f64,
    /// From the first body's centre.
    point: DVec3,
}

/// The contacts of a state, sorted by the first body.
pub(super) struct Touching {
    all: Vec<Touch>,
    known: bool,
}

impl Touching {
    /// The contacts of one of `states` states; none where they are too many for a page.
    pub fn of(view: &View<'_>, walls: &Walls, states: usize, last: bool) -> Option<Touching> {
        let bodies = view.bodies();
        let known = view.pushing().is_ok();
        let force = |gamma: f64| if known { gamma } else { f64::NAN };
        let mut all: Vec<Touch> = view
            .contacts()
            .iter()
            .map(|contact| {
                let [a, b] = contact.pair;
                let point = contact.point - bodies.position[a];
                Touch { a, b, force: force(contact.gamma), gap: contact.separation, point }
            })
            .collect();
        all.extend(with_walls(view, walls, known));
        all.sort_by_key(|touch| (touch.a, touch.b));
        (last || all.len() <= MOST / states.max(1)).then_some(Touching { all, known })
    }

    /// Adds them; `centres` are those that the page has.
    pub fn pack(&self, state: &Snapshot, centres: &[DVec3], grid: &Grid, block: &mut Block, about: &mut StateHeader) {
        let all = &self.all;
        let bodies: &Bodies = &state.bodies.wrapped();
        about.contacts = Some(all.len());
        let before = std::iter::once(0).chain(all.iter().map(|touch| touch.a));
        block
            .add("contact_a", &all.iter().zip(before).map(|(touch, last)| (touch.a - last) as u32).collect::<Vec<_>>());
        block.add_signed("contact_b", &all.iter().map(|touch| touch.b as i32 - touch.a as i32).collect::<Vec<_>>());
        let points: Vec<[i32; 3]> =
            all.iter().map(|touch| grid.steps(bodies.position[touch.a] + touch.point - centres[touch.a])).collect();
        for (k, name) in ["contact_x", "contact_y", "contact_z"].into_iter().enumerate() {
            block.add_signed(name, &points.iter().map(|point| point[k]).collect::<Vec<_>>());
        }
        let mut add = |name: &'static str, value: fn(&Touch) -> f64| {
            let values = || all.iter().map(value).filter(|value| value.is_finite());
            let range = [values().fold(0.0, f64::min), values().fold(0.0, f64::max)];
            block.add_between(name, all.iter().map(value), range);
            about.ranges.insert(name, range);
        };
        add("contact_gap", |touch| touch.gap);
        if self.known {
            add("contact_force", |touch| touch.force);
        }
    }
}

/// The contacts with walls.
fn with_walls(view: &View<'_>, walls: &Walls, known: bool) -> Vec<Touch> {
    let (bodies, cutoff) = (view.bodies(), view.cutoff());
    let mut forces = HashMap::new();
    for warm in view.state.warm.iter().flatten().filter(|warm| known && warm.gamma > 0.0) {
        if let Some(surface) = surface_of(warm.pair[1]) {
            *forces.entry((warm.pair[0] as usize, surface)).or_insert(0.0) += warm.gamma;
        }
    }
    let of_body = |a: usize| {
        let (body, forces) = (bodies.placed(a), &forces);
        let each = walls.surfaces().iter().enumerate();
        each.filter_map(move |(surface, it)| {
            let force = forces.get(&(a, surface)).copied();
            if force.is_none() && it.bound(&body) > cutoff {
                return None;
            }
            let found = it.separation(&body);
            let b = bodies.len() + walls.wall_of(surface);
            let unknown = if known { 0.0 } else { f64::NAN };
            let touch = Touch { a, b, force: force.unwrap_or(unknown), gap: found.separation, point: found.lever_a };
            (force.is_some() || found.separation <= cutoff).then_some(touch)
        })
    };
    (0..bodies.len()).into_par_iter().flat_map_iter(of_body).collect()
}
