//! Tests: small steps accumulate on the device, for positions, orientations and lengths.

use super::Setup;
use super::lists::Lists;
use super::narrow_phase::{NarrowKernels, OverlapsArgs, Report};
use super::source::{NEAR, VIOLATING, spinning};
use super::unrounded::split_length;
use crate::dynamics::Spin;
use crate::gpu::{Buffer, Gpu, GpuError, Kernel, Lattice, Made, Precision, Source, fragment, precisions, test_device};
use crate::shape::gpu::{Exponents, add_shapes_to};
use crate::shape::{Convex, Shape, Superellipsoid, Tag};
use glam::{DQuat, DVec3};

/// Steps per dispatch, and dispatches: a million steps.
const ROUNDS: u32 = 10_000;
const DISPATCHES: usize = 100;

const DRIFT: &str = "
@group(0) @binding(0) var<storage, read_write> cells: array<vec4<i32>>;
@group(0) @binding(1) var<storage, read_write> remainders: array<vec4r>;
@group(0) @binding(2) var<storage, read_write> orientations: array<vec4r>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    if local > 0u { return; }
    for (var k = 0u; k < ROUNDS; k += 1u) {
        let place = lattice_add(cells[0].xyz, remainders[0].xyz, STEP);
        cells[0] = vec4<i32>(place.cell, 0);
        remainders[0] = vec4r(place.remainder, 0.0);
        let turned = orientation_advance(Orientation(orientations[0], orientations[1]), HALF_TURN);
        orientations[0] = turned.coarse;
        orientations[1] = turned.fine;
    }
}
";

fn drift(gpu: &Gpu, precision: Precision, from: DVec3, step: DVec3, half_turn: DVec3) -> (DVec3, DQuat) {
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let source = lattice
        .define(Source::new("drift", precision))
        .integer("ROUNDS", ROUNDS)
        .vector("STEP", step.to_array())
        .vector("HALF_TURN", half_turn.to_array())
        .include(fragment!("common/quaternion.wgsl"))
        .include(fragment!("common/orientation.wgsl"))
        .text(DRIFT);
    let kernel = Kernel::new(gpu, &source).unwrap();
    let parts = from.to_array().map(|x| lattice.split(x).unwrap());
    let cell = [parts[0].0, parts[1].0, parts[2].0, 0];
    let cells = Buffer::with(gpu, "cells", 16, bytemuck::cast_slice(&cell)).unwrap();
    let remainders = Buffer::reals(gpu, "r", precision, 4, [parts[0].1, parts[1].1, parts[2].1, 0.0]).unwrap();
    let turn = Buffer::reals(gpu, "q", precision, 8, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let mut record = gpu.record();
    for _ in 0..DISPATCHES {
        record.run(&kernel, &[], &[&cells, &remainders, &turn], 1);
    }
    let real = precision.bytes() as u64;
    let read = record.read(&[(&cells, 0..16), (&remainders, 0..4 * real), (&turn, 0..8 * real)]).unwrap();
    let cell: Vec<i32> = bytemuck::pod_collect_to_vec(&read[0]);
    let (remainder, turn) = (precision.decode(&read[1]), precision.decode(&read[2]));
    let place = DVec3::from_array(std::array::from_fn(|k| lattice.join(cell[k], remainder[k])));
    let q = DQuat::from_array(std::array::from_fn(|k| turn[k] + turn[k + 4]));
    assert!((q.length() - 1.0).abs() < 4e-6, "{precision:?}: length {}", q.length());
    (place, q.normalize())
}

#[test]
fn a_drift_of_1e_8_a_step_arrives_after_a_million_steps() {
    let Some(gpu) = test_device() else { return };
    for precision in precisions(gpu) {
        for from in [DVec3::ZERO, DVec3::new(2000.0, -1500.0, 0.3), DVec3::splat(9e5)] {
            let step = DVec3::new(1e-8, -3e-9, 2.5e-8);
            let half_turn = DVec3::new(0.0, 0.0, 5e-9);
            let (place, turn) = drift(gpu, precision, from, step, half_turn);
            let error = (place - from - 1e6 * step).length() / (1e6 * step).length();
            let (axis, angle) = turn.to_axis_angle();
            let turned = (angle * axis.z - 1e-2).abs() / 1e-2;
            println!("{precision:?} from {from}: moved to {error:.1e}, turned to {turned:.1e}");
            assert!(error < 1e-3 && turned < 1e-3, "{error} {turned}");
        }
    }
}

#[test]
fn large_turns_are_those_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    for (precision, bound) in precisions(gpu).into_iter().zip([2e-6, 1e-12]) {
        let half_turn = DVec3::new(0.3, -0.1, 0.2) * 1e-4;
        let (_, turn) = drift(gpu, precision, DVec3::ZERO, DVec3::ZERO, half_turn);
        // A million equal rotations by 2 atan |h| about one axis.
        let angle = 2e6 * half_turn.length().atan();
        let expected = DQuat::from_axis_angle(half_turn.normalize(), angle % std::f64::consts::TAU);
        let off = 2.0 * (turn - expected).length().min((turn + expected).length());
        println!("{precision:?}: {off:.1e} rad off after {angle:.1} rad");
        assert!(off < bound * angle, "{off}");
    }
}

