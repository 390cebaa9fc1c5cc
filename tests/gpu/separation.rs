//! Separations on the device against the reference pairs and the CPU's, in both precisions.
//!
//! Errors are fractions of the size of a pair, both bounding radii and the distance of the centres. Separations, and
//! the points along the normal, are held to 2e-6 in 32 bits and to 1e-11 in 64. Points sideways and normals are only as
//! well defined as the surfaces are curved: a point of a disc of aspect 1000 moves by 1000 radii where its normal turns
//! by one radian, and a normal at a tip the other way round.

#![allow(clippy::unwrap_used)]

pub mod harness;
pub mod poses;
pub mod superellipsoids;

use crate::device::{device, precisions};
use crate::directions::direction;
use crate::reference_pairs::reference_pairs;
use glam::DVec3;
use harness::{Errors, LIST, Worst, answers, check_sound, compare, encoded, tolerance};
use poses::Pose;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::gpu::Precision;
use relcp::internals::gpu::{Buffer, Kernel, Source};
use relcp::internals::separation::gpu::{Exponents, PairFamilies};
use relcp::internals::separation::planar_separation;
use relcp::separation::{Placed, Separation, separation};
use std::time::Instant;

#[test]
fn reference_pairs_agree() {
    let Some(gpu) = device() else { return };
    let pairs = reference_pairs();
    let cold: Vec<Pose> = pairs.iter().map(|p| Pose::new(p.a.placed(), p.b.placed())).collect();
    let normals = pairs.iter().map(|p| DVec3::from_array(p.normal));
    let warm: Vec<Pose> = cold.iter().zip(normals).map(|(pose, warm)| Pose { warm, ..*pose }).collect();
    for (precision, (what, poses)) in
        precisions(gpu).into_iter().flat_map(|p| [("cold", &cold), ("warm", &warm)].map(|w| (p, w)))
    {
        let mut worst = Worst::default();
        for ((p, pose), answer) in pairs.iter().zip(poses).zip(answers(gpu, precision, false, poses)) {
            let lever = |body: &Placed, point: Option<[f64; 3]>, found: DVec3| {
                point.map_or(found, |point| DVec3::from_array(point) - body.position)
            };
            let expected = Separation {
                separation: p.separation,
                normal: DVec3::from_array(p.normal),
                lever_a: lever(&pose.a, p.point_a, answer.found.lever_a),
                lever_b: lever(&pose.b, p.point_b, answer.found.lever_b),
            };
            let errors = Errors::of(pose, &answer.found, &expected);
            assert!(errors.separation <= tolerance(precision), "{precision:?} {pose:?} {answer:?} {expected:?}");
            // The rings' reference normals have seven digits.
            let limits = if precision == Precision::F32 { [2e-5, 2e-6] } else { [2e-7, 2e-8] };
            assert!(errors.normal <= limits[0], "{precision:?} {} {pose:?} {answer:?} {}", p.kind, errors.normal);
            assert!(errors.lever <= limits[1], "{precision:?} {} {pose:?} {answer:?} {}", p.kind, errors.lever);
            check_sound(pose, &answer, precision, 100.0);
            worst.add(p.kind.clone(), errors);
        }
        worst.print(what, precision);
    }
}

#[test]
fn pairs_near_contact_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for aspect in [3.0, 20.0, 100.0, 1000.0] {
        compare(
            gpu,
            &format!("near contact, aspect {aspect}"),
            aspect,
            [2e-3, 2e-3],
            &poses::near_contact(600, aspect),
        );
    }
}

#[test]
fn deep_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for aspect in [3.0, 20.0, 100.0, 1000.0] {
        // A ring's circle deep in a slender ellipsoid has almost the same distance to two sides at many places.
        compare(gpu, &format!("deep, aspect {aspect}"), aspect, [2e-2, 2e-2], &poses::deep(800, aspect));
    }
}

#[test]
fn rings_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    compare(gpu, "rings", 100.0, [0.5, 0.35], &poses::rings(3000));
}

#[test]
fn degenerate_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    compare(gpu, "degenerate", 1000.0, [0.2, 0.2], &poses::degenerate());
}

#[test]
fn what_geometry_leaves_open_follows_the_same_rules() {
    let Some(gpu) = device() else { return };
    let (names, poses): (Vec<&str>, Vec<Pose>) = poses::ruled().into_iter().unzip();
    for precision in precisions(gpu) {
        let limit = if precision == Precision::F32 { 1e-5 } else { 1e-10 };
        for ((name, pose), answer) in names.iter().zip(&poses).zip(answers(gpu, precision, false, &poses)) {
            let expected = separation(&pose.a, &pose.b, None).unwrap();
            let errors = Errors::of(pose, &answer.found, &expected);
            assert!(errors.separation <= limit, "{name}: {precision:?} {answer:?} {expected:?}");
            assert!(errors.normal <= limit && errors.lever <= limit, "{name}: {precision:?} {answer:?} {expected:?}");
        }
    }
}

