//! Pictures whose rays a device casts, against the CPU's.

use crate::device::device;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::record::States;
use relcp::render::{Camera, Frames, Image, Rays, View, picture_by, picture_on, render_on};
use relcp::separation::Placed;
use relcp::shape::{Convex, Shape};

/// Bodies of all shapes, slender and flat ones among them, in a heap of this size about a centre.
fn heap(count: usize, size: f64, centre: DVec3) -> Bodies {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    let mut uniform = || random.random::<f64>();
    let mut bodies = Bodies::default();
    for i in 0..count {
        let length = 0.3 + uniform();
        let shape = match i % 6 {
            0 => Shape::Sphere { radius: length * size },
            1 => Shape::Spherocylinder { diameter: 0.5 * size, length: (0.5 + 3.0 * length) * size },
            2 => Shape::Ellipsoid { radii: [0.4 * size, length * size, 1.2 * size] },
            3 => Shape::Torus { major_radius: size, minor_radius: (0.05 + 0.4 * uniform()) * size },
            4 => Shape::Ellipsoid { radii: [size, 0.02 * size, size] },
            _ => Shape::Spherocylinder { diameter: 0.05 * size, length: 2.0 * size },
        };
        let position =
            centre + size * (DVec3::new(uniform(), uniform(), uniform()) - 0.5) * (count as f64).cbrt() * 1.5;
        let turn = DQuat::from_xyzw(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
        bodies.push(Placed { shape, position, orientation: turn.normalize() }, NO_GROUP);
    }
    bodies
}

/// The part of the pixels that differ by more than eight of 255 in some colour, and the mean difference.
fn apart(a: &Image, b: &Image) -> (f64, f64) {
    let (mut far, mut sum, mut pixels) = (0.0, 0.0, 0.0);
    for y in 0..400 {
        for x in 0..600 {
            let [a, b] = [a, b].map(|image| image.pixel(x, y).unwrap());
            let off = (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap();
            far += f64::from(u8::from(off > 8));
            sum += f64::from(off);
            pixels += 1.0;
        }
    }
    (far / pixels, sum / pixels)
}

#[test]
fn a_device_casts_the_cpus_pictures() {
    let Some(gpu) = device() else { return };
    let rays = Rays::new(gpu.clone()).unwrap();
    let far = DVec3::new(3e5, -2e5, 1e5);
    for (name, bodies) in [
        ("one of each", heap(6, 1.0, DVec3::ZERO)),
        ("a heap", heap(600, 1.0, DVec3::ZERO)),
        ("small and far away", heap(60, 1e-3, far)),
        ("in other units", heap(60, 1e9, DVec3::ZERO)),
        ("many", heap(4_000, 1.0, DVec3::ZERO)),
    ] {
        for planar in [false, true] {
            let view = View { width: 600, height: 400, planar, ..View::default() };
            let camera = Camera::fit(&bodies, &view);
            let ours = picture_on(&rays, &bodies, &view, &camera).unwrap();
            let (part, mean) = apart(&ours, &picture_by(&bodies, &view, &camera));
            println!(
                "{name}, planar {planar}: {:.4} % of the pixels are off by more than 8, {mean:.5} on average",
                100.0 * part
            );
            assert!(part < 2e-3 && mean < 0.1, "{name}: {part} {mean}");
            assert_eq!(ours.pixels(), picture_on(&rays, &bodies, &view, &camera).unwrap().pixels());
        }
    }
}

/// From inside of a heap: some bodies are far larger than the picture.
#[test]
fn a_device_casts_bodies_that_are_larger_than_the_picture() {
    let Some(gpu) = device() else { return };
    let rays = Rays::new(gpu.clone()).unwrap();
    let bodies = heap(600, 1.0, DVec3::ZERO);
    let near = heap(6, 0.02, DVec3::ZERO);
    let view = View { width: 600, height: 400, ..View::default() };
    let camera = Camera::fit(&near, &view);
    let (part, mean) =
        apart(&picture_on(&rays, &bodies, &view, &camera).unwrap(), &picture_by(&bodies, &view, &camera));
    println!("{:.4} % of the pixels are off by more than 8, {mean:.5} on average", 100.0 * part);
    assert!(part < 2e-3 && mean < 0.1, "{part} {mean}");
}

/// What only the CPU casts is cast by it.
#[test]
fn pictures_of_custom_shapes_and_of_nothing_are_the_cpus() {
    let Some(gpu) = device() else { return };
    let rays = Rays::new(gpu.clone()).unwrap();
    let mut bodies = heap(12, 1.0, DVec3::ZERO);
    bodies.shape[0] = Shape::Convex(
        Convex::new(|n: DVec3| n * DVec3::new(1.0, 4.0, 2.25) / (n * DVec3::new(1.0, 2.0, 1.5)).length()).unwrap(),
    );
    let view = View { width: 600, height: 400, ..View::default() };
    for bodies in [bodies, Bodies::default()] {
        let camera = Camera::fit(&bodies, &view);
        let ours = picture_on(&rays, &bodies, &view, &camera).unwrap();
        assert_eq!(ours.pixels(), picture_by(&bodies, &view, &camera).pixels());
    }
}

#[test]
fn a_rendering_says_which_device_cast_its_rays() {
    let Some(gpu) = device() else { return };
    let (folder, states) = (tempfile::tempdir().unwrap(), States::open("three-capsules").unwrap());
    let frames = Frames { size: [120, 80], ..Frames::default() };
    let render = |rays: Option<&Rays>| {
        let rendered = render_on(rays, "three-capsules", &states, &frames, folder.path(), &mut |_, _| true).unwrap();
        assert!(rendered.complete && folder.path().join("frames/000000.png").is_file());
        rendered.adapter
    };
    assert_eq!(render(Some(&Rays::new(gpu.clone()).unwrap())).as_deref(), Some(gpu.name()));
    assert_eq!(render(None), None);
}
