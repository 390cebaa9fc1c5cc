//! Superellipsoids: sizes against sampled ones, exponent 2 against ellipsoids, separations against a search over
//! normals with a support function of its own.

mod runs;
mod sizes;
mod walls;

use crate::bodies::{placed, random};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::Scene;
use relcp::separation::{Placed, Separation, separation};
use relcp::shape::{Convex, Shape, ShapeError, Superellipsoid};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Poses of each kind; `RELCP_POSES=N` for more.
fn poses() -> usize {
    std::env::var("RELCP_POSES").ok().and_then(|n| n.parse().ok()).unwrap_or(60)
}

fn superellipsoid(radii: [f64; 3], exponents: [f64; 2]) -> Shape {
    let shape = Shape::Superellipsoid(Superellipsoid::new(radii, exponents));
    assert_eq!(shape.validate(), Ok(()));
    shape
}

/// The support function, written as the dual norm.
fn reach(shape: &Shape, n: DVec3) -> f64 {
    match *shape {
        Shape::Superellipsoid(of) => {
            let ([a, b, c], [n1, n2]) = (of.radii(), of.exponents());
            let (m1, m2) = (n1 / (n1 - 1.0), n2 / (n2 - 1.0));
            let [x, y, z] = [a * n.x, b * n.y, c * n.z].map(f64::abs);
            ((x.powf(m2) + y.powf(m2)).powf(m1 / m2) + z.powf(m1)).powf(1.0 / m1)
        }
        Shape::Ellipsoid { radii } => (DVec3::from_array(radii) * n).length(),
        Shape::Sphere { radius } => radius,
        Shape::Spherocylinder { diameter, length } => 0.5 * (length - diameter) * n.z.abs() + 0.5 * diameter,
        _ => unreachable!(),
    }
}

fn height(a: &Placed, b: &Placed, n: DVec3) -> f64 {
    let of = |body: &Placed, n: DVec3| reach(&body.shape, body.orientation.inverse() * n);
    n.dot(b.position - a.position) - of(a, n) - of(b, -n)
}

/// The largest height over all normals: the best of many, each improved by steps around it that become shorter.
fn highest(a: &Placed, b: &Placed) -> f64 {
    const ACROSS: i32 = 12;
    let mut grid = Vec::new();
    for face in 0..6 {
        for (i, j) in (0..=ACROSS).flat_map(|i| (0..=ACROSS).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|k| f64::from(2 * k - ACROSS) / f64::from(ACROSS));
            let side = if face % 2 == 0 { 1.0 } else { -1.0 };
            let normal = [DVec3::new(side, u, v), DVec3::new(u, side, v), DVec3::new(u, v, side)][face / 2].normalize();
            grid.push((height(a, b, normal), normal));
        }
    }
    grid.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best = f64::NEG_INFINITY;
    for (mut value, mut normal) in grid.into_iter().take(6) {
        let mut step = 0.2;
        for _ in 0..300 {
            let (e1, e2) = normal.any_orthonormal_pair();
            let tried = [e1, -e1, e2, -e2, e1 + e2, e1 - e2, -e1 + e2, -e1 - e2].map(|way| {
                let there = (normal + way * step).normalize();
                (height(a, b, there), there)
            });
            let there = tried.into_iter().reduce(|x, y| if y.0 > x.0 { y } else { x }).unwrap();
            if there.0 > value {
                (value, normal) = there
            } else {
                step *= 0.5
            }
            if step < 1e-13 {
                break;
            }
        }
        best = best.max(value);
    }
    best
}

fn pair(a: &Placed, b: &Placed) -> Separation {
    separation(a, b, None).unwrap()
}

/// By how much the separation is less than the highest height, and differs from the height at its own normal, and how
/// far the points found are from each other along and across it, all as parts of the size.
fn errors(a: &Placed, b: &Placed) -> [f64; 3] {
    let found = pair(a, b);
    let size = a.shape.bounding_radius() + b.shape.bounding_radius();
    assert!((found.normal.length() - 1.0).abs() < 1e-14 && found.lever_a.is_finite() && found.lever_b.is_finite());
    let own = (height(a, b, found.normal) - found.separation).abs();
    let gap = b.position - a.position + found.lever_b - found.lever_a;
    let apart = (gap - found.normal * found.separation).length();
    [(highest(a, b) - found.separation).max(0.0) / size, own / size, apart / size]
}

fn others(k: usize, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || 2f64.powf(random.random_range(-1.0..1.0));
    match k % 5 {
        0 => Shape::Sphere { radius: 0.5 * ratio() },
        1 => Shape::Spherocylinder { diameter: 0.5, length: 1.0 + ratio() },
        2 => Shape::Ellipsoid { radii: [ratio(), ratio(), ratio()] },
        _ => superellipsoid(
            [ratio(), ratio(), ratio()],
            [[2.5, 4.0, 8.0, 10.0][k % 4], [8.0, 4.0, 2.5, 2.0][(k / 4) % 4]],
        ),
    }
}

