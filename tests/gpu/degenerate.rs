//! Separations in degenerate placements on the device, in both precisions, against the oracle of `tests/degenerate`.
//!
//! `RELCP_DEGENERATE=10000` draws so many of each kind, and `RELCP_EXAMPLES=1` prints one wrong placement of each kind.

#[path = "../degenerate/oracle.rs"]
mod oracle;
#[path = "../degenerate/placements.rs"]
mod placements;
#[path = "../degenerate/tally.rs"]
mod tally;
#[path = "../degenerate/wall_oracle.rs"]
mod wall_oracle;

use crate::device::{device, precisions};
use crate::separation::harness::{answers, compare};
use crate::separation::poses::Pose;
use crate::walls::separation as at_walls;
use glam::{DQuat, DVec3};
use oracle::{Errors, pair_errors, planar_errors};
use placements::{KINDS, SURFACES, at_wall, pair, pairs_of, planar_pair};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::gpu::Precision;
use relcp::internals::gpu::Lattice;
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use tally::{Limits, Tally, draws};
use wall_oracle::{sound_at_wall, wall_errors};

/// In 32 bits two ellipsoids deep in each other know their points to the root of a rounding where all normals round about
/// are nearly as good, and thin ones anywhere.
fn limits(precision: Precision, kinds: [&str; 2]) -> Limits {
    let is_vague = kinds.contains(&"thin") || kinds == ["ellipsoid"; 2];
    match precision {
        Precision::F32 => Limits { separation: 2e-6, normal: 1e-3, lever: if is_vague { 1e-3 } else { 4e-6 } },
        Precision::F64 => Limits::of(kinds),
    }
}

fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

