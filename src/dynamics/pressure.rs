//! The contact pressure of each body, from the contact forces that a step ended with.
//!
//! A contact has the force `gamma n` on b, with friction `gamma n + t`, and its opposite on a. The levers go from the
//! centres to the contact, half-way between the surfaces. A body's virial is the sum of force times lever over its
//! contacts, positive in compression; over its own volume and the dimension it is its pressure (J. Christoffersen, M.
//! M. Mehrabadi, S. Nemat-Nasser, J. Appl. Mech. 48, 339 (1981); a body's own part of their stress). In a planar scene
//! it is a force over a length, with the area of a rod's section. `relcp measure` and `relcp render` use the same
//! number.

use crate::bodies::Bodies;
use crate::separation::{branch, reach_across, reach_of_place, separate_in};
use crate::shape::Shape;
use crate::walls::surface_of;
use crate::warm::Warm;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A loop over fewer pairs than this runs on one thread: a separation of rods takes some 0.1 us.
const LEAST_PAIRS_A_TASK: usize = 256;

/// The pressure of each cell; zero for a body that is neither a rod nor an ellipsoid. `warm` is what the step that left
/// `bodies` remembers of its near pairs, sorted by pair, of smooth surfaces. The sums run in that order, so that the
/// bits depend on nothing else.
pub fn pressures(bodies: &Bodies, warm: &[Warm], planar: bool) -> Vec<f64> {
    let separate = separate_in(planar);
    let grows = |i: usize| bodies.shape[i].growing_length().is_some();
    let of_pair = |warm: &Warm| {
        let [a, b] = warm.pair.map(|body| body as usize);
        if surface_of(warm.pair[1]).is_some() {
            return virial_of_wall(bodies, warm).map(|virial| [(a, virial), (a, 0.0)]);
        }
        if !(warm.gamma > 0.0 && (grows(a) || grows(b))) {
            return None;
        }
        let [of_a, of_b] = bodies.pair(a, b);
        let nearest = separate(&of_a, &of_b, Some(warm.normal).filter(|n| n.is_normalized()))?;
        let found = branch(&of_a, &of_b, &nearest, warm.feature);
        let delta = of_b.position - of_a.position;
        // From a's centre to the point half-way between the surfaces, and from b's.
        let to_a = 0.5 * (found.lever_a + delta + found.lever_b);
        let force = warm.force(found.normal);
        Some([(a, force.dot(to_a)), (b, -force.dot(to_a - delta))])
    };
    let parts: Vec<_> = warm.par_iter().with_min_len(LEAST_PAIRS_A_TASK).map(of_pair).collect();
    let mut pressures = vec![0.0; bodies.len()];
    for (body, virial) in parts.into_iter().flatten().flatten() {
        pressures[body] += virial;
    }
    for (i, pressure) in pressures.iter_mut().enumerate() {
        *pressure = volume(bodies, i, planar).map_or(0.0, |volume| *pressure / volume);
    }
    pressures
}

/// The virial of a body's contact with a wall: the lever counts along the force. None without a force.
pub(crate) fn virial_of_wall(bodies: &Bodies, warm: &Warm) -> Option<f64> {
    let placed = || bodies.placed(warm.pair[0] as usize);
    let reach = || reach_of_place(&placed(), warm.feature, warm.normal);
    let across = || reach_across(&placed(), warm.feature, warm.normal, warm.tangent);
    (warm.gamma > 0.0 && warm.normal.is_normalized()).then(|| warm.gamma * reach() + across())
}

/// The dimension times a cell's volume, or in the plane the area of its section.
fn volume(bodies: &Bodies, i: usize, planar: bool) -> Option<f64> {
    let shape = &bodies.shape[i];
    let (length, diameter) = (shape.growing_length()?, shape.thickness());
    if let (Shape::Ellipsoid { .. }, true) = (shape, planar) {
        return Some(2.0 * shape.section(bodies.orientation[i]));
    }
    let area = 0.25 * PI * diameter * diameter;
    Some(if planar { 2.0 * (area + (length - diameter) * diameter) } else { 3.0 * shape.volume() })
}
