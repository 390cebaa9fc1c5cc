//! Separations from surfaces on the device against the CPU's, in both precisions, at the origin and far from it, in
//! walls small and large.
//!
//! Errors are fractions of a body's size, its bounding radius and its distance from the surface: how large the wall is
//! and where it lies does not count.

use crate::device::{device, precisions};
use crate::directions::turn;
use glam::{DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Lattice, Source};
use relcp::internals::separation::Surface;
use relcp::internals::separation::gpu::{Exponents, add_places_to, surface_numbers};
use relcp::separation::{Placed, Separation};
use relcp::shape::{Shape, Superellipsoid};
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Reads a body as three vectors and a cell, and writes three places in two vectors each.
const LIST: &str = "
struct Parameters { count: u32, x: u32, y: u32, z: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> cells: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read> bodies: array<vec4r>;
@group(0) @binding(3) var<storage, read> surfaces: array<vec4r>;
@group(0) @binding(4) var<storage, read_write> out: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = invocation(group, groups, local);
    if i >= parameters.count { return; }
    let body = Placed(u32(bodies[3u * i].w), bodies[3u * i + 1u].xyz, bodies[3u * i + 2u]);
    let surface = surface_at(i);
    let offset = offset_from(surface, cells[i].xyz, bodies[3u * i].xyz);
    for (var place = 0u; place < 3u; place += 1u) {
        let found = separate_place(surface, offset, body, place);
        out[6u * i + 2u * place] = vec4r(found.normal, found.separation);
        out[6u * i + 2u * place + 1u] = vec4r(found.lever_a, gap_of(surface, offset).distance);
    }
}
";

#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub surface: Surface,
    pub body: Placed,
}

/// A body's places that are there, and the gap of its centre.
pub struct Answer {
    pub places: Vec<Separation>,
    gap: f64,
}

impl Answer {
    pub fn least(&self) -> &Separation {
        self.places.iter().min_by(|a, b| a.separation.total_cmp(&b.separation)).unwrap()
    }
}

pub fn answers(gpu: &Gpu, precision: Precision, lattice: &Lattice, poses: &[Pose]) -> Vec<Answer> {
    let shapes: Vec<Shape> = poses.iter().map(|pose| pose.body.shape).collect();
    let exponents = Exponents::of(&shapes);
    let source = exponents.add_to(lattice.define(Source::new("places", precision)));
    let source = add_places_to(source, lattice, &shapes).text(LIST);
    let kernel = Kernel::new(gpu, &source).unwrap();
    let (mut cells, mut bodies, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
    for Pose { surface, body } in poses {
        let parts = body.position.to_array().map(|x| lattice.split(x).unwrap());
        cells.extend([parts[0].0, parts[1].0, parts[2].0, 0]);
        let [x, y, z, kind] = exponents.numbers(&body.shape);
        bodies.extend([parts[0].1, parts[1].1, parts[2].1, kind, x, y, z, 0.0]);
        bodies.extend(DVec4::from(body.orientation).to_array());
        surfaces.extend(surface_numbers(surface, lattice).unwrap());
    }
    let count = poses.len() as u64;
    let cells = Buffer::with(gpu, "cells", 16, bytemuck::cast_slice(&cells)).unwrap();
    let bodies = Buffer::reals(gpu, "bodies", precision, 4, bodies).unwrap();
    let surfaces = Buffer::reals(gpu, "surfaces", precision, 4, surfaces).unwrap();
    let out = Buffer::new(gpu, "separations", 4 * precision.bytes(), 6 * count).unwrap();
    let mut record = gpu.record();
    let parameters: Vec<u8> = [count as u32, 0, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    record.run(&kernel, &parameters, &[&cells, &bodies, &surfaces, &out], count);
    let read = record.read(&[(&out, 0..24 * count * precision.bytes() as u64)]).unwrap();
    let numbers = precision.decode(&read[0]);
    let answer = |v: &[f64; 24]| {
        let place = |v: &[f64; 8]| Separation {
            separation: v[3],
            normal: DVec3::from_slice(v),
            lever_a: DVec3::from_slice(&v[4..]),
            lever_b: DVec3::ZERO,
        };
        let places = v.as_chunks::<8>().0.iter().map(place).filter(|place| place.separation < 1e30).collect();
        Answer { places, gap: v[7] }
    };
    numbers.as_chunks::<24>().0.iter().map(answer).collect()
}

/// A random shape one thick, its sizes within a factor of `aspect`.
fn shape(kind: usize, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        0 => Shape::Sphere { radius: 0.5 * ratio() },
        1 => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        2 => Shape::Ellipsoid { radii: [0.5 * ratio(), 0.5, 0.5 * ratio()] },
        3 => Shape::Torus { major_radius: 0.5 + ratio(), minor_radius: 0.5 },
        _ => {
            let exponents = [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [2.0, 8.0], [10.0, 2.5]];
            let radii = [0.5 * ratio(), 0.5, 0.5 * ratio()];
            Shape::Superellipsoid(Superellipsoid::new(radii, exponents[random.random_range(0..exponents.len())]))
        }
    }
}

/// A surface of each kind about `at`, of radius `radius`; a plane that far along itself from its point.
fn surface(kind: usize, at: DVec3, radius: f64, random: &mut ChaCha8Rng) -> Surface {
    let normal = if random.random_bool(0.3) { DVec3::Y } else { turn(random) * DVec3::Z };
    match kind {
        0 => Surface::Plane { point: at + radius * normal.any_orthonormal_vector(), normal },
        1 => Surface::Sphere { centre: at, radius },
        _ => Surface::Cylinder { centre: at, axis: normal, radius },
    }
}

/// Bodies of all shapes near surfaces of all kinds, from half a thickness past the surface to one apart; every tenth
/// anywhere inside of it.
fn near(count: usize, aspect: f64, at: DVec3, size: f64) -> Vec<Pose> {
    near_of(0..4, count, aspect, at, size)
}

fn near_of(kinds: Range<usize>, count: usize, aspect: f64, at: DVec3, size: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut poses = Vec::new();
    for (round, shapes, kind) in each(count, kinds) {
        let shape = shape(shapes, aspect, &mut random);
        let radius = size.max(1.5 * shape.bounding_radius()) * random.random_range(1.0..2.0);
        let surface = surface(kind, at, radius, &mut random);
        let reach = random.random_range(0.0..1.0) * (radius - shape.bounding_radius());
        let mut body =
            Placed { shape, position: at + turn(&mut random) * DVec3::Z * reach, orientation: turn(&mut random) };
        if !round.is_multiple_of(10) {
            // Along a cylinder's axis too.
            if let Surface::Cylinder { axis, .. } = surface {
                body.position += axis * (radius * random.random_range(-2.0..2.0));
            }
            let target = random.random_range(-0.5..1.0);
            for _ in 0..6 {
                let found = surface.separation(&body);
                body.position += found.normal * (found.separation - target);
            }
        }
        poses.push(Pose { surface, body });
    }
    poses
}

/// Rounds, shapes and surfaces.
fn each(count: usize, kinds: Range<usize>) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..count).flat_map(move |i| kinds.clone().flat_map(move |s| (0..3).map(move |k| (i, s, k))))
}