#[test]
fn random_pairs_are_as_far_apart_as_a_search_over_normals_says() {
    let random = &mut random(61);
    for exponents in [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [2.0, 8.0], [10.0, 2.5]] {
        let mut worst = [0.0_f64; 3];
        for k in 0..poses() {
            let mut ratio = || 2f64.powf(random.random_range(-1.0..1.0));
            let a = placed(superellipsoid([ratio(), ratio(), ratio()], exponents), DVec3::ZERO, turn(random));
            let mut b = placed(others(k, random), direction(random) * 3.0, turn(random));
            let target = random.random_range(-0.3..0.5) * a.shape.thickness().min(b.shape.thickness());
            for _ in 0..3 {
                let found = pair(&a, &b);
                b.position += found.normal * (target - found.separation);
            }
            let found = errors(&a, &b);
            assert!(found.iter().all(|error| *error < 1e-11), "{found:?} {a:?} {b:?} {:?}", pair(&a, &b));
            worst = [0, 1, 2].map(|i| worst[i].max(found[i]));
        }
        eprintln!("random, exponents {exponents:?}: {worst:?}");
    }
}

/// Faces on faces, edges on edges, corners, concentric, with tilts and displacements from nothing to a tenth.
#[test]
fn degenerate_pairs_are_as_far_apart_as_a_search_over_normals_says() {
    let random = &mut random(62);
    for exponents in [[2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2]] {
        let mut worst = [0.0_f64; 3];
        for k in 0..poses() {
            let radii = [[1.0; 3], [1.0, 1.0, 2.0], [0.3, 1.0, 2.0]][k % 3];
            let shape = superellipsoid(radii, exponents);
            let other = match (k / 3) % 3 {
                0 => shape,
                1 => Shape::Sphere { radius: 1.0 },
                _ => Shape::Spherocylinder { diameter: 0.4, length: 2.0 },
            };
            let little = |random: &mut ChaCha8Rng| match random.random_range(0..4) {
                0 => DVec3::ZERO,
                1 => direction(random) * 1e-300,
                _ => direction(random) * 10f64.powf(random.random_range(-16.0..-1.0)),
            };
            let turns = [
                DQuat::IDENTITY,
                DQuat::from_rotation_z(FRAC_PI_4),
                DQuat::from_rotation_x(FRAC_PI_2),
                DQuat::from_rotation_x(FRAC_PI_4) * DQuat::from_rotation_z(FRAC_PI_4),
            ];
            let way = [DVec3::X, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE][(k / 9) % 4];
            let far = [0.0, 0.3, 2.0 * radii[0], 2.0 * radii[0] + 1e-3, 3.0][(k / 36) % 5];
            let a = placed(shape, DVec3::ZERO, turns[k % 4]);
            let tilt = DQuat::from_scaled_axis(little(random));
            let b = placed(other, way * far + little(random), tilt * turns[(k / 4) % 4]);
            let found = errors(&a, &b);
            assert!(found.iter().all(|error| *error < 1e-11), "{found:?} {a:?} {b:?} {:?}", pair(&a, &b));
            worst = [0, 1, 2].map(|i| worst[i].max(found[i]));
        }
        eprintln!("degenerate, exponents {exponents:?}: {worst:?}");
    }
}

/// A rod along an edge, tilted by 4e-4, where steps of the search went back and forth.
#[test]
fn a_rod_nearly_along_a_flat_edge_is_found() {
    let [edge, along] = [
        [0.3535533905932738, -0.14644660940672624, 0.3535533905932738, 0.8535533905932737],
        [0.00010342634535255152, -0.00017685554629770883, 4.850600518865489e-5, 0.9999999778361369],
    ]
    .map(DQuat::from_array);
    let body = placed(superellipsoid([1.0, 1.0, 2.0], [4.0; 2]), DVec3::ZERO, edge);
    let rod = Shape::Spherocylinder { diameter: 0.4, length: 2.0 };
    let at = DVec3::new(2.000755221078565, 0.0003253216204234652, 6.981849748720311e-5);
    let found = errors(&body, &placed(rod, at, along));
    assert!(found.iter().all(|error| *error < 1e-12), "{found:?}");
}

/// Two concentric dice whose least depth is across an edge of each.
#[test]
fn the_depth_across_edges_of_concentric_bodies_is_found() {
    let turns = [
        [0.3535533905932738, -0.14644660940672624, 0.3535533905932738, 0.8535533905932737],
        [7.36566367348896e-5, -0.000400531746442447, 0.3825429361586394, 0.9239376256783501],
    ];
    let die = superellipsoid([1.0; 3], [8.0; 2]);
    let [a, b] = turns.map(|turn| placed(die, DVec3::ZERO, DQuat::from_array(turn)));
    let found = errors(&a, &b);
    assert!(found.iter().all(|error| *error < 1e-12), "{found:?}");
}

