//! Separations per second of every pair of families, with one thread, on pairs in contact range: without a start, and
//! from the normal of a slightly earlier pose. Also measures the bound that avoids a separation.

#![allow(missing_docs)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, bound, separation};
use relcp::shape::Shape;
use std::hint::black_box;

/// Number of pairs that a measurement cycles through: more than branch prediction learns, fewer than the cache holds.
const PAIRS: usize = 512;

type Warmed = (Placed, Placed, DVec3);

fn turn(random: &mut ChaCha8Rng) -> DQuat {
    let v: [f64; 4] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
    DQuat::from_vec4(DVec4::from_array(v).normalize())
}

/// Random pairs of these shapes, gaps from -5 % to 20 % of the thickness, with the normal of a pose 0.01 radians off.
fn pairs(first: Shape, second: Shape) -> Vec<Warmed> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let thickness = first.thickness().min(second.thickness());
    std::iter::repeat_with(|| {
        let a = Placed { shape: first, position: DVec3::ZERO, orientation: turn(&mut random) };
        let reach = first.bounding_radius() + second.bounding_radius();
        let place = turn(&mut random) * DVec3::Z * reach;
        let mut b = Placed { shape: second, position: place, orientation: turn(&mut random) };
        let gap = thickness * random.random_range(-0.05..0.2);
        for _ in 0..4 {
            let s = separation(&a, &b, None)?;
            b.position += s.normal * (gap - s.separation);
        }
        let tilt = turn(&mut random) * DVec3::Z * 0.01;
        let before = Placed { orientation: DQuat::from_scaled_axis(tilt) * b.orientation, ..b };
        Some((a, b, separation(&a, &before, None)?.normal))
    })
    .take(PAIRS)
    .flatten()
    .collect()
}

fn separations(criterion: &mut Criterion) {
    let sphere = Shape::Sphere { radius: 0.5 };
    let rod = Shape::Spherocylinder { diameter: 0.5, length: 3.0 };
    let ellipsoid = Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] };
    let slender = Shape::Ellipsoid { radii: [1.0, 1.0, 20.0] };
    let flat = Shape::Ellipsoid { radii: [1.0, 1.0, 0.05] };
    let ring = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    let kinds = [
        ("sphere-sphere", sphere, sphere),
        ("rod-sphere", rod, sphere),
        ("rod-rod", rod, rod),
        ("ellipsoid-sphere", ellipsoid, sphere),
        ("ellipsoid-rod", ellipsoid, rod),
        ("ellipsoid-ellipsoid", ellipsoid, ellipsoid),
        ("slender-slender", slender, slender),
        ("flat-flat", flat, flat),
        ("ring-sphere", ring, sphere),
        ("ring-rod", ring, rod),
        ("ring-ring", ring, ring),
    ];
    for (name, first, second) in kinds {
        let pairs = pairs(first, second);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(pairs.len() as u64));
        let mut measure = |how: &str, one: &dyn Fn(&Warmed) -> f64| {
            group.bench_function(how, |bencher| bencher.iter(|| pairs.iter().map(|p| one(black_box(p))).sum::<f64>()));
        };
        measure("cold", &|(a, b, _)| separation(a, b, None).map_or(0.0, |s| s.separation));
        measure("warm", &|(a, b, n)| separation(a, b, Some(*n)).map_or(0.0, |s| s.separation));
        measure("bound", &|(a, b, n)| bound(a, b, *n));
    }
}

criterion_group!(benches, separations);
criterion_main!(benches);
