//! Where bodies are and how they are turned, in steps that no picture tells from what was recorded.
//!
//! A centre is a whole number of steps from the run's least corner, along each axis, and a state has the difference
//! to the body's last one. A turn is the
//! last one, as the page has it, times a small one, whose three smaller parts are whole numbers of steps; so errors
//! do not add up. Of a body that looks
//! the same however it is turned about its axis, only the axis's way is kept, and of a ball no turn.

use super::columns::Block;
use crate::bodies::Bodies;
use crate::shape::{Centreline, Geometry, Shape};
use glam::{DQuat, DVec3};
use serde::Serialize;

/// Steps of a centre to the thickness of the thinnest body.
const STEPS_OF_THICKNESS: f64 = 1024.0;
/// The most steps along an axis: differences must fit 32 bits with a sign.
const MOST_STEPS: f64 = (1 << 29) as f64;
/// Steps of a turn's part to one, times the root of a half: the parts beside the largest are at most that, and fill
/// 16 bits with a sign.
const TURN_STEPS: f64 = 32767.0 * std::f64::consts::SQRT_2;

/// The largest differences between what a page shows and what was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Of a centre along an axis, a length.
    pub centre: f64,
    /// Of a turn, in degrees; of a body that is round about its axis, that of the axis.
    pub turn_degrees: f64,
    /// Of a growing body's length.
    pub length: f64,
}

/// The steps of centres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// The corner of the least coordinates.
    pub low: DVec3,
    /// A step's length.
    pub step: f64,
    /// The middle of all centres, in steps.
    pub middle: [i32; 3],
}

impl Grid {
    /// The steps for centres between two corners.
    pub fn new(low: DVec3, high: DVec3, thinnest: f64) -> Grid {
        let size = high - low;
        if !(size.is_finite() && thinnest.is_finite() && thinnest > 0.0) {
            return Grid { low: DVec3::ZERO, step: 1.0, middle: [0; 3] };
        }
        let step = (thinnest / STEPS_OF_THICKNESS).max(size.max_element() / MOST_STEPS);
        Grid { low, step, middle: (size / (2.0 * step)).round().to_array().map(|x| x as i32) }
    }

    /// The middle as a place in space.
    pub fn origin(&self) -> DVec3 {
        self.at(self.middle)
    }

    fn at(&self, steps: [i32; 3]) -> DVec3 {
        self.low + DVec3::from_array(steps.map(f64::from)) * self.step
    }

    fn steps_to(&self, point: DVec3) -> [i32; 3] {
        self.steps(point - self.low)
    }

    /// A distance in whole steps.
    pub fn steps(&self, distance: DVec3) -> [i32; 3] {
        (distance / self.step).round().to_array().map(|x| x as i32)
    }
}

/// Where each body of the table was last, as the page has it.
#[derive(Default)]
pub(super) struct Places {
    centres: Vec<[i32; 3]>,
    turns: Vec<[f32; 4]>,
}

impl Places {
    /// Adds the centres; their errors, by body, are what is left to the true ones.
    pub fn centres(
        &mut self,
        bodies: &Bodies,
        rows: &[u32],
        grid: &Grid,
        block: &mut Block,
        errors: &mut Errors,
    ) -> Vec<DVec3> {
        let most = rows.iter().map(|row| *row as usize + 1).max().unwrap_or(0);
        self.centres.resize(most.max(self.centres.len()), [0; 3]);
        let mut differences = [const { Vec::new() }; 3];
        let mut shown = Vec::with_capacity(rows.len());
        for (centre, row) in bodies.position.iter().zip(rows) {
            let steps = grid.steps_to(*centre);
            let last = std::mem::replace(&mut self.centres[*row as usize], steps);
            for (k, axis) in differences.iter_mut().enumerate() {
                axis.push(steps[k].wrapping_sub(last[k]));
            }
            let error = (grid.at(steps) - centre).abs().max_element();
            if error.is_finite() {
                errors.centre = errors.centre.max(error);
            }
            shown.push(grid.at(steps));
        }
        for (name, axis) in ["x", "y", "z"].into_iter().zip(&differences) {
            block.add_signed(name, axis);
        }
        shown
    }

