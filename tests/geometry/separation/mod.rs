//! Separations against reference pairs, brute force and finite differences.

mod bounds;
mod hard;
mod invariance;
mod references;
mod ring_and_body;
mod rings;

use crate::directions::{direction, turn};
use crate::{KINDS, random_shape};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, Separation, separation};
use relcp::shape::Shape;

pub fn pair(a: &Placed, b: &Placed) -> Separation {
    separation(a, b, None).unwrap()
}

/// A pair of these kinds in random poses, brought to a random separation, small beside the sizes.
fn random_pair(kinds: [&str; 2], aspect: f64, random: &mut ChaCha8Rng) -> (Placed, Placed) {
    let mut place = |kind| Placed {
        shape: random_shape(kind, aspect, random),
        position: direction(random) * random.random_range(0.0..aspect),
        orientation: turn(random),
    };
    let (a, mut b) = (place(kinds[0]), place(kinds[1]));
    let target = random.random_range(-0.2..0.5);
    for _ in 0..4 {
        let s = pair(&a, &b);
        b.position += s.normal * (target - s.separation);
    }
    (a, b)
}

/// Runs a check on random pairs of all supported kinds, near and far from round.
fn on_random_pairs(count: usize, aspects: &[f64], mut check: impl FnMut(&Placed, &Placed, &mut ChaCha8Rng)) {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for first in KINDS {
        for second in KINDS {
            for &aspect in aspects {
                for _ in 0..count {
                    let (a, b) = random_pair([first, second], aspect, &mut random);
                    check(&a, &b, &mut random);
                }
            }
        }
    }
}

fn size(a: &Placed, b: &Placed) -> f64 {
    a.shape.bounding_radius() + b.shape.bounding_radius() + (b.position - a.position).length()
}

fn is_convex(body: &Placed) -> bool {
    !matches!(body.shape, Shape::Torus { .. })
}

/// Finite, a unit normal, points that agree with the separation along it.
fn check_sound(a: &Placed, b: &Placed, s: &Separation) {
    let gap = b.position - a.position + s.lever_b - s.lever_a;
    assert!(s.separation.is_finite() && gap.is_finite(), "{a:?} {b:?} {s:?}");
    assert!((s.normal.length() - 1.0).abs() < 1e-14, "{a:?} {b:?} {s:?}");
    let off = (s.normal.dot(gap) - s.separation).abs();
    assert!(off < 1e-9 * (1.0 + size(a, b)), "{a:?} {b:?} {s:?} {off:e}");
}

/// Distance from a point to the centreline of a ring or a segment, in closed form.
pub fn to_centreline(body: &Placed, point: DVec3) -> f64 {
    let p = body.orientation.inverse() * (point - body.position);
    match body.shape {
        Shape::Torus { major_radius, .. } => (p.x.hypot(p.y) - major_radius).hypot(p.z),
        Shape::Spherocylinder { diameter, length } => {
            let half = 0.5 * (length - diameter);
            (p - DVec3::Z * p.z.clamp(-half, half)).length()
        }
        _ => p.length(),
    }
}
