//! Shapes: proxies, volumes and inertias, boxes, mirrors and refusals.

use crate::directions::turn;
use crate::separation::{pair, to_centreline};
use crate::{KINDS, random_shape};
use glam::{DQuat, DVec3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, bound};
use relcp::shape::{MAX_ASPECT, ProxyError, Shape, ShapeError};
use std::f64::consts::FRAC_PI_2;

#[test]
fn proxies_are_inside_tangent_and_reach_the_tips() {
    for (radii, count) in [([1.0, 1.0, 2.0], 3), ([1.0, 2.35, 1.0], 13), ([20.0, 1.0, 1.0], 27), ([1.0, 1.5, 3.0], 7)] {
        let shape = Shape::Ellipsoid { radii };
        let proxy = shape.proxy(count).unwrap();
        assert_eq!(proxy.len(), count);
        let largest = DVec3::from_array(radii);
        let major = largest.max_element();
        let mirrored = |i: usize| (proxy[i].centre + proxy[count - 1 - i].centre).length();
        assert!((0..count).all(|i| mirrored(i) < 1e-14 && proxy[i].radius == proxy[count - 1 - i].radius));
        assert!((proxy[count - 1].centre.length() + proxy[count - 1].radius - major).abs() < 1e-14 * major);
        assert!((proxy[count / 2].radius - largest.min_element()).abs() < 1e-15);
        let body = Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
        for sphere in &proxy {
            let centre = Shape::Sphere { radius: 1e-3 };
            let at = Placed { shape: centre, position: sphere.centre, orientation: DQuat::IDENTITY };
            let depth = -(pair(&body, &at).separation + 1e-3);
            assert!((depth - sphere.radius).abs() < 1e-13 * major, "{radii:?} {depth} {sphere:?}");
        }
        let grooves: Vec<f64> = proxy
            .windows(2)
            .map(|w| {
                let halfway = 0.5 * (w[0].centre + w[1].centre);
                let at = Placed { shape: Shape::Sphere { radius: 1e-3 }, position: halfway, ..body };
                (w[1].centre - w[0].centre).length_squared() / -(pair(&body, &at).separation + 1e-3)
            })
            .collect();
        assert!(grooves.iter().all(|g| (g / grooves[0] - 1.0).abs() < 1e-9), "{grooves:?}");
    }
    let oblate = Shape::Ellipsoid { radii: [2.0, 1.0, 2.0] };
    assert_eq!(oblate.proxy(7), Err(ProxyError::NoMajorAxis));
    assert_eq!(Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }.proxy(4), Err(ProxyError::Even { count: 4 }));
    assert_eq!(Shape::Ellipsoid { radii: [1.0; 3] }.proxy(5).unwrap().len(), 1);
    let cell = Shape::Spherocylinder { diameter: 0.5, length: 4.0 };
    let proxy = cell.proxy(5).unwrap();
    let heights: Vec<f64> = proxy.iter().map(|s| s.centre.z).collect();
    assert_eq!(heights, [-1.75, -0.875, 0.0, 0.875, 1.75]);
    assert!(proxy.iter().all(|s| s.radius == 0.25));
    assert_eq!(cell.proxy(1), Err(ProxyError::TooFew { count: 1, least: 3 }));
    let ring = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    assert_eq!(ring.proxy(31), Err(ProxyError::TooFew { count: 31, least: 32 }));
    let proxy = ring.proxy(32).unwrap();
    assert!((0..32).all(|i| (proxy[i].centre - proxy[(i + 1) % 32].centre).length() <= 0.2));
    assert_eq!(Shape::Sphere { radius: 1.0 }.proxy(1).unwrap().len(), 1);
}

/// Volume and moments of the points of a grid that are inside the shape.
fn by_grid(shape: Shape, cells: i32) -> (f64, DVec3) {
    let body = Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let step = 2.0 * shape.half_extents(DQuat::IDENTITY) / f64::from(cells);
    let inside = |p: DVec3| match shape {
        Shape::Ellipsoid { radii } => (p / DVec3::from_array(radii)).length() <= 1.0,
        _ => to_centreline(&body, p) <= 0.5 * shape.thickness(),
    };
    let (mut volume, mut moments) = (0.0, DVec3::ZERO);
    for (i, j, k) in (0..cells * cells * cells).map(|n| (n % cells, n / cells % cells, n / cells / cells)) {
        let p = step * (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.5 - 0.5 * f64::from(cells));
        if inside(p) {
            let square = p * p;
            volume += 1.0;
            moments += DVec3::splat(square.element_sum()) - square;
        }
    }
    let cell = step.element_product();
    (volume * cell, moments * cell)
}

