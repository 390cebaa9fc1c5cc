//! Separations in degenerate placements on the CPU, against an oracle that knows no special case.
//!
//! `RELCP_DEGENERATE=10000` draws so many of each kind, and `RELCP_EXAMPLES=1` prints one wrong placement of each kind.

#![allow(clippy::unwrap_used)]

mod oracle;
mod placements;
mod runs;
mod tally;
mod wall_oracle;

use glam::DVec3;
use oracle::{pair_errors, planar_errors, sound};
use placements::{KINDS, SURFACES, at_wall, pair, pairs_of, planar_pair};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::{branches, planar_separation};
use relcp::separation::{Separation, separation};
use relcp::shape::{Convex, Shape};
use tally::{Limits, Tally, draws};
use wall_oracle::{sound_at_wall, wall_errors};

const WITH_CUSTOM: [&str; 6] = ["sphere", "rod", "ellipsoid", "thin", "ring", "custom"];
/// What places of segments are told to, as a fraction of the sizes.
const ROUNDING: f64 = 1e-12;
const LIMITS: Limits = Limits { separation: 1e-9, normal: 1e-9, lever: 1e-9 };

fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// An ellipsoid, a rounded cube and an egg, by their support functions.
fn customs() -> Vec<Shape> {
    let radii = DVec3::new(1.0, 0.6, 2.0);
    let ellipsoid = move |n: DVec3| radii * radii * n / (radii * n).length();
    let needles = |n: DVec3| {
        let s = 0.3;
        let heights = n.to_array().map(|c| c.hypot(s));
        let along = DVec3::from_array([0, 1, 2].map(|i| n[i] / heights[i]));
        0.2 * n + along + n * (s * s * heights.iter().map(|h| 1.0 / h).sum::<f64>())
    };
    let egg = |n: DVec3| {
        let radii = DVec3::new(1.0, 1.0, 1.3);
        let cubic = 0.06 * (3.0 * n.z * n.z * DVec3::Z - 2.0 * n.z.powi(3) * n);
        radii * radii * n / (radii * n).length() + cubic - 0.030510133683 * DVec3::Z
    };
    vec![
        Shape::Convex(Convex::new(ellipsoid).unwrap()),
        Shape::Convex(Convex::new(needles).unwrap()),
        Shape::Convex(Convex::new(egg).unwrap()),
    ]
}

#[test]
fn pairs_in_degenerate_placements_are_those_of_the_oracle() {
    let (customs, mut tally) = (customs(), Tally::default());
    for (i, kinds) in pairs_of(&WITH_CUSTOM).enumerate() {
        let (mut drawn, mut oracle) = (random(10 + i as u64), random(1));
        for _ in 0..draws(150) {
            let bodies = pair(kinds, &customs, &mut drawn);
            let found = separation(&bodies[0], &bodies[1], None).unwrap();
            let errors = pair_errors(&bodies, &found, ROUNDING, &mut oracle);
            tally.add(&kinds.join(", "), errors, &Limits::of(kinds), || format!("{bodies:?}: {found:?}"));
        }
    }
    assert_eq!(tally.print("pairs on the CPU"), []);
}

#[test]
fn superellipsoids_in_degenerate_placements_are_those_of_the_oracle() {
    let (customs, mut tally) = (customs(), Tally::default());
    let others = ["sphere", "rod", "ellipsoid", "thin", "custom", "super", "thin super"];
    let with = |kind| others.map(|other| [other, kind]);
    for (i, kinds) in with("super").into_iter().chain(with("thin super")).enumerate() {
        let (mut drawn, mut oracle) = (random(200 + i as u64), random(1));
        for _ in 0..draws(150) {
            let bodies = pair(kinds, &customs, &mut drawn);
            let found = separation(&bodies[0], &bodies[1], None).unwrap();
            let errors = pair_errors(&bodies, &found, ROUNDING, &mut oracle);
            tally.add(&kinds.join(", "), errors, &Limits::of(kinds), || format!("{bodies:?}: {found:?}"));
        }
    }
    assert_eq!(tally.print("superellipsoids on the CPU"), []);
}

#[test]
fn branches_in_degenerate_placements_are_sound() {
    let mut tally = Tally::default();
    for kinds in [["rod", "rod"], ["ring", "ring"], ["rod", "ring"]] {
        let mut drawn = random(50);
        for _ in 0..draws(600) {
            let bodies = pair(kinds, &[], &mut drawn);
            let nearest = separation(&bodies[0], &bodies[1], None).unwrap();
            let (mut least, mut worst) = (f64::INFINITY, oracle::Errors::default());
            branches(&bodies[0], &bodies[1], &nearest, 1.0, |_, found: Separation| {
                least = least.min(found.separation);
                worst = worst.max(sound(&bodies, &found, false, ROUNDING));
            });
            worst.separation = (least - nearest.separation).abs() / oracle::size(&bodies);
            tally.add(&kinds.join(", "), worst, &Limits::of(kinds), || format!("{bodies:?}: {nearest:?}"));
        }
    }
    assert_eq!(tally.print("branches on the CPU"), []);
}

#[test]
fn planar_pairs_in_degenerate_placements_are_those_of_the_oracle() {
    let mut tally = Tally::default();
    // The search in the plane places a normal to the root of a rounding, and samples bodies up to aspect ratio 20.
    let limits = Limits { normal: 2e-3, ..LIMITS };
    let with_super = ["sphere", "rod", "ellipsoid", "super"].map(|other| [other, "super"]);
    for (i, kinds) in pairs_of(&["sphere", "rod", "ellipsoid"]).chain(with_super).enumerate() {
        let mut drawn = random(80 + i as u64);
        for _ in 0..draws(200) {
            let bodies = planar_pair(kinds, &mut drawn);
            let found = planar_separation(&bodies[0], &bodies[1], None).unwrap();
            let errors = planar_errors(&bodies, &found);
            tally.add(&kinds.join(", "), errors, &limits, || format!("{bodies:?}: {found:?}"));
        }
    }
    assert_eq!(tally.print("pairs in the plane on the CPU"), []);
}

#[test]
fn bodies_at_walls_in_degenerate_placements_are_those_of_the_oracle() {
    let (customs, mut tally) = (customs(), Tally::default());
    let kinds = KINDS.into_iter().chain(["custom", "super", "thin super"]);
    for (i, (kind, wall)) in kinds.flat_map(|kind| SURFACES.map(|wall| (kind, wall))).enumerate() {
        let (mut drawn, mut oracle) = (random(100 + i as u64), random(1));
        for _ in 0..draws(200) {
            let (body, surface) = at_wall(kind, wall, &customs, &mut drawn);
            let found = surface.separation(&body);
            let mut errors = wall_errors(&body, &surface, &found, &mut oracle);
            surface.places(&body, |_, place| errors = errors.max(sound_at_wall(&body, &surface, &place)));
            tally.add(&format!("{kind}, {wall}"), errors, &LIMITS, || format!("{body:?} {surface:?}: {found:?}"));
        }
    }
    assert_eq!(tally.print("walls on the CPU"), []);
}
