//! Bodies that start in each other: concentric, crossed, inside one another.

use super::{TOLERANCE, audited, ellipsoid, figures, going_on, resolves_bodies, ring};
use crate::laws::{body, rod, sphere, start};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, TAU};

#[test]
fn concentric_bodies_part() {
    let shapes = [sphere(0.5), rod(0.5, 2.0), ellipsoid([1.0, 1.0, 2.0]), ellipsoid([0.5, 1.0, 1.5]), ring(1.0, 0.2)];
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.9);
    for shape in &shapes {
        for pose in [DQuat::IDENTITY, turned] {
            let same = body(shape.clone(), [0.3, 0.1, -0.2], pose);
            resolves_bodies(&format!("two of {shape} in one pose"), &[same.clone(), same.clone()], 4);
            resolves_bodies(&format!("three of {shape} in one pose"), &[same.clone(), same.clone(), same.clone()], 4);
            let other = body(shape.clone(), [0.3, 0.1, -0.2], pose * DQuat::from_rotation_x(0.7));
            resolves_bodies(&format!("{shape} about one centre"), &[same, other], 4);
        }
    }
    let all = shapes[..3].iter().map(|s| body(s.clone(), [0.0; 3], DQuat::IDENTITY)).collect::<Vec<_>>();
    resolves_bodies("sphere, rod and ellipsoid about one centre", &all, 4);
}

#[test]
fn rods_whose_axes_meet_part() {
    let thin = || rod(0.2, 2.0);
    let across = DQuat::from_rotation_y(FRAC_PI_2);
    let at = |x: [f64; 3], q| body(thin(), x, q);
    resolves_bodies("crossing at right angles", &[at([0.0; 3], DQuat::IDENTITY), at([0.0; 3], across)], 4);
    resolves_bodies("crossing off centre", &[at([0.0; 3], DQuat::IDENTITY), at([0.3, 0.0, 0.4], across)], 4);
    resolves_bodies(
        "nearly parallel",
        &[at([0.0; 3], DQuat::IDENTITY), at([0.05, 0.0, 0.4], DQuat::from_rotation_x(1e-9))],
        4,
    );
    resolves_bodies("parallel", &[at([0.0; 3], DQuat::IDENTITY), at([0.1, 0.0, 0.0], DQuat::IDENTITY)], 4);
    resolves_bodies("parallel, shifted", &[at([0.0; 3], DQuat::IDENTITY), at([0.1, 0.05, 0.9], DQuat::IDENTITY)], 4);
    resolves_bodies("collinear", &[at([0.0; 3], DQuat::IDENTITY), at([0.0, 0.0, 1.3], DQuat::IDENTITY)], 4);
    resolves_bodies("collinear, tips touch", &[at([0.0; 3], DQuat::IDENTITY), at([0.0, 0.0, 2.0], DQuat::IDENTITY)], 4);
    let star: Vec<Value> = (0..6).map(|i| at([0.0; 3], DQuat::from_rotation_x(f64::from(i) * TAU / 12.0))).collect();
    resolves_bodies("a star of six", &star, 4);
}

#[test]
fn bodies_inside_others_part() {
    let up = DQuat::IDENTITY;
    let inside =
        |big: Value, small: Value, x: [f64; 3]| [body(big, [0.0; 3], up), body(small, x, DQuat::from_rotation_y(0.3))];
    resolves_bodies("sphere in sphere", &inside(sphere(2.0), sphere(0.3), [0.5, 0.2, 0.1]), 4);
    resolves_bodies("sphere in ellipsoid", &inside(ellipsoid([1.0, 2.0, 3.0]), sphere(0.2), [0.1, 0.2, 0.3]), 4);
    resolves_bodies(
        "ellipsoid in ellipsoid",
        &inside(ellipsoid([1.0, 2.0, 3.0]), ellipsoid([0.2, 0.1, 0.3]), [0.1, 0.2, 0.3]),
        4,
    );
    resolves_bodies("rod in ellipsoid", &inside(ellipsoid([1.0, 2.0, 3.0]), rod(0.2, 0.8), [0.1, 0.2, 0.3]), 4);
    resolves_bodies("ellipsoid in sphere", &inside(sphere(2.0), ellipsoid([0.2, 0.1, 0.3]), [0.1, 0.2, 0.3]), 4);
    resolves_bodies("rod in rod", &inside(rod(2.0, 5.0), rod(0.2, 1.0), [0.1, 0.2, 0.3]), 4);
    resolves_bodies(
        "ring in ring, coaxial",
        &[body(ring(1.0, 0.3), [0.0; 3], up), body(ring(1.2, 0.3), [0.0; 3], up)],
        4,
    );
    resolves_bodies("ring in ring, askew", &inside(ring(1.0, 0.3), ring(1.1, 0.3), [0.05, 0.02, 0.01]), 4);
    resolves_bodies(
        "ring on equal ring",
        &[body(ring(1.0, 0.3), [0.0; 3], up), body(ring(1.0, 0.3), [0.0, 0.0, 0.1], up)],
        4,
    );
    resolves_bodies("sphere on a ring's tube", &inside(ring(1.0, 0.3), sphere(0.2), [1.05, 0.0, 0.0]), 4);
    resolves_bodies("small sphere at a ring's centre", &inside(ring(1.0, 0.3), sphere(0.2), [0.0; 3]), 4);
    resolves_bodies("rod through a ring", &inside(ring(1.0, 0.3), rod(0.4, 4.0), [0.0; 3]), 4);
    resolves_bodies("thick rod through a ring", &inside(ring(1.0, 0.3), rod(1.6, 4.0), [0.0; 3]), 4);
    resolves_bodies("rod through a ring's tube", &inside(ring(1.0, 0.3), rod(0.2, 2.0), [1.0, 0.0, 0.0]), 4);
}

/// A ring is not convex: a sphere that fits its hole nowhere is pushed to and fro across it, and the rows of one step,
/// each right at its own trial, have no common solution. Whatever is accepted must be reported as it is.
#[test]
fn a_sphere_too_large_for_the_hole_it_is_in_neither_hangs_the_step_nor_goes_unreported() {
    for x in [[0.0; 3], [0.05, 0.0, 0.0], [0.0, 0.0, 0.05], [0.02, 0.01, 0.1]] {
        let both = [body(ring(1.0, 0.3), [0.0; 3], DQuat::IDENTITY), body(sphere(0.9), x, DQuat::IDENTITY)];
        let mut simulation = start(going_on(1e-2, &both, json!([])));
        let reports = audited(&mut simulation, 8);
        figures(&format!("sphere in a hole, at {x:?}"), &reports);
        println!("{:?} {:?} {:?}", simulation.state().unwrap().bodies.position, reports[0].status, reports[0].residual);
        let last = reports.last().unwrap();
        assert!(last.within(TOLERANCE) || last.recursions == 64 || last.unconverged > 0, "{last:?}");
        let reach = simulation.state().unwrap().bodies.position.iter().map(|x| x.length()).fold(0.0, f64::max);
        assert!(reach < 10.0, "thrown away, to {reach}");
        assert!(reports.iter().all(|r| r.iterations < 10_000), "goes on where there is no solution");
    }
}