#[test]
fn pairs_in_degenerate_placements_are_those_of_the_oracle() {
    let Some(gpu) = device() else { return };
    let mut wrong = Vec::new();
    for precision in precisions(gpu) {
        let mut tally = Tally::default();
        for (i, kinds) in pairs_of(&KINDS).enumerate() {
            let (mut drawn, mut oracle) = (random(10 + i as u64), random(1));
            let poses: Vec<Pose> = (0..draws(150)).map(|_| pair(kinds, &[], &mut drawn)).map(Pose::of).collect();
            for (pose, answer) in poses.iter().zip(answers(gpu, precision, false, &poses)) {
                let rounding = if precision == Precision::F32 { 2e-6 } else { 1e-12 };
                let errors = pair_errors(&[pose.a, pose.b], &answer.found, rounding, &mut oracle);
                let limits = limits(precision, kinds);
                tally.add(&kinds.join(", "), errors, &limits, || format!("{pose:?}: {answer:?}"));
            }
        }
        let found = tally.print(&format!("pairs on the device, {}", precision.name()));
        wrong.extend(found.into_iter().map(|(kind, count)| (precision, kind.to_owned(), count)));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn pairs_in_degenerate_placements_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    let kinds = pairs_of(&["sphere", "rod", "ellipsoid", "ring"]).filter(|kinds| *kinds != ["ellipsoid"; 2]);
    for (i, kinds) in kinds.enumerate() {
        let mut drawn = random(10 + i as u64);
        let poses: Vec<Pose> = (0..draws(150)).map(|_| pair(kinds, &[], &mut drawn)).map(Pose::of).collect();
        // Normals and places are often not unique, and 32 bits do not see the smaller offsets.
        compare(gpu, &kinds.join(", "), 1000.0, [1.0, 1.0], &poses);
    }
}

#[test]
fn planar_pairs_in_degenerate_placements_are_those_of_the_oracle() {
    let Some(gpu) = device() else { return };
    let mut wrong = Vec::new();
    for precision in precisions(gpu) {
        let mut tally = Tally::default();
        for (i, kinds) in pairs_of(&["sphere", "rod", "ellipsoid"]).enumerate() {
            let mut drawn = random(80 + i as u64);
            let poses: Vec<Pose> = (0..draws(200)).map(|_| planar_pair(kinds, &mut drawn)).map(Pose::of).collect();
            for (pose, answer) in poses.iter().zip(answers(gpu, precision, true, &poses)) {
                let errors = planar_errors(&[pose.a, pose.b], &answer.found);
                // Levers are not laid into the plane with a normal that leans out of it by up to 1e-3.
                let limits = Limits { normal: 2e-3, lever: 4e-6, ..limits(precision, kinds) };
                tally.add(&kinds.join(", "), errors, &limits, || format!("{pose:?}: {answer:?}"));
            }
        }
        let found = tally.print(&format!("pairs in the plane on the device, {}", precision.name()));
        wrong.extend(found.into_iter().map(|(kind, count)| (precision, kind.to_owned(), count)));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn rods_as_long_as_thick_with_one_centre_overlap_in_the_plane_by_what_they_are_thick() {
    let Some(gpu) = device() else { return };
    let rod = Shape::Spherocylinder { diameter: 1.0, length: 1.0 };
    let lying = DQuat::from_rotation_y(FRAC_PI_2);
    let at_origin = |shape| Placed { shape, position: DVec3::ZERO, orientation: lying };
    let poses = [rod, Shape::Sphere { radius: 0.75 }].map(|other| Pose::of([at_origin(rod), at_origin(other)]));
    for precision in precisions(gpu) {
        for (answer, thick) in answers(gpu, precision, true, &poses).iter().zip([1.0, 1.25]) {
            assert!((answer.found.separation + thick).abs() < 1e-6, "{answer:?}");
        }
    }
}

/// Across the rod the ball's shadow is a circle but for 1e-22, whose square 32 bits do not hold.
#[test]
fn a_rod_through_a_ball_nearly_at_its_centre_overlaps_by_both_radii() {
    let Some(gpu) = device() else { return };
    let radius = 2.446769951296517;
    let rod = Placed {
        shape: Shape::Spherocylinder { diameter: 1.0, length: 6.250748307036453 },
        position: DVec3::ZERO,
        orientation: DQuat::from_rotation_y(FRAC_PI_2),
    };
    let ball = Placed {
        shape: Shape::Ellipsoid { radii: [radius; 3] },
        position: DVec3::new(0.45199962920303366, -5.149917760636604e-8, 0.0),
        orientation: DQuat::from_xyzw(-3.535533905932737e-17, FRAC_1_SQRT_2, 3.535533905932738e-17, FRAC_1_SQRT_2),
    };
    let poses = [Pose::of([rod, ball]), Pose::of([ball, rod])];
    for precision in precisions(gpu) {
        for planar in [false, true] {
            for answer in answers(gpu, precision, planar, &poses) {
                assert!((answer.found.separation + 0.5 + radius).abs() < 1e-6, "{planar} {answer:?}");
            }
        }
    }
}

#[test]
fn bodies_at_walls_in_degenerate_placements_are_those_of_the_oracle() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let mut wrong = Vec::new();
    for precision in precisions(gpu) {
        let mut tally = Tally::default();
        for (i, (kind, wall)) in KINDS.into_iter().flat_map(|kind| SURFACES.map(|wall| (kind, wall))).enumerate() {
            let (mut drawn, mut oracle) = (random(100 + i as u64), random(1));
            let draw = |_| {
                let (body, surface) = at_wall(kind, wall, &[], &mut drawn);
                at_walls::Pose { surface, body }
            };
            let poses: Vec<at_walls::Pose> = (0..draws(200)).map(draw).collect();
            for (pose, answer) in poses.iter().zip(at_walls::answers(gpu, precision, &lattice, &poses)) {
                let at_walls::Pose { surface, body } = pose;
                let mut errors = wall_errors(body, surface, answer.least(), &mut oracle);
                let sound = |errors: Errors, place| errors.max(sound_at_wall(body, surface, place));
                errors = answer.places.iter().fold(errors, sound);
                let limits = limits(precision, [kind; 2]);
                tally.add(&format!("{kind}, {wall}"), errors, &limits, || format!("{pose:?}: {:?}", answer.places));
            }
        }
        let found = tally.print(&format!("walls on the device, {}", precision.name()));
        wrong.extend(found.into_iter().map(|(kind, count)| (precision, kind.to_owned(), count)));
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