#[test]
fn volume_and_inertia_are_those_of_the_solid() {
    for shape in [
        Shape::Sphere { radius: 1.5 },
        Shape::Spherocylinder { diameter: 1.0, length: 3.0 },
        Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] },
        Shape::Torus { major_radius: 2.0, minor_radius: 0.7 },
    ] {
        let (volume, moments) = by_grid(shape, 120);
        assert!((volume / shape.volume() - 1.0).abs() < 2e-3, "{shape:?} {volume}");
        assert!((moments / shape.unit_inertia() - 1.0).abs().max_element() < 4e-3, "{shape:?} {moments}");
    }
}

#[test]
fn boxes_are_tight_and_in_the_bounding_sphere() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for round in 0..200 {
        let shape = random_shape(KINDS[round % 4], 30.0, &mut random);
        let body = Placed { shape, position: DVec3::ZERO, orientation: turn(&mut random) };
        let point = Shape::Sphere { radius: 1.0 };
        let extents = shape.half_extents(body.orientation);
        for (axis, extent) in DVec3::AXES.into_iter().zip(extents.to_array()) {
            // The bound of a unit ball far along an axis is its distance less the box.
            let ball = Placed { shape: point, position: axis * 100.0, orientation: DQuat::IDENTITY };
            let reach = 99.0 - bound(&body, &ball, axis);
            assert!((reach - extent).abs() < 1e-12 * shape.bounding_radius(), "{shape:?} {reach} {extent}");
        }
        assert!(extents.max_element() <= shape.bounding_radius() * (1.0 + 1e-15));
        assert_eq!(shape.major_axis(), 2.0 * shape.bounding_radius());
        assert!(shape.thickness() <= shape.major_axis());
    }
}

#[test]
fn impossible_shapes_are_refused_by_name() {
    let rod = |diameter, length| Shape::Spherocylinder { diameter, length };
    let nan = rod(1.0, f64::NAN).validate();
    assert!(matches!(nan, Err(ShapeError::NotFinite { name: "length", .. })));
    let negative = Shape::Ellipsoid { radii: [1.0, -1.0, 1.0] }.validate();
    assert_eq!(negative, Err(ShapeError::NotPositive { name: "radii.1", value: -1.0 }));
    assert!(matches!(Shape::Sphere { radius: 0.0 }.validate(), Err(ShapeError::NotPositive { .. })));
    assert!(matches!(rod(1.0, 0.9).validate(), Err(ShapeError::ShorterThanDiameter { .. })));
    assert!(rod(1.0, 1.0).validate().is_ok());
    let disc = Shape::Torus { major_radius: 1.0, minor_radius: 1.0 }.validate();
    assert!(matches!(disc, Err(ShapeError::NoHole { .. })));
    let thread = Shape::Ellipsoid { radii: [1.0, 1.0, 1.001 * MAX_ASPECT] }.validate();
    assert!(matches!(thread, Err(ShapeError::Aspect { .. })));
    assert!(Shape::Ellipsoid { radii: [1.0, 1.0, MAX_ASPECT] }.validate().is_ok());
}

#[test]
fn planar_bodies_have_their_plane_as_a_mirror() {
    let upright = DQuat::from_rotation_z(0.7);
    let lying = upright * DQuat::from_rotation_y(FRAC_PI_2);
    let leaning = upright * DQuat::from_rotation_y(1e-6);
    for kind in KINDS {
        let shape = random_shape(kind, 5.0, &mut ChaCha8Rng::seed_from_u64(3));
        assert!(shape.is_planar_symmetric(upright) && shape.is_planar_symmetric(lying), "{shape:?}");
        assert_eq!(shape.is_planar_symmetric(leaning), kind == "sphere", "{shape:?}");
    }
    assert!(Shape::Ellipsoid { radii: [2.0, 1.0, 2.0] }.is_planar_symmetric(DQuat::from_rotation_y(0.3)));
}
