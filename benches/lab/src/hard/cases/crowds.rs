//! Many contacts at once: singular systems, sizes far apart, jams, divisions, and steps far too long or short.

use super::Case;
use crate::hard::start::{Random, Start, ellipsoid, heap, ring, rod, sphere, upright};
use relcp::scene::{Body, Growth};
use std::f64::consts::TAU;

pub(super) fn cases() -> Vec<Case> {
    [sizes(), singular(), jams(), vec![division()], steps()].concat()
}

fn around(large: f64, small: f64, count: usize) -> Vec<Body> {
    let mut random = Random::new(12);
    let mut bodies = vec![upright(sphere(large), [0.0; 3])];
    bodies.extend((0..count).map(|_| {
        let at = (large + small * random.within(0.7, 3.0)) * random.direction();
        upright(sphere(small), at.to_array())
    }));
    bodies
}

fn sizes() -> Vec<Case> {
    let pressed = |name: &str, large: f64, small: f64, dt: f64| {
        let start = Start::still(dt, around(large, small, 200)).pulled(1.0);
        Case::contact("sizes", name, 20, start)
    };
    vec![
        pressed("200 spheres pressed on one of 10 times their size", 3.0, 0.3, 0.05),
        pressed("200 spheres pressed on one of 1,000 times their size", 10.0, 0.01, 1e-4),
    ]
}

fn singular() -> Vec<Case> {
    let chain: Vec<Body> = (0..30).map(|i| upright(sphere(0.5), [f64::from(i), 0.0, 0.0])).collect();
    let ends = [(0, [10.0, 0.0, 0.0]), (29, [-10.0, 0.0, 0.0])];
    let radius = 0.5 / (TAU / 24.0).sin();
    let arch: Vec<Body> = (0..12)
        .map(|i| {
            let (s, c) = (TAU * f64::from(i) / 12.0).sin_cos();
            upright(sphere(0.5), [radius * c, radius * s, 0.0])
        })
        .collect();
    let mut planar = Start::still(0.01, arch.clone()).pulled(10.0);
    planar.scene.planar = true;
    let mut lattice: Vec<Body> = (0..27).map(|i| upright(sphere(0.5), cell(i).map(f64::from))).collect();
    for body in &mut lattice {
        body.position = body.position.map(|x| x - 1.0);
    }
    vec![
        Case::contact(
            "singular",
            "chain of 30 spheres squeezed at its ends",
            40,
            Start::still(0.1, chain).pushed(&ends),
        ),
        Case::contact("singular", "closed ring of 12 spheres squeezed", 40, Start::still(0.01, arch).pulled(10.0)),
        Case::contact("singular", "closed ring of 12 spheres squeezed, planar", 40, planar),
        Case::contact(
            "singular",
            "lattice of 27 touching spheres squeezed",
            40,
            Start::still(0.05, lattice).pulled(10.0),
        ),
    ]
}

fn cell(i: u32) -> [u32; 3] {
    [i % 3, i / 3 % 3, i / 9]
}

fn jams() -> Vec<Case> {
    let mixed = [sphere(0.5), rod(0.5, 2.0), ellipsoid([0.4, 0.6, 1.0])];
    let start = Start::still(0.05, heap(71, &mixed, 60, 2.5)).pulled(10.0);
    let discs = Start::still(0.05, heap(72, &[ellipsoid([1.0, 1.0, 0.2])], 60, 2.0)).pulled(10.0);
    vec![
        Case::contact("jam", "60 spheres, rods and ellipsoids pulled into a jam", 40, start),
        Case::contact("jam", "60 discs 1:5 pulled into a jam", 40, discs),
    ]
}

/// Rows of cells, tip to tip and side to side, that all reach their division length together.
fn division() -> Case {
    let length = 2.0 * (-1.5e-3f64).exp();
    let along = glam::DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let at = |i: u32| {
        let position = [2.0 * f64::from(i % 6), 0.5 * f64::from(i / 6), 0.0];
        crate::hard::start::body(rod(0.5, length), position, along)
    };
    let mut start = Start::still(1e-3, (0..36).map(at).collect());
    start.scene.planar = true;
    start.scene.growth = vec![with!(reorientation_degrees: 5.0, ..Growth::new(1.0, 2.0))];
    Case::contact("division", "36 cells, packed, all divide in step 3", 20, start)
}

fn steps() -> Vec<Case> {
    let mixed = [sphere(0.5), rod(0.5, 2.0), ellipsoid([0.4, 0.6, 1.0])];
    let of = |name: &str, dt: f64, shapes: &[_]| {
        Case::contact(
            "dt",
            format!("24 {name}, dt {dt:e}"),
            10,
            Start::still(dt, heap(22, shapes, 24, 2.0)).pulled(1.0),
        )
    };
    let rings = [ring(1.0, 0.2)];
    let mut cases: Vec<Case> = [1e-6, 0.1, 1.0, 10.0].map(|dt| of("spheres, rods and ellipsoids", dt, &mixed)).into();
    cases.extend([1e-6, 1.0].map(|dt| of("rings", dt, &rings)));
    cases
}
