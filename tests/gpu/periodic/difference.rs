//! The difference to the nearest image against exact integers, and separations that are computed from it.

use crate::device::{device, precisions};
use crate::separation::harness::{Errors, tolerance};
use crate::separation::poses::{self, Pose};
use crate::separation::superellipsoids;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Lattice, LatticePeriods, Source};
use relcp::internals::separation::gpu::{Exponents, PairFamilies};
use relcp::periodic::{Axis, Periods, Tilt};
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;

/// Roundings of a pitch in a difference, and of itself.
const ROUNDINGS: f64 = 4.0;

/// Bits after the point of the exact sums: 44 hold every period, and remainders to 2^-60 pitches.
const FINE: i32 = 60;

const DIFFERENCES: &str = "
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read_write> out: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = invocation(group, groups, local);
    if i >= arrayLength(&out) { return; }
    let a = 2u * i;
    out[i] = vec4r(lattice_difference(cells[a].xyz, remainders[a].xyz, cells[a + 1u].xyz, remainders[a + 1u].xyz), 0.0);
}
";

/// Points as they are on the device: cells, and remainders rounded to its numbers.
struct Points {
    cells: Vec<i32>,
    remainders: Vec<f64>,
}

impl Points {
    fn of(precision: Precision, lattice: &Lattice, points: &[DVec3]) -> Points {
        let (mut cells, mut remainders) = (Vec::new(), Vec::new());
        for point in points {
            for x in point.to_array().into_iter().chain([0.0]) {
                let (cell, remainder) = lattice.split(x).unwrap();
                cells.push(cell);
                remainders.push(if precision == Precision::F32 { f64::from(remainder as f32) } else { remainder });
            }
        }
        Points { cells, remainders }
    }

    fn buffers(&self, gpu: &Gpu, precision: Precision) -> [Buffer; 2] {
        let cells = Buffer::with(gpu, "cells", 16, bytemuck::cast_slice(&self.cells)).unwrap();
        [cells, Buffer::reals(gpu, "remainders", precision, 4, self.remainders.iter().copied()).unwrap()]
    }
}

fn differences(gpu: &Gpu, precision: Precision, periods: &LatticePeriods, points: &Points) -> Vec<f64> {
    let source = periods.define(Source::new("differences", precision)).text(DIFFERENCES);
    let kernel = Kernel::new(gpu, &source).unwrap();
    let count = (points.cells.len() / 8) as u64;
    let [cells, remainders] = points.buffers(gpu, precision);
    let out = Buffer::new(gpu, "differences", 4 * precision.bytes(), count).unwrap();
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&cells, &remainders, &out], count);
    precision.decode(&record.read(&[(&out, 0..count * 4 * precision.bytes() as u64)]).unwrap()[0])
}

/// Differences in a sheared cell are those of the host, near the origin and far from it.
#[test]
fn differences_in_a_sheared_cell_are_the_hosts() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for precision in precisions(gpu) {
        for (direction, gradient) in [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)] {
            for (span, offset) in [(1e2, 3.3), (1e4, -2.9), (3e5, 5.1)] {
                let space = Periods::new([Some(37.0 / 3.0), Some(11.7), Some(10.3)]);
                let space = space.tilted(Tilt { direction, gradient, offset });
                let periods = LatticePeriods::of(lattice, space.numbers()).unwrap();
                let mut draw = || DVec3::from(random.random::<[f64; 3]>()) - 0.5;
                let points: Vec<DVec3> = (0..400).map(|_| 2.0 * span * draw()).collect();
                let placed = Points::of(precision, &lattice, &points);
                let text = "struct Parameters { periods: array<vec4<i32>, 5> }\nvar<uniform> parameters: Parameters;\n";
                let source = periods.define(Source::new("differences", precision)).text(text).text(DIFFERENCES);
                let kernel = Kernel::new(gpu, &LatticePeriods::changing(source)).unwrap();
                let [cells, remainders] = placed.buffers(gpu, precision);
                let out = Buffer::new(gpu, "differences", 4 * precision.bytes(), 200).unwrap();
                let mut record = gpu.record();
                let buffers = [&cells, &remainders, &out];
                record.run(&kernel, bytemuck::bytes_of(&periods.words()), &buffers, 200);
                let read = record.read(&[(&out, 0..200 * 4 * precision.bytes() as u64)]).unwrap();
                let found = precision.decode(&read[0]);
                for (pair, found) in points.chunks_exact(2).zip(found.chunks_exact(4)) {
                    let found = DVec3::new(found[0], found[1], found[2]);
                    // Either image where two are as near.
                    let exact = pair[1] - pair[0];
                    let off = space.nearest(found - exact).length();
                    let bound = 16.0 * precision.epsilon() * 10.0 + 4.0 * f64::EPSILON * span * 1e2;
                    assert!(off < bound, "{precision:?} {span}: {found}, {off:e} off");
                    let half = 0.5 * space.length() * (1.0 + 1e-6);
                    assert!(found.abs().cmple(half).all(), "{precision:?} {span}: {found} is not nearest");
                }
            }
        }
    }
}