/// Of exponent 2 it is the ellipsoid: sizes and separations from everything, to rounding.
#[test]
fn with_exponents_of_two_it_is_the_ellipsoid() {
    let random = &mut random(63);
    for k in 0..10 * poses() {
        let mut ratio = || 3f64.powf(random.random_range(-1.0..1.0));
        let radii = [ratio(), ratio(), ratio()];
        let (own, twin) = (superellipsoid(radii, [2.0; 2]), Shape::Ellipsoid { radii });
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        assert!(same(own.volume(), twin.volume()) && same(own.bounding_radius(), twin.bounding_radius()));
        assert!(same(own.thickness(), twin.thickness()) && same(own.major_axis(), twin.major_axis()));
        assert!((own.unit_inertia() - twin.unit_inertia()).abs().max_element() < 1e-12 * twin.unit_inertia().length());
        let q = turn(random);
        assert!((own.half_extents(q) - twin.half_extents(q)).abs().max_element() < 1e-14 * own.bounding_radius());
        let a = placed(own, DVec3::ZERO, q);
        let ring = Shape::Torus { major_radius: 1.0 + 0.5 * radii[0], minor_radius: 0.2 };
        let other = if k % 6 == 5 { ring } else { others(k, random) };
        let b = placed(other, direction(random) * random.random_range(0.8..4.0), turn(random));
        let (found, expected) = (pair(&a, &b), pair(&Placed { shape: twin, ..a }, &b));
        let size = own.bounding_radius() + b.shape.bounding_radius();
        assert!((found.separation - expected.separation).abs() < 1e-12 * size, "{a:?} {b:?} {found:?} {expected:?}");
        if expected.separation > 0.0 && k % 6 != 5 {
            assert!(found.normal.abs_diff_eq(expected.normal, 1e-7), "{a:?} {b:?} {found:?} {expected:?}");
        }
    }
}

/// Rings, whose distance is a search along them, are no farther than any ball of their tubes: anywhere, or concentric,
/// coaxial, flat on a face, with an edge through the hole, off by nothing or a little.
#[test]
fn rings_are_nearest_where_balls_along_them_are() {
    let random = &mut random(64);
    let mut worst = [0.0_f64; 3];
    for k in 0..2 * poses() {
        let exponents = [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [10.0, 2.5]][k % 6];
        let radii = [[1.0, 0.8, 1.4], [1.0; 3], [0.2, 1.0, 2.0]][k / 6 % 3];
        let turned = turn(random);
        let body = placed(superellipsoid(radii, exponents), DVec3::ZERO, turned);
        let major_radius = random.random_range(0.5..3.0);
        let torus = Shape::Torus { major_radius, minor_radius: 0.1 };
        let tilt = DQuat::from_scaled_axis(direction(random) * [0.0, 1e-12, 1e-6, 1e-2][random.random_range(0..4)]);
        let upright = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_4)];
        let place = [DVec3::ZERO, DVec3::Z, DVec3::Z * (radii[2] + 0.1), DVec3::X * major_radius][k / 2 % 4];
        let ring = match k % 2 {
            0 => placed(torus, direction(random) * random.random_range(0.0..major_radius + 1.0), turn(random)),
            _ => placed(torus, turned * (tilt * place), (turned * tilt * upright[k / 8 % 3]).normalize()),
        };
        let found = pair(&ring, &body);
        let ball = |k: i32| {
            let angle = f64::from(k) * std::f64::consts::TAU / 1000.0;
            let at = ring.position + ring.orientation * DVec3::new(angle.cos(), angle.sin(), 0.0) * major_radius;
            pair(&placed(Shape::Sphere { radius: 0.1 }, at, DQuat::IDENTITY), &body).separation
        };
        let least = (0..1000).map(ball).fold(f64::INFINITY, f64::min);
        let size = major_radius + body.shape.bounding_radius();
        let apart =
            (body.position - ring.position + found.lever_b - found.lever_a - found.normal * found.separation).length();
        worst[0] = worst[0].max((found.separation - least) / size);
        worst[1] = worst[1].max(apart / size);
        assert!(found.separation <= least + 1e-11 && apart < 1e-7, "{found:?} {least} {apart:e} {ring:?} {body:?}");
        // The point found is the ring's, and as far from the body as a ball there.
        let centre = found.lever_a - found.normal * 0.1;
        let there = placed(Shape::Sphere { radius: 0.1 }, ring.position + centre, DQuat::IDENTITY);
        worst[2] = worst[2].max((pair(&there, &body).separation - found.separation).abs() / size);
        assert!((pair(&there, &body).separation - found.separation).abs() < 1e-12, "{found:?} {ring:?} {body:?}");
        let centre = ring.orientation.inverse() * centre;
        assert!((centre.truncate().length() - major_radius).hypot(centre.z) < 1e-12, "{found:?} {ring:?}");
    }
    eprintln!("rings: {worst:?}");
}