#[test]
fn a_warm_normal_changes_no_more_than_rounding() {
    let Some(gpu) = device() else { return };
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let poses = [poses::near_contact(40, 100.0), poses::deep(40, 20.0)].concat();
    for precision in precisions(gpu) {
        let cold = answers(gpu, precision, false, &poses);
        for round in 0..3 {
            let mut warm = poses.clone();
            for (pose, answer) in warm.iter_mut().zip(&cold) {
                let off = direction(&mut random);
                pose.warm = [answer.found.normal, (answer.found.normal + off * 0.1).normalize(), off][round];
            }
            for ((pose, warm), cold) in warm.iter().zip(answers(gpu, precision, false, &warm)).zip(&cold) {
                let change = (warm.found.separation - cold.found.separation).abs();
                assert!(change <= tolerance(precision) * pose.size(), "{precision:?} {pose:?} {warm:?} {cold:?}");
            }
        }
    }
}

#[test]
fn planar_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for (precision, aspect) in precisions(gpu).into_iter().flat_map(|p| [3.0, 20.0, 100.0].map(|aspect| (p, aspect))) {
        let poses = poses::planar(200, aspect);
        let limit = tolerance(precision);
        let (mut worst, mut better, mut other) = (Worst::default(), 0, 0);
        for (pose, answer) in poses.iter().zip(answers(gpu, precision, true, &poses)) {
            let expected = planar_separation(&pose.a, &pose.b, None).unwrap();
            let mut errors = Errors::of(pose, &answer.found, &expected);
            if pose.is_convex() {
                assert!(answer.found.normal.z == 0.0, "{precision:?} {pose:?} {answer:?}");
                assert!((answer.bound - answer.found.separation).abs() <= limit * pose.size(), "{pose:?} {answer:?}");
                // The CPU's search in the plane places a normal to the root of a rounding.
                let turned = if precision == Precision::F32 { 1e-4 } else { 1e-6 };
                other += usize::from(errors.normal > turned);
                // The CPU samples the angles too; a larger maximum in the plane, which the bound confirms, is the
                // better one.
                if answer.found.separation > expected.separation + limit * pose.size() {
                    (better, errors.separation) = (better + 1, 0.0);
                }
            }
            assert!(errors.separation <= limit, "{precision:?} {pose:?} {answer:?} {expected:?}");
            check_sound(pose, &answer, precision, aspect);
            worst.add(pose.kind(), errors);
        }
        worst.print(&format!("planar, aspect {aspect}"), precision);
        let count = poses.len();
        println!(
            "planar, {}: another normal in {other} of {count}, larger than the CPU's in {better}",
            precision.name()
        );
        assert!(other * 500 <= count && better * 100 <= count);
    }
}

/// Prints the times of the clock; with `MESA_SHADER_CACHE_DISABLE=true` these are the times that a first run takes.
#[test]
fn every_kernel_compiles_and_runs_alone() {
    let Some(gpu) = device() else { return };
    let poses = [poses::near_contact(1, 2.0), superellipsoids::near_contact(4, 2.0)].concat();
    let shapes: Vec<_> = poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape]).collect();
    let exponents = Exponents::of(&shapes);
    for precision in precisions(gpu) {
        for (pair, planar) in PairFamilies::ALL.into_iter().flat_map(|pair| [(pair, false), (pair, true)]) {
            let pose = poses.iter().find(|pose| pose.families() == pair && pose.a.shape.name() == pose.b.shape.name());
            let pose = pose.or(poses.iter().find(|pose| pose.families() == pair)).unwrap();
            let source = exponents.add_to(Source::new(pair.name(), precision));
            let source = pair.add_to(source, planar).text(LIST);
            let begun = Instant::now();
            let kernel = Kernel::new(gpu, &source).unwrap();
            let pairs = Buffer::reals(gpu, "pair", precision, 4, encoded(&exponents, pose)).unwrap();
            let out = Buffer::new(gpu, "separation", 4 * precision.bytes(), 4).unwrap();
            let mut record = gpu.record();
            record.run(&kernel, &[1, 0, 0, 0].map(u32::to_le_bytes).concat(), &[&pairs, &out], 1);
            record.read(&[(&out, 0..16)]).unwrap();
            let seconds = begun.elapsed().as_secs_f64();
            println!("{}, planar {planar}, {}: compiled and run once in {seconds:.2} s", precision.name(), pair.name());
        }
    }
}
