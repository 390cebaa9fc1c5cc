//! Runs the kernels on lists of pairs and measures their errors.

use super::poses::Pose;
use crate::device::precisions;
use glam::{DVec3, DVec4};
use relcp::gpu::{Gpu, Precision};
use relcp::internals::gpu::{Buffer, Kernel, Source};
use relcp::internals::separation::gpu::{Exponents, PairFamilies};
use relcp::separation::{Separation, bound, separation};
use relcp::shape::Shape;
use std::collections::BTreeMap;

/// Reads a pair as six vectors and writes four: the separation, the lower bound at its normal, and body a's radius and
/// box.
pub const LIST: &str = "
struct Parameters { count: u32, x: u32, y: u32, z: u32 }
@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec4r>;
@group(0) @binding(2) var<storage, read_write> out: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let i = invocation(group, groups, local);
    if i >= parameters.count { return; }
    let delta = pairs[6u * i].xyz;
    let a = Placed(u32(pairs[6u * i].w), pairs[6u * i + 1u].xyz, pairs[6u * i + 2u]);
    let b = Placed(u32(pairs[6u * i + 1u].w), pairs[6u * i + 3u].xyz, pairs[6u * i + 4u]);
    var found = separate(delta, a, b, pairs[6u * i + 5u].xyz);
    if !is_of_families(a.kind, b.kind) { found.separation = HUGE; }
    out[4u * i] = vec4r(found.normal, found.separation);
    out[4u * i + 1u] = vec4r(found.lever_a, bound(delta, a, b, found.normal));
    out[4u * i + 2u] = vec4r(found.lever_b, bounding_radius(a));
    out[4u * i + 3u] = vec4r(half_extents(a), 0.0);
}
";

/// What a kernel says of a pair.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    pub found: Separation,
    pub bound: f64,
    pub bounding_radius: f64,
    pub half_extents: DVec3,
}

pub fn encoded(exponents: &Exponents, pose: &Pose) -> impl Iterator<Item = f64> + use<> {
    let [a, b] = [pose.a.shape, pose.b.shape].map(|shape| DVec4::from_array(exponents.numbers(&shape)));
    [
        pose.delta().extend(a.w),
        a.truncate().extend(b.w),
        DVec4::from(pose.a.orientation),
        b.truncate().extend(0.0),
        DVec4::from(pose.b.orientation),
        pose.warm.extend(0.0),
    ]
    .into_iter()
    .flat_map(|v| v.to_array())
}

/// Runs the kernels that the poses need. The answers are in the order of the poses.
pub fn answers(gpu: &Gpu, precision: Precision, planar: bool, poses: &[Pose]) -> Vec<Answer> {
    let mut answers = vec![None; poses.len()];
    let shapes: Vec<Shape> = poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape]).collect();
    let exponents = Exponents::of(&shapes);
    for pair in PairFamilies::needed(poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape])) {
        let chosen: Vec<usize> = (0..poses.len()).filter(|i| poses[*i].families() == pair).collect();
        let source = exponents.add_to(Source::new(pair.name(), precision));
        let source = pair.add_to(source, planar).text(LIST);
        let kernel = Kernel::new(gpu, &source).unwrap();
        let count = chosen.len() as u64;
        let numbers = chosen.iter().flat_map(|i| encoded(&exponents, &poses[*i]));
        let pairs = Buffer::reals(gpu, "pairs", precision, 4, numbers).unwrap();
        let out = Buffer::new(gpu, "separations", 4 * precision.bytes(), 4 * count).unwrap();
        let mut record = gpu.record();
        let parameters: Vec<u8> = [count as u32, 0, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
        record.run(&kernel, &parameters, &[&pairs, &out], count);
        let read = record.read(&[(&out, 0..16 * count * precision.bytes() as u64)]).unwrap();
        let numbers = precision.decode(&read[0]);
        for (i, v) in chosen.into_iter().zip(numbers.as_chunks::<16>().0) {
            let vector = |k: usize| DVec3::from_slice(&v[4 * k..]);
            let found = Separation { separation: v[3], normal: vector(0), lever_a: vector(1), lever_b: vector(2) };
            answers[i] = Some(Answer { found, bound: v[7], bounding_radius: v[11], half_extents: vector(3) });
        }
    }
    answers.into_iter().map(Option::unwrap).collect()
}

/// The largest error allowed of a separation, and of the points along the normal.
pub fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 2e-6,
        Precision::F64 => 1e-11,
    }
}

/// What points may be apart across the normal, as a part of the sizes. An NVIDIA H200, which need not round roots and
/// quotients rightly, takes 3.4e-6 of aspect 1000; lavapipe, which does, less than 2e-6.
fn across(precision: Precision, aspect: f64) -> f64 {
    let limit = match precision {
        Precision::F32 => 5e-6,
        Precision::F64 => 1e-11,
    };
    limit * (1.0 + aspect / 50.0)
}

