//! Bodies that `generate` draws: by the seed alone, isotropic, without overlap.

use super::{far_apart, good, isotropic};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::scene::{FaultKind, Generate, Scene};
use relcp::shape::Shape;

#[test]
fn generated_bodies_depend_on_the_seed_alone() {
    let scene = isotropic(300, Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 0.05, false);
    let first = scene.build().unwrap();
    assert_eq!(scene.build().unwrap(), first);
    let mut other = scene;
    other.seed = 2;
    assert_ne!(other.build().unwrap().position, first.position);
    // Pinned, so that a change of the draws does not pass unseen; to 1e-9, since cube roots differ in their last bit
    // between machines.
    let last = glam::DVec3::new(-13.224147808295111, 3.557165555451909, -4.39126367394289);
    assert!(first.position[299].distance(last) < 1e-9);
}

#[test]
fn groups_are_numbered_in_order_of_first_appearance() {
    let mut scene = good();
    scene.generate = vec![Generate::Founder {
        diameter: 0.5,
        length: 2.0,
        position: [0.0; 3],
        angle: 0.0,
        count: 1,
        repeat: Vec::new(),
        group: Some("cell".into()),
    }];
    scene.bodies.push(scene.bodies[0].clone());
    scene.bodies[2].group = None;
    let bodies = scene.build().unwrap();
    assert_eq!(scene.group_names(), ["upper", "lower", "cell"]);
    assert_eq!(bodies.group, [0, 1, NO_GROUP, 2]);
    let axis = bodies.orientation[3] * glam::DVec3::Z;
    assert!((axis - glam::DVec3::X).length() < 1e-15);
    assert_eq!(bodies.lineage.iter().map(|l| l.id).collect::<Vec<_>>(), [0, 1, 2, 3]);
}

/// Least distance of two segments by alternating projection from a grid of starts: independent of the placement's own
/// formula.
fn axes_distance(bodies: &Bodies, a: usize, b: usize, half: f64) -> f64 {
    let along = |i: usize| bodies.orientation[i] * glam::DVec3::Z * half;
    let (u, v, d) = (along(a), along(b), bodies.position[b] - bodies.position[a]);
    let mut least = f64::INFINITY;
    for start in -4..=4 {
        let mut t = f64::from(start) / 4.0;
        for _ in 0..200 {
            let s = ((d + t * v).dot(u) / u.length_squared()).clamp(-1.0, 1.0);
            t = ((s * u - d).dot(v) / v.length_squared()).clamp(-1.0, 1.0);
            least = least.min((d + t * v - s * u).length());
        }
    }
    least
}

#[test]
fn random_bodies_do_not_overlap() {
    let rods = isotropic(150, Shape::Spherocylinder { diameter: 0.5, length: 2.5 }, 0.12, false).build().unwrap();
    far_apart(&rods, |a, b| axes_distance(&rods, a, b, 1.0) >= 0.5 - 1e-12);
    let side = (150.0 * std::f64::consts::PI * (0.25 * 2.0 * 0.25 + 0.125 / 6.0) / 0.12_f64).cbrt();
    assert!(rods.position.iter().all(|p| p.abs().max_element() <= 0.5 * side * (1.0 + 1e-12)));
    let spheres = isotropic(400, Shape::Sphere { radius: 0.5 }, 0.25, false).build().unwrap();
    far_apart(&spheres, |a, b| spheres.position[a].distance(spheres.position[b]) >= 1.0);
    let discs = isotropic(300, Shape::Sphere { radius: 0.5 }, 0.4, true).build().unwrap();
    assert!(discs.position.iter().all(|p| p.z == 0.0));
    far_apart(&discs, |a, b| discs.position[a].distance(discs.position[b]) >= 1.0);
    // An ellipsoid by its support function: some direction must separate each near pair.
    let bodies = isotropic(150, Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }, 0.12, false).build().unwrap();
    far_apart(&bodies, |a, b| separated(&bodies, a, b, glam::DVec3::new(1.0, 1.0, 2.0)));
}

/// Whether some direction of a fine set, improved by ascent, separates two ellipsoids.
fn separated(bodies: &Bodies, a: usize, b: usize, radii: glam::DVec3) -> bool {
    let d = bodies.position[b] - bodies.position[a];
    let support = |i: usize, n: glam::DVec3| (radii * (bodies.orientation[i].inverse() * n)).length();
    let gap = |n: glam::DVec3| n.dot(d) - support(a, n) - support(b, n);
    let mut best = d.normalize();
    for step in [0.3, 0.1, 0.03, 0.01, 0.003, 0.001] {
        for _ in 0..200 {
            if gap(best) > 0.0 {
                return true;
            }
            let moves = [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z]
                .map(|e| [(best + step * e).normalize(), (best - step * e).normalize()]);
            let next = moves.into_iter().flatten().fold(best, |m, n| if gap(n) > gap(m) { n } else { m });
            if next == best {
                break;
            }
            best = next;
        }
    }
    gap(best) > 0.0
}

#[test]
fn rotations_are_isotropic() {
    let bodies = isotropic(4000, Shape::Sphere { radius: 0.1 }, 0.001, false).build().unwrap();
    for body_axis in glam::DVec3::AXES {
        for axis in glam::DVec3::AXES {
            let cosines: Vec<f64> = bodies.orientation.iter().map(|q| (*q * body_axis).dot(axis)).collect();
            let mean = cosines.iter().sum::<f64>() / 4000.0;
            let square = cosines.iter().map(|c| c * c).sum::<f64>() / 4000.0;
            // Five standard errors of a uniform cosine: sqrt(1/3 / 4000) and sqrt(4/45 / 4000).
            assert!(mean.abs() < 5.0 * 0.00913 && (square - 1.0 / 3.0).abs() < 5.0 * 0.00471, "{mean} {square}");
        }
    }
}

#[test]
fn generated_bodies_keep_clear_of_given_ones() {
    let mut scene = isotropic(500, Shape::Sphere { radius: 0.5 }, 0.05, false);
    let big = r#"{"name":"b","time":{"dt":1,"end":1},"bodies":[{"shape":{"sphere":{"radius":4}},"position":[1,0,0]}]}"#;
    scene.bodies = Scene::parse(big, "big").unwrap().bodies;
    let bodies = scene.build().unwrap();
    assert!(bodies.position[1..].iter().all(|p| p.distance(glam::DVec3::X) >= 4.5));
}

#[test]
fn a_full_cube_is_refused_not_waited_for() {
    let mut scene = isotropic(10, Shape::Sphere { radius: 0.5 }, 0.1, false);
    let big =
        r#"{"name":"b","time":{"dt":1,"end":1},"bodies":[{"shape":{"sphere":{"radius":40}},"position":[0,0,0]}]}"#;
    scene.bodies = Scene::parse(big, "big").unwrap().bodies;
    let error = scene.build().unwrap_err();
    assert_eq!((error.kind(), error.key()), (FaultKind::Placement, "generate.0.isotropic.volume_fraction"));
}