/// Volume and inertia by beta functions, against those of the polyhedron of the same points; the farthest point against
/// the farthest of many.
#[test]
fn sizes_are_those_that_points_have() {
    for (radii, exponents) in
        [([1.0; 3], [2.5; 2]), ([0.5, 1.0, 2.0], [4.0, 3.0]), ([1.0, 2.0, 0.7], [3.0, 2.0]), ([1.0; 3], [2.0, 3.0])]
    {
        let shape = superellipsoid(radii, exponents);
        let (n1, n2) = (exponents[0], exponents[1]);
        let (m1, m2) = (n1 / (n1 - 1.0), n2 / (n2 - 1.0));
        let point = move |n: DVec3| {
            let v = DVec3::from_array(radii) * n.abs();
            let across = (v.x.powf(m2) + v.y.powf(m2)).powf(1.0 / m2);
            let height = (across.powf(m1) + v.z.powf(m1)).powf(1.0 / m1);
            let part = |x: f64| if across > 0.0 { (x / across).powf(m2 - 1.0) } else { 0.0 };
            let out = (across / height).powf(m1 - 1.0);
            DVec3::from_array(radii)
                * DVec3::new(out * part(v.x), out * part(v.y), (v.z / height).powf(m1 - 1.0))
                * n.signum()
        };
        let sampled = Shape::Convex(Convex::new(point).unwrap());
        let ratio = shape.volume() / sampled.volume();
        assert!((ratio - 1.0).abs() < 1e-3, "{radii:?} {exponents:?} {ratio}");
        let inertia = shape.unit_inertia() / sampled.unit_inertia();
        assert!((inertia - 1.0).abs().max_element() < 2e-3, "{radii:?} {exponents:?} {inertia}");
        assert!((shape.bounding_radius() / sampled.bounding_radius() - 1.0).abs() < 1e-12, "{radii:?} {exponents:?}");
        assert!((shape.thickness() / sampled.thickness() - 1.0).abs() < 1e-3, "{radii:?} {exponents:?}");
    }
    // 8 Gamma(5/4)^3 / Gamma(7/4).
    let cube = superellipsoid([1.0; 3], [4.0, 4.0]);
    assert!((cube.volume() - 6.481_987_351_786_385).abs() < 1e-9, "{}", cube.volume());
}

#[test]
fn exponents_that_are_no_smooth_convex_bodies_are_refused() {
    for (exponents, name) in [([0.8, 2.0], "exponents.0"), ([2.0, 1.5], "exponents.1"), ([2.0, 11.0], "exponents.1")] {
        let shape = Shape::Superellipsoid(Superellipsoid::new([1.0; 3], exponents));
        let refused = shape.validate();
        assert!(matches!(refused, Err(ShapeError::Exponent { name: of, .. }) if of == name), "{refused:?}");
    }
    for radii in [[0.0, 1.0, 1.0], [1.0, f64::NAN, 1.0], [1.0, 1.0, 2000.0], [-1.0, 1.0, 1.0]] {
        assert!(Shape::Superellipsoid(Superellipsoid::new(radii, [4.0; 2])).validate().is_err());
    }
}

fn text(exponents: &str) -> String {
    format!(
        r#"{{"name": "two", "time": {{"dt": 0.02, "end": 1.5}}, "forces": [{{"radial_inward": {{}}}}], "bodies": [
        {{"shape": {{"superellipsoid": {{"radii": [0.4, 0.5, 0.6], "exponents": {exponents}}}}}, "position": [0.1, 0, -0.7]}},
        {{"shape": {{"torus": {{"major_radius": 0.6, "minor_radius": 0.2}}}}, "position": [0.2, 0, 0]}},
        {{"shape": {{"superellipsoid": {{"radii": [0.3, 0.3, 0.3], "exponents": [4, 4]}}}}, "position": [0, 0.1, 0.8]}}]}}"#
    )
}

#[test]
fn a_scene_with_other_exponents_is_refused_at_its_key() {
    for (exponents, key) in [("[0.8, 2]", "exponents.0"), ("[2, 1.5]", "exponents.1"), ("[2, 30]", "exponents.1")] {
        let refused = Scene::parse(&text(exponents), "two").and_then(|scene| scene.validate()).unwrap_err();
        assert!(refused.key().ends_with(key), "{refused}");
        assert!(refused.to_string().contains("below 1 the body is not convex"), "{refused}");
    }
}