/// Pitches as an integer of 2^-60 pitches. Exact for periods; a remainder loses what is below.
fn fine(pitches: f64) -> i128 {
    let whole = pitches.floor();
    ((whole as i128) << FINE) + ((pitches - whole) * 2f64.powi(FINE)).round() as i128
}

/// What is left of a difference after whole periods, half a period at most; all in 2^-60 pitches.
fn nearest(difference: i128, period: i128) -> i128 {
    if period == 0 {
        return difference;
    }
    let rest = difference.rem_euclid(period);
    if 2 * rest > period { rest - period } else { rest }
}

/// The largest error of differences in roundings of a pitch and of themselves.
fn worst(gpu: &Gpu, precision: Precision, lattice: Lattice, lengths: [Option<f64>; 3], points: &[DVec3]) -> f64 {
    let pitch = lattice.pitch();
    let periods = LatticePeriods::new(lattice, lengths).unwrap();
    let points = Points::of(precision, &lattice, points);
    let found = differences(gpu, precision, &periods, &points);
    let mut worst = 0.0_f64;
    for (k, found) in found.iter().enumerate().filter(|(k, _)| k % 4 < 3) {
        let (a, b) = (k / 4 * 8 + k % 4, k / 4 * 8 + 4 + k % 4);
        let cells = i128::from(points.cells[b]) - i128::from(points.cells[a]);
        let remainder = fine(points.remainders[b] / pitch) - fine(points.remainders[a] / pitch);
        let period = lengths[k % 4].map_or(0, |length| fine(length / pitch));
        let expected = nearest((cells << FINE) + remainder, period);
        let unit = 2f64.powi(-FINE);
        let off = fine(found / pitch) - expected;
        // At half a period the other image is as near.
        let off = if off.abs() * 2 > period && period > 0 { nearest(off, period) } else { off };
        let scale = precision.epsilon() * (1.0 + found.abs() / pitch);
        let roundings = off as f64 * unit / scale;
        assert!(roundings.abs() <= ROUNDINGS, "{precision:?} {lengths:?}: {found} is off by {roundings} roundings");
        let half = 0.5 * lengths[k % 4].unwrap_or(f64::INFINITY);
        assert!(found.abs() <= half * (1.0 + 4.0 * precision.epsilon()), "{precision:?} {lengths:?}: {found}");
        worst = worst.max(roundings.abs());
    }
    worst
}

#[test]
fn differences_lead_to_the_nearest_image_at_any_number_of_periods() {
    let Some(gpu) = device() else { return };
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for precision in precisions(gpu) {
        for thickness in [1.0, 3e-4] {
            let lattice = Lattice::for_thickness(thickness).unwrap();
            let (unit, reach) = (1024.0 * lattice.pitch(), lattice.pitch() * 1.07e9);
            let mut far = 0.0_f64;
            for period in [2.0, 10.0 / 3.0, 7.123_456_789, 64.0, 1e3 / 7.0, 1e5 / 3.0, 1.04e6] {
                // Spans from less than a period to all that there is.
                for span in [0.9 * unit * period, 40.0 * unit * period, 2.0 * reach] {
                    let span = span.min(2.0 * reach);
                    let mut draw = || DVec3::from(random.random::<[f64; 3]>()) - 0.5;
                    let mut points: Vec<DVec3> = (0..200).map(|_| span * draw()).collect();
                    // Neighbours through a boundary, and images within rounding of half a period.
                    for near in [1e-3, 0.4, 0.5 * period] {
                        for _ in 0..40 {
                            let (at, turns) = (0.4 * span * draw(), (0.4 * span * draw() / period / unit).round());
                            let by = turns * period * unit + near * unit * draw().signum();
                            points.extend([at, (at + by).clamp(DVec3::splat(-reach), DVec3::splat(reach))]);
                        }
                    }
                    let lengths = [Some(period * unit), None, Some(period * unit)];
                    far = far.max(worst(gpu, precision, lattice, lengths, &points));
                }
            }
            println!("{precision:?} {thickness}: {far:.2} roundings at most");
        }
    }
}

#[test]
fn at_half_a_period_the_even_image_is_taken() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let periods = LatticePeriods::new(lattice, [Some(8.0), Some(8.0), None]).unwrap();
    for precision in precisions(gpu) {
        for (x, expected) in [(4.0, 4.0), (-4.0, -4.0), (12.0, -4.0), (-12.0, 4.0), (20.0, 4.0), (8e5 + 4.0, 4.0)] {
            let points = [DVec3::new(0.5, -3.0, 0.0), DVec3::new(0.5 + x, -3.0 - x, x)];
            let points = Points::of(precision, &lattice, &points);
            let found = differences(gpu, precision, &periods, &points);
            assert_eq!(found[..3], [expected, -expected, x], "{precision:?}");
        }
    }
}