#[derive(Clone, Copy, Default)]
pub struct Errors {
    pub separation: f64,
    /// The gap between the points along the normal, against the separation.
    pub along: f64,
    /// The gap between the points across the normal.
    pub across: f64,
    pub normal: f64,
    pub lever: f64,
}

impl Errors {
    pub fn of(pose: &Pose, found: &Separation, expected: &Separation) -> Errors {
        let gap = pose.delta() + found.lever_b - found.lever_a;
        let along = found.normal.dot(gap);
        let levers = (found.lever_a - expected.lever_a).length().max((found.lever_b - expected.lever_b).length());
        Errors {
            separation: (found.separation - expected.separation).abs() / pose.size(),
            along: (along - found.separation).abs() / pose.size(),
            across: (gap - found.normal * along).length() / pose.size(),
            normal: (found.normal - expected.normal).length(),
            lever: levers / pose.size(),
        }
    }

    /// Element by element; what is not a number stays so.
    fn max(self, other: Errors) -> Errors {
        let max = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
        Errors {
            separation: max(self.separation, other.separation),
            along: max(self.along, other.along),
            across: max(self.across, other.across),
            normal: max(self.normal, other.normal),
            lever: max(self.lever, other.lever),
        }
    }
}

/// The largest errors of each kind of pair.
#[derive(Default)]
pub struct Worst(BTreeMap<String, Errors>);

impl Worst {
    pub fn add(&mut self, kind: String, errors: Errors) {
        let worst = self.0.entry(kind).or_default();
        *worst = worst.max(errors);
    }

    pub fn print(&self, what: &str, precision: Precision) {
        let name = precision.name();
        for (kind, Errors { separation, along, across, normal, lever }) in &self.0 {
            println!(
                "{what}, {name}, {kind}: separation {separation:.1e}, along {along:.1e}, across {across:.1e}, normal {normal:.1e}, lever {lever:.1e}"
            );
        }
    }
}

/// Compares with the CPU. A normal or a point may differ from the CPU's where two places are equally near or nearly so:
/// `ties` are the fractions of the poses in which it may, in 32 and in 64 bits.
pub fn compare(gpu: &Gpu, what: &str, aspect: f64, ties: [f64; 2], poses: &[Pose]) {
    let expected: Vec<Separation> = poses.iter().map(|p| separation(&p.a, &p.b, None).unwrap()).collect();
    for precision in precisions(gpu) {
        let (mut worst, mut other) = (Worst::default(), 0);
        for ((pose, answer), expected) in poses.iter().zip(answers(gpu, precision, false, poses)).zip(&expected) {
            let errors = Errors::of(pose, &answer.found, expected);
            let limit = tolerance(precision);
            assert!(errors.separation <= limit, "{what} {precision:?} {pose:?} {answer:?} {expected:?}");
            check_sound(pose, &answer, precision, aspect);
            // Roundings turn a normal by as much as the curvature of the most curved places makes them.
            let turned = 30.0 * precision.epsilon() * aspect.powf(1.5);
            if errors.normal <= turned && errors.lever <= limit * (1.0 + aspect / 50.0) {
                worst.add(pose.kind(), errors);
            } else {
                other += 1;
                worst.add(pose.kind(), Errors { normal: 0.0, lever: 0.0, ..errors });
            }
        }
        worst.print(what, precision);
        let count = poses.len();
        println!("{what}, {}: another normal or point in {other} of {count}", precision.name());
        let ties = ties[usize::from(precision == Precision::F64)];
        assert!(other as f64 <= ties * count as f64, "{other} {count}");
    }
}

/// A unit normal, points that agree with the separation along it, a lower bound that is one, the body's radius and box.
pub fn check_sound(pose: &Pose, answer: &Answer, precision: Precision, aspect: f64) {
    let limit = tolerance(precision);
    let (found, size) = (answer.found, pose.size());
    let errors = Errors::of(pose, &found, &found);
    assert!((found.normal.length() - 1.0).abs() <= 8.0 * precision.epsilon(), "{precision:?} {pose:?} {answer:?}");
    assert!(errors.along <= limit, "{precision:?} {pose:?} {answer:?} {}", errors.along);
    assert!(errors.across <= across(precision, aspect), "{precision:?} {pose:?} {answer:?} {}", errors.across);
    assert!((answer.bound - bound(&pose.a, &pose.b, found.normal)).abs() <= limit * size, "{pose:?} {answer:?}");
    assert!(answer.bound <= found.separation + limit * size, "{precision:?} {pose:?} {answer:?}");
    let a = &pose.a;
    let radius = a.shape.bounding_radius();
    assert!((answer.bounding_radius - radius).abs() <= precision.epsilon() * radius);
    let off = (answer.half_extents - a.shape.half_extents(a.orientation)).abs().max_element();
    assert!(off <= 8.0 * precision.epsilon() * radius, "{precision:?} {a:?} {:?}", answer.half_extents);
}