const TURNS: &str = "
@group(0) @binding(0) var<storage, read> shapes: array<vec4r>;
@group(0) @binding(1) var<storage, read> orientations: array<vec4r>;
@group(0) @binding(2) var<storage, read> velocities: array<vec4r>;
@group(0) @binding(3) var<storage, read_write> found: array<vec4r>;
@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= BODIES { return; }
    let moments = moments_of(shapes[i]);
    let momentum = momentum_of(moments, orientations[i], velocities[i].xyz);
    found[3u * i] = vec4r(momentum, 0.0);
    found[3u * i + 1u] = vec4r(velocity_of(moments, orientations[i], momentum), 0.0);
    found[3u * i + 2u] = vec4r(turning_of(moments, orientations[i], momentum, 1.0), 0.0);
}
";

/// Momentum, velocity and mean angular velocity on the device, for bodies that rotate by up to about one radian per
/// step.
fn turns(gpu: &Gpu, precision: Precision, bodies: &[(Shape, DQuat, DVec3)]) -> Vec<f64> {
    let scene = crate::scene::Scene::load("two-ellipsoids", ["dynamics={\"inertial\":{\"density\":1}}"]).unwrap();
    let setup = Setup::new(&scene.model(), &[Shape::Sphere { radius: 1.0 }], precision).unwrap();
    let source = Source::new("turns", precision)
        .integer("BODIES", bodies.len() as u32)
        .flag("PLANAR", false)
        .include(fragment!("common/quaternion.wgsl"));
    let source = add_shapes_to(source);
    let kernel = Kernel::new(gpu, &spinning(&setup, source).text(TURNS)).unwrap();
    let shape = |(shape, _, _): &(Shape, DQuat, DVec3)| {
        let (tag, [x, y, z]) = shape.code();
        [x, y, z, f64::from(tag)]
    };
    let buffer = |name, numbers: Vec<f64>| Buffer::reals(gpu, name, precision, 4, numbers).unwrap();
    let shapes = buffer("shapes", bodies.iter().flat_map(shape).collect());
    let turned = buffer("orientations", bodies.iter().flat_map(|(_, q, _)| q.to_array()).collect());
    let speeds = buffer("velocities", bodies.iter().flat_map(|(_, _, w)| [w.x, w.y, w.z, 0.0]).collect());
    let found = buffer("found", vec![0.0; 12 * bodies.len()]);
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&shapes, &turned, &speeds, &found], bodies.len() as u64);
    precision.decode(&record.read(&[(&found, 0..12 * (bodies.len() * precision.bytes()) as u64)]).unwrap()[0])
}

#[test]
fn turns_without_torque_are_those_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    let body = |i: usize| {
        let t = i as f64;
        let shape = match i % 4 {
            0 => Shape::Sphere { radius: 0.1 + t.cos().abs() },
            1 => Shape::Spherocylinder { diameter: 0.5, length: 0.5 + 4.0 * t.cos().abs() },
            2 => Shape::Torus { major_radius: 1.0, minor_radius: 0.05 + 0.9 * t.cos().abs() },
            _ => Shape::Ellipsoid { radii: [1.0, 0.1 + t.cos().abs(), 0.1 + (2.0 * t).cos().abs()] },
        };
        let velocity = DVec3::new((3.0 * t).sin(), (5.0 * t).sin(), (7.0 * t).sin()) * (t / 2000.0);
        (shape, DQuat::from_scaled_axis(DVec3::new(t.sin(), (2.0 * t).sin(), t)), velocity)
    };
    let bodies: Vec<_> = (0..1000).map(body).collect();
    for (precision, bound) in precisions(gpu).into_iter().zip([3e-6, 1e-14]) {
        let found = turns(gpu, precision, &bodies);
        let mut worst = [0.0f64; 3];
        for (i, (shape, q, velocity)) in bodies.iter().enumerate() {
            let spin = Spin::new(shape.unit_inertia());
            let momentum = spin.momentum(*q, *velocity);
            let expected = [momentum, spin.velocity(*q, momentum), spin.turning(*q, momentum, 1.0)];
            for (k, expected) in expected.into_iter().enumerate() {
                let found = DVec3::from_slice(&found[12 * i + 4 * k..]);
                worst[k] = worst[k].max((found - expected).length() / (expected.length() + f64::MIN_POSITIVE));
            }
        }
        println!("{precision:?}: momentum, velocity and turning off by {worst:?}");
        assert!(worst.iter().all(|off| *off < bound), "{precision:?}: {worst:?}");
    }
}

