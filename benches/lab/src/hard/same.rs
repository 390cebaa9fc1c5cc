//! Invariances: the order of the bodies, the position and orientation of the scene, and the unit of length.

use super::cases::{Case, Test};
use super::run::{Run, follow};
use super::start::{Start, ellipsoid, heap, ring, rod, sphere};
use super::verdict::Measure;
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::Body;
use relcp::shape::Shape;

/// A change of a scene that changes its result in the same way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The bodies in another order: every `n`th in turn.
    Order(usize),
    /// All turned about the origin and then moved.
    Moved {
        /// By how much.
        by: [f64; 3],
        /// How, as rotation vector.
        turned: [f64; 3],
    },
    /// Every length, the tolerances and dt, times this.
    Units(f64),
}

/// Steps that are compared: errors of rounding grow where bodies slide off each other.
const STEPS: u64 = 5;
/// So well solved, differences that are left are of rounding.
const FINE: f64 = 1e-12;
/// The most by which results may differ that are so well solved, in lengths of the scene's size 1. Coordinates of 1e6
/// have spacings of 1e-10.
const FINE_BOUND: f64 = 1e-8;
/// With the default settings: what a step may leave of overlap, in each.
const DEFAULT_BOUND: f64 = STEPS as f64 * 1e-5;

pub(super) fn cases() -> Vec<Case> {
    let turned = [0.5, -1.0, 0.35];
    let changes = [
        ("bodies in another order", Change::Order(5)),
        ("turned and moved by a few lengths", Change::Moved { by: [0.7, -1.1, 0.4], turned }),
        ("moved by 1e4 lengths", Change::Moved { by: [1e4, -1e4, 1e4], turned: [0.0; 3] }),
        ("moved by 1e6 lengths", Change::Moved { by: [1e6, -1e6, 1e6], turned: [0.0; 3] }),
        ("lengths times 1e-6", Change::Units(1e-6)),
        ("lengths times 1e6", Change::Units(1e6)),
    ];
    // No separation is defined between an ellipsoid and a ring.
    let heaps = [
        ("spheres, rods and ellipsoids", [sphere(0.5), rod(0.5, 2.0), ellipsoid([0.4, 0.6, 1.0])]),
        ("spheres, rods and rings", [sphere(0.5), rod(0.5, 2.0), ring(1.0, 0.15)]),
    ];
    let of = |(bodies, shapes): (&str, [Shape; 3])| {
        let start = Start::still(0.02, heap(41, &shapes, 16, 2.0)).pulled(1.0);
        let case = move |name: &str, change: Change, how: &str, start: Start| Case {
            group: "invariance",
            name: format!("16 {bodies}, {name}, {how}"),
            steps: STEPS,
            start,
            test: Test::Same(change),
        };
        let both = |(name, change): (&str, Change)| {
            let fine = case(name, change, "solved to 1e-12", start.clone().solved_to(FINE));
            [fine, case(name, change, "default solver tolerance", start.clone())]
        };
        changes.into_iter().flat_map(both).collect::<Vec<Case>>()
    };
    heaps.into_iter().flat_map(of).collect()
}

/// The run of the changed scene, and how far it ends from the changed end of the scene's.
pub(super) fn compare(start: &Start, change: Change, steps: u64) -> (Run, Measure) {
    let plain = follow(start, steps, |_, _| {});
    let changed = follow(&change.of_start(start), steps, |_, _| {});
    let what = "farthest from the unchanged scene's result";
    let bound = if start.scene.solver.tolerance.is_some() { FINE_BOUND } else { DEFAULT_BOUND };
    let value = if changed.figures.steps == steps && plain.bodies.len() == changed.bodies.len() {
        change.farthest(&plain.bodies, &changed.bodies)
    } else {
        f64::NAN
    };
    (changed, Measure { what, value, bound, by_passing: false })
}

fn rotation(vector: [f64; 3]) -> DQuat {
    DQuat::from_scaled_axis(DVec3::from(vector))
}