/// Bodies at centres and on axes, on faces and beyond, upright, lying and leaning, and shapes that are as good as
/// others.
fn degenerate() -> Vec<Pose> {
    let shapes = [
        Shape::Sphere { radius: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 5.0 },
        Shape::Ellipsoid { radii: [1.0; 3] },
        Shape::Ellipsoid { radii: [1.0, 1.0, 8.0] },
        Shape::Ellipsoid { radii: [8.0, 8.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 3.0, 10.0] },
        Shape::Torus { major_radius: 2.0, minor_radius: 0.5 },
    ];
    let surfaces = [
        Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z },
        Surface::Plane { point: DVec3::ZERO, normal: -DVec3::X },
        Surface::Sphere { centre: DVec3::ZERO, radius: 12.0 },
        Surface::Sphere { centre: DVec3::ZERO, radius: 3.0 },
        Surface::Cylinder { centre: DVec3::ZERO, axis: DVec3::Z, radius: 12.0 },
        Surface::Cylinder { centre: DVec3::ZERO, axis: DVec3::new(0.6, 0.0, -0.8), radius: 3.0 },
    ];
    let places =
        [DVec3::ZERO, DVec3::Z, DVec3::X * 2.0, DVec3::new(3.0, -4.0, 0.0), DVec3::ONE * 15.0, DVec3::X * 1e-300];
    let tilt = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9));
    let hardly = DQuat::from_scaled_axis(DVec3::X * 1e-9);
    let turns = [DQuat::IDENTITY, tilt, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2), hardly];
    let mut poses = Vec::new();
    for (shape, surface) in shapes.into_iter().flat_map(|shape| surfaces.map(|surface| (shape, surface))) {
        for (position, orientation) in places.into_iter().flat_map(|place| turns.map(|turn| (place, turn))) {
            poses.push(Pose { surface, body: Placed { shape, position, orientation } });
        }
    }
    poses
}

/// The largest error allowed of a separation, and of the point on the body along the normal.
fn tolerance(precision: Precision) -> f64 {
    if precision == Precision::F32 { 2e-6 } else { 1e-11 }
}