#[test]
fn lengths_split_exactly() {
    let pitch = 2f64.powi(-18);
    let [coarse, fine] = split_length(3.217_592_653_589_793, pitch);
    assert_eq!(coarse + fine, 3.217_592_653_589_793);
    assert_eq!(f64::from(coarse as f32), coarse);
    assert!(fine.abs() <= 0.5 * pitch);
}

#[test]
fn custom_shapes_are_refused_before_a_device_is_asked() {
    let scene = crate::scene::Scene::built_in("two-ellipsoids").unwrap();
    let shapes = [Shape::Sphere { radius: 1.0 }, Shape::Convex(Convex::new(|n: DVec3| n).unwrap())];
    let refused = Setup::new(&scene.model(), &shapes, Precision::F32).err();
    assert_eq!(refused, Some(GpuError::Unsupported { what: "custom shapes".into() }));
    assert!(Setup::new(&scene.model(), &shapes[..1], Precision::F32).is_ok());
}

const OF_TAGS: &str = "
@group(0) @binding(0) var<storage, read_write> found: array<vec4r>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) tag: u32) {
    if tag >= TAGS { return; }
    let shape = vec4r(1.0, 2.0, 3.0, real(tag));
    let body = Placed(tag, shape.xyz, vec4r(0.0, 0.0, 0.0, 1.0));
    found[3u * tag] = vec4r(solid(shape).volume, solid(shape).inertia);
    found[3u * tag + 1u] = vec4r(major_axis(shape), bounding_radius(body), hull(body, vec3r(0.0, 0.6, 0.8)), thickness(body));
    found[3u * tag + 2u] = vec4r(half_extents(body), 0.0);
}
";

#[test]
fn a_number_that_is_no_shape_has_no_sizes() {
    let Some(gpu) = test_device() else { return };
    let tags = Tag::ALL.len() + 1;
    for precision in precisions(gpu) {
        let source = Source::new("tags", precision).integer("TAGS", tags as u32);
        let source = add_shapes_to(crate::separation::gpu::add_bodies_to(source)).text(OF_TAGS);
        let kernel = Kernel::new(gpu, &source).unwrap();
        let found = Buffer::new(gpu, "found", 4 * precision.bytes(), 3 * tags as u64).unwrap();
        let mut record = gpu.record();
        record.run(&kernel, &[], &[&found], 1);
        let bytes = 12 * (tags * precision.bytes()) as u64;
        let numbers = precision.decode(&record.read(&[(&found, 0..bytes)]).unwrap()[0]);
        for (tag, sizes) in (0..).zip(numbers.chunks(12)) {
            let known = Tag::of_number(tag).is_some_and(|tag| tag.constant().is_some());
            for (k, size) in sizes.iter().enumerate().filter(|(k, _)| *k != 11) {
                assert_eq!(size.is_finite(), known, "{precision:?} {tag} {k}: {size}");
            }
        }
    }
}

const OF_SHAPES: &str = "
@group(0) @binding(0) var<storage, read> shapes: array<vec4r>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4r>;
@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) i: u32) {
    if i >= SHAPES { return; }
    let shape = shapes[i];
    let body = Placed(u32(shape.w), shape.xyz, vec4r(0.0, 0.6, 0.0, 0.8));
    found[3u * i] = vec4r(solid(shape).volume, solid(shape).inertia);
    found[3u * i + 1u] = vec4r(major_axis(shape), bounding_radius(body), hull(body, vec3r(0.0, 0.6, 0.8)), thickness(body));
    found[3u * i + 2u] = vec4r(half_extents(body), axis_of_revolution(shape).z);
}
";