impl Change {
    fn of_start(self, start: &Start) -> Start {
        let mut start = start.clone();
        match self {
            Change::Order(nth) => {
                let count = start.scene.bodies.len();
                start.scene.bodies = order(nth, count).map(|i| start.scene.bodies[i].clone()).collect();
            }
            Change::Moved { by, turned } => {
                let turned = rotation(turned);
                start.scene.bodies.iter_mut().for_each(|body| turn(body, turned, DVec3::from(by)));
                if let Some(pull) = &mut start.pull {
                    pull.centre = turned * pull.centre + DVec3::from(by);
                }
            }
            // The same stiffness moves bodies of s times the length, which have s times the drag, at s/s the speed: dt
            // goes with lengths.
            Change::Units(s) => {
                let scene = &mut start.scene;
                scene.bodies.iter_mut().for_each(|body| scale(body, s));
                scene.contact.overlap_tolerance *= s;
                scene.contact.cutoff = scene.contact.cutoff.map(|cutoff| cutoff * s);
                scene.solver.tolerance = scene.solver.tolerance.map(|tolerance| tolerance * s);
                scene.time.dt *= s;
                scene.time.end *= s;
                if let Some(pull) = &mut start.pull {
                    pull.centre *= s;
                }
            }
        }
        start
    }

    /// The farthest that the centre or a point a length beside it is from where it should be, in lengths of the
    /// unchanged scene.
    fn farthest(self, plain: &Bodies, changed: &Bodies) -> f64 {
        let (turned, by, s) = match self {
            Change::Order(_) => (DQuat::IDENTITY, DVec3::ZERO, 1.0),
            Change::Moved { by, turned } => (rotation(turned), DVec3::from(by), 1.0),
            Change::Units(s) => (DQuat::IDENTITY, DVec3::ZERO, s),
        };
        let now: Vec<usize> = match self {
            Change::Order(nth) => order(nth, plain.len()).collect(),
            _ => (0..plain.len()).collect(),
        };
        let off = |(there, here): (usize, usize)| {
            let centre = ((changed.position[there] - by) / s - turned * plain.position[here]).length();
            let axis =
                |axis: DVec3| (changed.orientation[there] * axis - turned * (plain.orientation[here] * axis)).length();
            [centre, axis(DVec3::X), axis(DVec3::Y), axis(DVec3::Z)].into_iter().fold(0.0, worse)
        };
        now.into_iter().enumerate().map(off).fold(0.0, worse)
    }
}

/// The larger, and what is not a number before all.
fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Every `nth` of `count`, then those after them.
fn order(nth: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..nth).flat_map(move |first| (first..count).step_by(nth))
}

fn turn(body: &mut Body, turned: DQuat, by: DVec3) {
    body.position = (turned * DVec3::from(body.position) + by).to_array();
    let DQuat { x, y, z, w } = (turned * body.rotation()).normalize();
    (body.orientation, body.axis, body.angle) = (Some([w, x, y, z]), None, None);
}

fn scale(body: &mut Body, s: f64) {
    body.position = body.position.map(|x| x * s);
    let (tag, sizes) = body.shape.code();
    // No scene holds a custom shape, which has no code.
    body.shape = Shape::from_code(tag, sizes.map(|size| size * s)).unwrap_or(body.shape);
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURNED: [f64; 3] = [0.5, -1.0, 0.35];

    #[test]
    fn a_change_without_steps_is_undone() {
        let start = Start::still(0.02, heap(1, &[sphere(0.5), rod(0.5, 2.0), ellipsoid([0.4, 0.6, 1.0])], 7, 2.0));
        let plain = start.scene.build().unwrap();
        let changes = [
            Change::Order(3),
            Change::Moved { by: [1.0, 2.0, -3.0], turned: TURNED },
            Change::Units(1e-6),
            Change::Units(1e6),
        ];
        for change in changes {
            let changed = change.of_start(&start);
            let mut bodies = changed.scene.build().unwrap();
            assert!(change.farthest(&plain, &bodies) < 1e-14, "{change:?}");
            // One body that is out of place, turned or lost among the numbers is seen.
            bodies.orientation[4] = (bodies.orientation[4] * DQuat::from_rotation_z(1e-3)).normalize();
            assert!((change.farthest(&plain, &bodies) - 1e-3).abs() < 1e-6, "{change:?}");
            bodies.position[2].x = f64::NAN;
            assert!(change.farthest(&plain, &bodies).is_nan());
        }
        let scaled = Change::Units(1e-6).of_start(&start).scene;
        assert!((scaled.contact.overlap_tolerance - 1e-11).abs() < 1e-25 && (scaled.time.dt - 2e-8).abs() < 1e-22);
        assert!((scaled.bodies[1].shape.major_axis() - 2e-6).abs() < 1e-20);
    }

    #[test]
    fn every_body_has_one_place_in_another_order() {
        let mut all: Vec<usize> = order(5, 16).collect();
        assert_eq!(all[..5], [0, 5, 10, 15, 1]);
        all.sort_unstable();
        assert_eq!(all, (0..16).collect::<Vec<usize>>());
    }
}
