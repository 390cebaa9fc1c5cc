//! The rings of a chainmail.

use relcp::bodies::Bodies;
use relcp::scene::{Generate, Scene};

fn ring_point(bodies: &Bodies, i: usize, angle: f64) -> glam::DVec3 {
    bodies.position[i] + bodies.orientation[i] * glam::DVec3::new(angle.cos(), angle.sin(), 0.0)
}

const RING_SAMPLES: usize = 720;

/// Least distance of two unit circles: samples of one, the nearest point of the other in closed form.
fn circle_distance(bodies: &Bodies, a: usize, b: usize) -> f64 {
    let nearest = |k: usize| {
        let point = ring_point(bodies, a, k as f64 * std::f64::consts::TAU / RING_SAMPLES as f64);
        let local = bodies.orientation[b].inverse() * (point - bodies.position[b]);
        (local.truncate().length() - 1.0).hypot(local.z)
    };
    (0..RING_SAMPLES).map(nearest).fold(f64::INFINITY, f64::min)
}

/// Linking number of two circles by Gauss's integral.
fn linking_number(bodies: &Bodies, a: usize, b: usize) -> f64 {
    const N: usize = 200;
    let h = std::f64::consts::TAU / N as f64;
    let mut sum = 0.0;
    for i in 0..N {
        let (p, dp) = (
            ring_point(bodies, a, i as f64 * h),
            bodies.orientation[a] * glam::DVec3::new(-(i as f64 * h).sin(), (i as f64 * h).cos(), 0.0),
        );
        for j in 0..N {
            let dq = bodies.orientation[b] * glam::DVec3::new(-(j as f64 * h).sin(), (j as f64 * h).cos(), 0.0);
            let r = p - ring_point(bodies, b, j as f64 * h);
            sum += r.dot(dp.cross(dq)) / r.length().powi(3);
        }
    }
    sum * h * h / (4.0 * std::f64::consts::PI)
}

#[test]
fn chainmail_links_each_ring_with_its_four_neighbours_and_nothing_overlaps() {
    let mut scene = Scene::built_in("chainmail").unwrap();
    scene.generate =
        vec![Generate::Chainmail { columns: 4, rows: 3, major_radius: 1.0, minor_radius: 0.1, group: None }];
    let bodies = scene.build().unwrap();
    let mut least = f64::INFINITY;
    for a in 0..12 {
        for b in a + 1..12 {
            least = least.min(circle_distance(&bodies, a, b));
            let lattice = (a % 4).abs_diff(b % 4) + (a / 4).abs_diff(b / 4);
            let linked = linking_number(&bodies, a, b);
            let right = if lattice == 1 { 1.0 } else { 0.0 };
            assert!((linked.abs() - right).abs() < 1e-6, "rings {a} and {b}: {linked}");
        }
    }
    // Sampling is within pi / 720 of an angle, so within 1e-5 of the least distance.
    assert!((least - 0.262742).abs() < 1e-4, "{least}");
    // The thickest tube that the scene accepts leaves a clear gap, the next one is refused.
    assert!(least - 2.0 * 0.12 > 0.02);
    scene.generate =
        vec![Generate::Chainmail { columns: 2, rows: 2, major_radius: 2.0, minor_radius: 0.2401, group: None }];
    assert_eq!(scene.validate().unwrap_err().key(), "generate.0.chainmail.minor_radius");
}