fn compare(what: &str, poses: &[Pose]) {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    for precision in precisions(gpu) {
        let limit = tolerance(precision);
        let (mut worst, mut turned) = ([0.0_f64; 3], 0.0_f64);
        for (pose, answer) in poses.iter().zip(answers(gpu, precision, &lattice, poses)) {
            let Pose { surface, body } = pose;
            let expected = surface.separation(body);
            let mut places = 0;
            surface.places(body, |_, _| places += 1);
            assert_eq!(answer.places.len(), places, "{what} {precision:?} {pose:?}");
            let found = answer.least();
            let size = body.shape.bounding_radius() + expected.separation.abs();
            // The bound is the gap of the centre less the bounding radius.
            let gap = (answer.gap - body.shape.bounding_radius() - surface.bound(body)).abs();
            let apart = (found.separation - expected.separation).abs();
            // The separation is the gap of the point that the lever leads to.
            let there =
                Placed { shape: Shape::Sphere { radius: 0.0 }, position: body.position + found.lever_a, ..*body };
            let along = (surface.separation(&there).separation - found.separation).abs();
            for (worst, error) in worst.iter_mut().zip([apart, along, gap]) {
                assert!(error <= limit * size, "{what} {precision:?} {pose:?}: {error:e}\n{found:?}\n{expected:?}");
                *worst = worst.max(error / size);
            }
            assert!((found.normal.length() - 1.0).abs() <= 8.0 * precision.epsilon(), "{pose:?} {found:?}");
            assert_eq!(found.lever_b, DVec3::ZERO);
            let point = body.position + expected.lever_a;
            // Away from the centre of what is round the normal is as good as the place of the point.
            let other = (found.lever_a - expected.lever_a).length() > 1e-2 * size;
            let inner = Placed { shape: Shape::Sphere { radius: 0.0 }, position: point, ..*body };
            if !other && surface.separation(&inner).separation < 0.5 * size {
                turned = turned.max((found.normal - expected.normal).length());
            }
        }
        let [apart, along, gap] = worst;
        println!(
            "{what}, {}: {} poses, separations within {apart:.1e}, points {along:.1e}, centres {gap:.1e}, normals {turned:.1e}",
            precision.name(),
            poses.len()
        );
    }
}

#[test]
fn bodies_near_surfaces_agree_with_the_cpu() {
    for aspect in [3.0, 30.0] {
        compare(&format!("aspect {aspect}"), &near(30, aspect, DVec3::new(0.3, -0.1, 0.7), 3.0));
    }
}

/// Also with faces parallel to the plane or the axis. `RELCP_POSES=N` for more poses at each surface.
#[test]
fn superellipsoids_near_surfaces_agree_with_the_cpu() {
    for aspect in [3.0, 30.0] {
        let count = std::env::var("RELCP_POSES").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
        let mut poses = near_of(4..5, count, aspect, DVec3::new(0.3, -0.1, 0.7), 3.0);
        for pose in poses.iter_mut().step_by(2) {
            pose.body.orientation = DQuat::from_rotation_x(FRAC_PI_2);
        }
        compare(&format!("superellipsoids, aspect {aspect}"), &poses);
    }
}

/// Here the CPU's own rounding is some 1e-12.
#[test]
fn neither_large_walls_nor_the_origin_count() {
    compare("a wall of 2000", &near(20, 5.0, DVec3::ZERO, 2e3));
    compare("at 10,000", &near(20, 5.0, DVec3::new(9e3, -7e3, 1e4 / 3.0), 20.0));
    compare("a wall of 2000 at 5,000", &near(20, 5.0, DVec3::new(-3e3, 4e3, 0.1), 2e3));
}

#[test]
fn degenerate_bodies_agree_with_the_cpu() {
    compare("degenerate", &degenerate());
}

/// At the end of the lattice, in walls as large as it: 64 bits hold no more than 1e-10 there, which 32 bits are held to
/// 1e-6 against.
#[test]
fn separations_hold_at_the_end_of_the_lattice() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let poses = [near(10, 5.0, DVec3::new(3e5, -4e5, 1e5), 8e4), near(10, 5.0, DVec3::ZERO, 1.5e5)].concat();
    for precision in precisions(gpu) {
        let worst = poses.iter().zip(answers(gpu, precision, &lattice, &poses)).map(|(pose, answer)| {
            let expected = pose.surface.separation(&pose.body).separation;
            (answer.least().separation - expected).abs() / (pose.body.shape.bounding_radius() + expected.abs())
        });
        let worst = worst.fold(0.0, f64::max);
        println!("{}: within {worst:.1e}", precision.name());
        assert!(worst <= if precision == Precision::F32 { 2e-6 } else { 1e-9 }, "{precision:?}: {worst:e}");
    }
}