    /// Adds the turns.
    pub fn turns(&mut self, bodies: &Bodies, rows: &[u32], block: &mut Block, errors: &mut Errors) {
        let most = rows.iter().map(|row| *row as usize + 1).max().unwrap_or(0);
        self.turns.resize(most.max(self.turns.len()), [0.0, 0.0, 0.0, 1.0]);
        let mut largest = Vec::with_capacity(rows.len());
        let mut parts = [const { Vec::new() }; 3];
        for ((shape, turn), row) in bodies.shape.iter().zip(&bodies.orientation).zip(rows) {
            let last = &mut self.turns[*row as usize];
            let wanted = needed(shape, DQuat::from_array(last.map(f64::from)).inverse() * turn.normalize());
            let (place, three) = smallest_three(wanted);
            largest.push(place as u32);
            for (axis, part) in parts.iter_mut().zip(three) {
                axis.push(part);
            }
            *last = turned(*last, place, three);
            let left = needed(shape, DQuat::from_array(last.map(f64::from)).normalize().inverse() * turn.normalize());
            let error = 2.0 * DVec3::new(left.x, left.y, left.z).length().min(1.0).asin().to_degrees();
            errors.turn_degrees = errors.turn_degrees.max(error);
        }
        block.add("turn_largest", &largest);
        for (name, part) in ["turn_1", "turn_2", "turn_3"].into_iter().zip(&parts) {
            block.add_signed(name, part);
        }
    }
}

/// What of a turn from the last one can be seen.
fn needed(shape: &Shape, turn: DQuat) -> DQuat {
    let round = match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Point, .. } => return DQuat::IDENTITY,
        Geometry::Centreline { .. } => true,
        Geometry::Ellipsoid { radii } => radii.x == radii.y,
        Geometry::Convex(_) => false,
    };
    let about = DQuat::from_xyzw(0.0, 0.0, turn.z, turn.w);
    match round && about.length() > 1e-9 {
        true => turn * about.normalize().inverse(),
        false => turn,
    }
}

/// Which part is the largest, and the others in steps, with the sign that makes it positive.
fn smallest_three(turn: DQuat) -> (usize, [i32; 3]) {
    let parts = turn.to_array();
    let largest = (0..4).fold(3, |best: usize, k| if parts[k].abs() > parts[best].abs() { k } else { best });
    let sign = 1.0_f64.copysign(parts[largest]);
    let mut others = (0..4).filter(|k| *k != largest).map(|k| (sign * parts[k] * TURN_STEPS).round() as i32);
    (largest, std::array::from_fn(|_| others.next().unwrap_or(0)))
}

/// The last turn times the small one, as the page reckons it: the same operations in the same order.
fn turned(last: [f32; 4], largest: usize, three: [i32; 3]) -> [f32; 4] {
    let [p, q, r] = three.map(|part| f64::from(part) / TURN_STEPS);
    let s = (1.0 - p * p - q * q - r * r).max(0.0).sqrt();
    let [a, b, c, d] = match largest {
        0 => [s, p, q, r],
        1 => [p, s, q, r],
        2 => [p, q, s, r],
        _ => [p, q, r, s],
    };
    let [x, y, z, w] = last.map(f64::from);
    let e = w * a + d * x + (y * c - z * b);
    let f = w * b + d * y + (z * a - x * c);
    let g = w * c + d * z + (x * b - y * a);
    let h = w * d - (x * a + y * b + z * c);
    let norm = (e * e + f * f + g * g + h * h).sqrt();
    [e, f, g, h].map(|part| (part / norm) as f32)
}

/// Adds half the segments of rods; their range.
pub(super) fn lengths(bodies: &Bodies, block: &mut Block, errors: &mut Errors) -> Option<[f64; 2]> {
    let halves: Vec<f64> = bodies.shape.iter().map(half_segment).collect();
    let rods = || halves.iter().copied().filter(|half| half.is_finite());
    let range = [rods().reduce(f64::min)?, rods().reduce(f64::max)?];
    block.add_between("half_length", halves.iter().copied(), range);
    errors.length = errors.length.max((range[1] - range[0]) / f64::from(u16::MAX));
    Some(range)
}

/// Half a rod's segment, the semi-axis along z of an ellipsoid, whose others follow from it where it grows; not a
/// number for other shapes.
pub(super) fn half_segment(shape: &Shape) -> f64 {
    match shape.geometry() {
        Geometry::Centreline { curve: Centreline::Segment { half }, .. } => half,
        Geometry::Ellipsoid { radii } => radii.z,
        Geometry::Convex(custom) if shape.exponents().is_none() => custom.reach(DVec3::Z).max(custom.reach(-DVec3::Z)),
        _ => f64::NAN,
    }
}
