//! Few bodies in poses that are hard for separations: extreme shapes, degenerate axes, coincident bodies, bodies inside
//! each other.

use super::Case;
use crate::hard::start::{Start, body, ellipsoid, heap, ring, rod, sphere, upright};
use glam::{DQuat, DVec3};
use relcp::scene::Body;
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, PI};

/// No force acts on bodies that only have to separate. One step separates them; the others show that they stay
/// separated.
const STEPS: u64 = 4;
const DT: f64 = 1e-2;

pub(super) fn cases() -> Vec<Case> {
    [shapes(), axes(), one_place(), inside()].concat()
}

fn still(group: &'static str, name: impl Into<String>, bodies: Vec<Body>) -> Case {
    Case::contact(group, name, STEPS, Start::still(DT, bodies))
}

fn shapes() -> Vec<Case> {
    let needle = ellipsoid([0.02, 0.02, 2.0]);
    let disc = ellipsoid([2.0, 2.0, 0.02]);
    let of = |name: &str, shapes: &[Shape]| {
        let start = Start::still(DT, heap(11, shapes, 20, 1.5)).pulled(20.0);
        Case::contact("aspect ratio", format!("20 {name}, pulled together"), 10, start)
    };
    let mut stack: Vec<Body> = (0..8).map(|i| upright(disc, [0.0, 0.0, 0.02 * f64::from(i)])).collect();
    stack.push(body(disc, [0.0; 3], DQuat::from_rotation_x(1e-7)));
    vec![
        of("rods 100:1", &[rod(0.04, 4.0)]),
        of("ellipsoids 100:1", &[needle]),
        of("discs 1:100", &[disc]),
        of("rods 100:1 and discs 1:100", &[rod(0.04, 4.0), disc]),
        still("aspect ratio", "9 discs 1:100, stacked in each other", stack),
    ]
}

fn axes() -> Vec<Case> {
    let thin = rod(0.2, 2.0);
    let across = DQuat::from_rotation_y(FRAC_PI_2);
    let two = |name: &str, at: [f64; 3], turned: DQuat| {
        still("axes", format!("two rods, {name}"), vec![upright(thin, [0.0; 3]), body(thin, at, turned)])
    };
    let star = (0..6).map(|i| body(thin, [0.0; 3], DQuat::from_rotation_x(f64::from(i) * PI / 6.0))).collect();
    let bundle = |length: f64| {
        let at = |i: u32| upright(rod(0.2, length), [0.1 * f64::from(i % 3), 0.1 * f64::from(i / 3), 0.0]);
        (0..9).map(at).collect()
    };
    vec![
        two("parallel, half in each other", [0.1, 0.0, 0.0], DQuat::IDENTITY),
        two("parallel, shifted", [0.1, 0.05, 0.9], DQuat::IDENTITY),
        two("parallel to 1e-9", [0.05, 0.0, 0.4], DQuat::from_rotation_x(1e-9)),
        two("collinear", [0.0, 0.0, 1.3], DQuat::IDENTITY),
        two("collinear, tips touch", [0.0, 0.0, 2.0], DQuat::IDENTITY),
        two("crossing in their middles", [0.0; 3], across),
        two("crossing off their middles", [0.3, 0.0, 0.4], across),
        still("axes", "star of six rods through one point", star),
        still("axes", "bundle of nine parallel rods, overlaps of half their diameter", bundle(2.0)),
    ]
}

fn one_place() -> Vec<Case> {
    let shapes = [sphere(0.5), rod(0.5, 2.0), ellipsoid([1.0, 1.0, 2.0]), ellipsoid([0.5, 1.0, 1.5]), ring(1.0, 0.2)];
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.9);
    let of = |shape: Shape| {
        let at = |turn: DQuat| body(shape, [0.3, 0.1, -0.2], turn);
        let name = match shape {
            Shape::Ellipsoid { radii } => format!("ellipsoids {radii:?}"),
            Shape::Spherocylinder { .. } => "rods".into(),
            Shape::Torus { .. } => "rings".into(),
            _ => format!("{}s", shape.name()),
        };
        [
            still("one place", format!("three identical {name}"), vec![at(turned); 3]),
            still(
                "one place",
                format!("two concentric {name}"),
                vec![at(turned), at(turned * DQuat::from_rotation_x(0.7))],
            ),
        ]
    };
    let mixed = shapes[..3].iter().map(|shape| upright(*shape, [0.0; 3])).collect();
    let mut cases: Vec<Case> = shapes.into_iter().flat_map(of).collect();
    cases.push(still("one place", "a sphere, a rod and an ellipsoid, concentric", mixed));
    cases.push(still("one place", "twenty identical spheres", vec![upright(sphere(0.5), [0.1, 0.2, 0.3]); 20]));
    cases
}

fn inside() -> Vec<Case> {
    let both = |name: &str, large: Shape, small: Shape, at: [f64; 3]| {
        let bodies = vec![upright(large, [0.0; 3]), body(small, at, DQuat::from_rotation_y(0.3))];
        still("inside", name, bodies)
    };
    vec![
        both("a sphere in a sphere", sphere(2.0), sphere(0.3), [0.5, 0.2, 0.1]),
        both("an ellipsoid in an ellipsoid", ellipsoid([1.0, 2.0, 3.0]), ellipsoid([0.2, 0.1, 0.3]), [0.1, 0.2, 0.3]),
        both("a rod in an ellipsoid", ellipsoid([1.0, 2.0, 3.0]), rod(0.2, 0.8), [0.1, 0.2, 0.3]),
        both("a rod in a rod", rod(2.0, 5.0), rod(0.2, 1.0), [0.1, 0.2, 0.3]),
        both("a ring in a ring", ring(1.0, 0.3), ring(1.1, 0.3), [0.05, 0.02, 0.01]),
        both("a rod through a ring's tube", ring(1.0, 0.3), rod(0.2, 2.0), [1.0, 0.0, 0.0]),
        both("a sphere too large for the ring's hole, askew", ring(1.0, 0.3), sphere(0.9), [0.02, 0.01, 0.1]),
        both("a sphere too large for the ring's hole, about its centre", ring(1.0, 0.3), sphere(0.9), [0.0; 3]),
        both(
            "a sphere too large for the ring's hole, beside its centre",
            ring(1.0, 0.3),
            sphere(0.9),
            [0.05, 0.0, 0.0],
        ),
        both("spheres 1,000:1, the small one half in the large one", sphere(10.0), sphere(0.01), [10.0, 0.0, 0.0]),
    ]
}