/// The kernels of separations, fed with the difference that they are fed with in a step.
const SEPARATIONS: &str = "
struct Parameters { count: u32, x: u32, y: u32, z: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> cells: array<vec4<i32>>;
@group(0) @binding(2) var<storage, read> remainders: array<vec4r>;
@group(0) @binding(3) var<storage, read> bodies: array<vec4r>;
@group(0) @binding(4) var<storage, read_write> out: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = invocation(group, groups, local);
    if i >= parameters.count { return; }
    let k = 2u * i;
    let delta = lattice_difference(cells[k].xyz, remainders[k].xyz, cells[k + 1u].xyz, remainders[k + 1u].xyz);
    let a = Placed(u32(bodies[2u * k].w), bodies[2u * k].xyz, bodies[2u * k + 1u]);
    let b = Placed(u32(bodies[2u * k + 2u].w), bodies[2u * k + 2u].xyz, bodies[2u * k + 3u]);
    let found = separate(delta, a, b, vec3r(0.0, 0.0, 0.0));
    out[3u * i] = vec4r(found.normal, found.separation);
    out[3u * i + 1u] = vec4r(found.lever_a, 0.0);
    out[3u * i + 2u] = vec4r(found.lever_b, 0.0);
}
";

fn separations(
    gpu: &Gpu,
    precision: Precision,
    lattice: &Lattice,
    periods: Periods,
    (families, poses): (PairFamilies, &[&Pose]),
) -> Vec<relcp::separation::Separation> {
    let on_lattice = LatticePeriods::new(*lattice, periods.lengths()).unwrap();
    let shapes: Vec<Shape> = poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape]).collect();
    let exponents = Exponents::of(&shapes);
    let source = exponents.add_to(on_lattice.define(Source::new("separations", precision)));
    let kernel = Kernel::new(gpu, &families.add_to(source, false).text(SEPARATIONS)).unwrap();
    let places: Vec<DVec3> = poses.iter().flat_map(|pose| [pose.a.position, pose.b.position]).collect();
    let [cells, remainders] = Points::of(precision, lattice, &places).buffers(gpu, precision);
    let body = |body: &Placed| [&exponents.numbers(&body.shape), &body.orientation.to_array()[..]].concat();
    let bodies = poses.iter().flat_map(|pose| [body(&pose.a), body(&pose.b)].concat());
    let bodies = Buffer::reals(gpu, "bodies", precision, 4, bodies).unwrap();
    let count = poses.len() as u64;
    let out = Buffer::new(gpu, "separations", 4 * precision.bytes(), 3 * count).unwrap();
    let mut record = gpu.record();
    let parameters = [count as u32, 0, 0, 0].map(u32::to_le_bytes).concat();
    record.run(&kernel, &parameters, &[&cells, &remainders, &bodies, &out], count);
    let read = record.read(&[(&out, 0..12 * count * precision.bytes() as u64)]).unwrap();
    let numbers = precision.decode(&read[0]);
    let vector = |v: &[f64; 12], k: usize| DVec3::from_slice(&v[4 * k..]);
    let found = |v: &[f64; 12]| relcp::separation::Separation {
        separation: v[3],
        normal: vector(v, 0),
        lever_a: vector(v, 1),
        lever_b: vector(v, 2),
    };
    numbers.as_chunks::<12>().0.iter().map(found).collect()
}

#[test]
fn separations_through_boundaries_are_those_of_the_nearest_image() {
    let Some(gpu) = device() else { return };
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for aspect in [3.0, 20.0] {
        let others = superellipsoids::near_contact(30, aspect);
        let poses = [poses::near_contact(60, aspect), poses::deep(20, aspect), others].concat();
        let longest = poses.iter().map(Pose::size).fold(0.0, f64::max);
        let periods = Periods::new([Some(2.0 * longest + 1.0 / 3.0), Some(2.3 * longest), Some(3.1 * longest)]);
        let thinnest = poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape]);
        let lattice = Lattice::for_thickness(thinnest.map(|s| Shape::thickness(&s)).fold(1.0, f64::min)).unwrap();
        // Anywhere within some cells, b at another image.
        let mut moved = poses.clone();
        for pose in &mut moved {
            let mut draw = || DVec3::from(random.random::<[f64; 3]>()) - 0.5;
            let (by, turns) = (4.0 * periods.length() * draw(), (5.0 * draw()).round());
            pose.a.position += by;
            pose.b.position += by + periods.length() * turns;
        }
        for precision in precisions(gpu) {
            let mut worst = [0.0_f64; 2];
            for families in PairFamilies::ALL {
                let of: Vec<&Pose> = moved.iter().filter(|pose| pose.families() == families).collect();
                assert!(!of.is_empty(), "{families:?}");
                for (pose, found) in of.iter().zip(separations(gpu, precision, &lattice, periods, (families, &of))) {
                    let [a, b] = periods.pair(pose.a, pose.b);
                    let pose = Pose::new(a, b);
                    let errors = Errors::of(&pose, &found, &separation(&a, &b, None).unwrap());
                    assert!(
                        errors.separation <= tolerance(precision),
                        "{precision:?} {pose:?} {found:?} {}",
                        errors.separation
                    );
                    assert!(errors.along <= tolerance(precision), "{precision:?} {pose:?} {found:?}");
                    worst = [worst[0].max(errors.separation), worst[1].max(errors.along)];
                }
            }
            println!("aspect {aspect}, {precision:?}: separation {:.1e}, along {:.1e}", worst[0], worst[1]);
        }
    }
}