#[test]
fn superellipsoids_have_the_sizes_that_the_cpu_has() {
    let Some(gpu) = test_device() else { return };
    let radii = [[0.5; 3], [0.3, 0.3, 0.8], [0.2, 1.0, 40.0]];
    let exponents = [[2.0; 2], [2.5; 2], [8.0, 2.0], [10.0; 2], [2.0, 8.0], [10.0, 2.5]];
    let of = |radii| exponents.map(|exponents| Shape::Superellipsoid(Superellipsoid::new(radii, exponents)));
    let shapes: Vec<Shape> = radii.into_iter().flat_map(of).chain([Shape::Sphere { radius: 0.7 }]).collect();
    let table = Exponents::of(&shapes);
    assert!(shapes.iter().all(|shape| table.shape(table.numbers(shape)) == Some(*shape)));
    for (precision, bound) in precisions(gpu).into_iter().zip([3e-6, 1e-14]) {
        let source = Source::new("sizes", precision).integer("SHAPES", shapes.len() as u32);
        let source = add_shapes_to(crate::separation::gpu::add_bodies_to(table.add_to(source))).text(OF_SHAPES);
        let kernel = Kernel::new(gpu, &source).unwrap();
        let numbers = shapes.iter().flat_map(|shape| table.numbers(shape));
        let given = Buffer::reals(gpu, "shapes", precision, 4, numbers).unwrap();
        let found = Buffer::new(gpu, "found", 4 * precision.bytes(), 3 * shapes.len() as u64).unwrap();
        let mut record = gpu.record();
        record.run(&kernel, &[], &[&given, &found], 1);
        let bytes = 12 * (shapes.len() * precision.bytes()) as u64;
        let numbers = precision.decode(&record.read(&[(&found, 0..bytes)]).unwrap()[0]);
        let mut worst = 0.0_f64;
        for (shape, found) in shapes.iter().zip(numbers.chunks(12)) {
            let turned = DQuat::from_xyzw(0.0, 0.6, 0.0, 0.8);
            let n = DVec3::new(0.0, 0.6, 0.8);
            let body = crate::separation::Placed { shape: *shape, position: DVec3::ZERO, orientation: turned };
            let ball = Shape::Sphere { radius: 0.0 };
            let ball = crate::separation::Placed { shape: ball, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
            let reach = -crate::separation::bound(&body, &ball, n);
            let radius = shape.bounding_radius();
            let axis = f64::from(shape.axis_of_revolution().is_some_and(|axis| axis == DVec3::Z));
            let head = [shape.volume()].into_iter().chain(shape.unit_inertia().to_array());
            let middle = [shape.major_axis(), radius, reach, shape.thickness()];
            let tail = shape.half_extents(turned).to_array();
            let expected = head.chain(middle).chain(tail).chain([axis]);
            for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
                let off = (found - expected).abs() / expected.abs().max(1e-3);
                assert!(off <= bound, "{precision:?} {shape:?} {k}: {found} {expected}");
                worst = worst.max(off);
            }
        }
        println!("{precision:?}: sizes within {worst:.1e}");
    }
}

/// Twelve numbers per pair; the overlap kernel reads the separation and the flag.
fn contact(separation: f64, flag: u32) -> [f64; 12] {
    let mut numbers = [0.0; 12];
    (numbers[3], numbers[11]) = (separation, f64::from(flag));
    numbers
}

#[test]
fn overlaps_of_many_workgroups_are_brought_together() {
    let Some(gpu) = test_device() else { return };
    let scene = crate::scene::Scene::built_in("two-ellipsoids").unwrap();
    for precision in precisions(gpu) {
        let setup = Setup::new(&scene.model(), &[Shape::Sphere { radius: 1.0 }], precision).unwrap();
        let kernels = NarrowKernels::make(gpu, &setup).unwrap();
        // The last workgroup is not full. Two pairs have the deepest overlap; the first of them comes far after the
        // pair in the first workgroup that also overlaps.
        let count = 1_000u32;
        let pairs = u64::from(count);
        let separation = |p: u32| match p {
            601 | 890 => -0.75,
            _ if p.is_multiple_of(3) => 0.1,
            _ => -1e-4 * f64::from(p % 7),
        };
        let flag = |p: u32| match p % 5 {
            0 => 0,
            1 => VIOLATING,
            _ => NEAR,
        };
        let numbers = (0..count).flat_map(|p| contact(separation(p), flag(p)));
        let mut lists = Lists::new(gpu, &setup).unwrap();
        lists.contacts = Buffer::reals(gpu, "contacts", precision, 12, numbers).unwrap();
        let bodies: Vec<[u32; 2]> = (0..count).map(|p| [p, p + count]).collect();
        lists.pairs_count = pairs;
        lists.pairs = Buffer::with(gpu, "pairs", 8, bytemuck::cast_slice(&bodies)).unwrap();
        let report = Buffer::with(gpu, "report", 4, bytemuck::bytes_of(&Report::blank())).unwrap();
        let mut record = gpu.record();
        for (pass_number, threads) in [(1, pairs), (2, pairs), (3, 1)] {
            let searched = OverlapsArgs { pass_number, lists: &lists, report: &report };
            kernels.overlap.call(&mut record, threads, searched);
        }
        let read = record.read(&[(&report, 0..Report::BYTES)]).unwrap();
        let found: Report = bytemuck::pod_read_unaligned(&read[0]);
        let violations = (0..count).filter(|p| separation(*p) < 0.0 && flag(*p) == VIOLATING).count() as u32;
        assert!(violations > 100, "{violations}, in every group");
        assert_eq!((found.worst, found.violations), ((0.75f32).to_bits(), violations), "{precision:?}");
        assert_eq!((found.worst_pair, found.worst_a, found.worst_b), (601, 601, 601 + count), "{precision:?}");
    }
}
