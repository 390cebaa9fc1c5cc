//! Separations on the device against the reference pairs and the CPU's, in both precisions.

use crate::device::{device, precisions};
use glam::{DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Buffer, Gpu, Kernel, Precision, Source};
use relcp::separation::gpu::PairFamilies;
use relcp::separation::{Placed, Separation, bound, planar_separation, separation};
use relcp::shape::Shape;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Reads pairs as six vectors each and writes four: the separation, the lower bound at its normal, boxes and radii of body a.
const LIST: &str = "
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

/// A pair, and the old normal, zero for none.
#[derive(Clone, Copy, Debug)]
struct Pose {
    a: Placed,
    b: Placed,
    warm: DVec3,
}

impl Pose {
    fn new(a: Placed, b: Placed) -> Pose {
        Pose { a, b, warm: DVec3::ZERO }
    }

    fn delta(&self) -> DVec3 {
        self.b.position - self.a.position
    }

    fn size(&self) -> f64 {
        self.a.shape.bounding_radius() + self.b.shape.bounding_radius() + self.delta().length()
    }

    fn families(&self) -> PairFamilies {
        let (a, b) = (self.a.shape.code().0, self.b.shape.code().0);
        PairFamilies::ALL.into_iter().find(|pair| pair.is_of_families(a, b)).unwrap()
    }

    /// The pair's names, with the kinds of its shapes.
    fn kind(&self) -> String {
        format!("{} {}", self.a.shape.name(), self.b.shape.name())
    }

    fn encoded(&self) -> impl Iterator<Item = f64> {
        let (kind_a, sizes_a) = self.a.shape.code();
        let (kind_b, sizes_b) = self.b.shape.code();
        let [delta, warm] = [self.delta(), self.warm];
        [
            delta.extend(f64::from(kind_a)),
            DVec3::from_array(sizes_a).extend(f64::from(kind_b)),
            DVec4::from(self.a.orientation),
            DVec3::from_array(sizes_b).extend(0.0),
            DVec4::from(self.b.orientation),
            warm.extend(0.0),
        ]
        .into_iter()
        .flat_map(|v| v.to_array())
    }
}

/// What the kernel says of a pair.
#[derive(Clone, Copy, Debug)]
struct Answer {
    found: Separation,
    bound: f64,
    bounding_radius: f64,
    half_extents: DVec3,
}

fn source(pair: PairFamilies, precision: Precision, planar: bool) -> Source {
    pair.add_to(Source::new(pair.name(), precision), planar).text(LIST)
}

/// Runs the kernels of all pairs of families that the poses need. The answers are in the order of the poses.
fn answers(gpu: &Gpu, precision: Precision, planar: bool, poses: &[Pose]) -> Vec<Answer> {
    let mut answers = vec![None; poses.len()];
    for pair in PairFamilies::ALL {
        let chosen: Vec<usize> = (0..poses.len()).filter(|i| poses[*i].families() == pair).collect();
        if chosen.is_empty() {
            continue;
        }
        let kernel = Kernel::new(gpu, &source(pair, precision, planar)).unwrap();
        let numbers = chosen.iter().flat_map(|i| poses[*i].encoded());
        let pairs = Buffer::reals(gpu, "pairs", precision, 4, numbers).unwrap();
        let count = chosen.len() as u64;
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

/// Bounds of the errors: of separations and points as fractions of the size.
fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 2e-6,
        Precision::F64 => 1e-11,
    }
}

/// The largest error of each kind of pair.
#[derive(Default)]
struct Worst(BTreeMap<String, [f64; 5]>);

impl Worst {
    fn add(&mut self, kind: String, errors: [f64; 5]) {
        let worst = self.0.entry(kind).or_default();
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
    }

    fn print(&self, what: &str, precision: Precision) {
        for (kind, e) in &self.0 {
            let name = precision.name();
            println!(
                "{what} {name} {kind:32} separation {:.1e} along {:.1e} across {:.1e} normal {:.1e} lever {:.1e}",
                e[0], e[1], e[2], e[3], e[4]
            );
        }
    }
}

fn errors(pose: &Pose, answer: &Answer, expected: &Separation) -> [f64; 5] {
    let found = answer.found;
    let size = pose.size();
    let gap = pose.delta() + found.lever_b - found.lever_a;
    [
        (found.separation - expected.separation).abs() / size,
        (found.normal.dot(gap) - found.separation).abs() / size,
        (gap - found.normal * found.separation).length() / size,
        (found.normal - expected.normal).length(),
        (found.lever_a - expected.lever_a).length().max((found.lever_b - expected.lever_b).length()) / size,
    ]
}

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    turn(random) * DVec3::Z
}

fn shape(kind: &str, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        "sphere" => Shape::Sphere { radius: 0.5 * ratio() },
        "spherocylinder" => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        "ellipsoid" => Shape::Ellipsoid { radii: [0.5 * ratio(), 0.5, 0.5 * ratio()] },
        _ => Shape::Torus { major_radius: 1.0 + ratio(), minor_radius: 0.5 },
    }
}

/// All supported pairs of kinds, in both orders.
fn kinds() -> Vec<[&'static str; 2]> {
    let supported = |pair: &[&str; 2]| !matches!(*pair, ["torus", "ellipsoid"] | ["ellipsoid", "torus"]);
    KINDS.into_iter().flat_map(|a| KINDS.map(|b| [a, b])).filter(supported).collect()
}

/// Random pairs, `depth` thicknesses apart.
fn random_poses(count: usize, aspects: &[f64], depth: std::ops::Range<f64>, seed: u64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut poses = Vec::new();
    for pair in kinds() {
        for &aspect in aspects {
            for _ in 0..count {
                let mut place = |kind| Placed {
                    shape: shape(kind, aspect, &mut random),
                    position: direction(&mut random) * random.random_range(0.0..aspect),
                    orientation: turn(&mut random),
                };
                let (a, mut b) = (place(pair[0]), place(pair[1]));
                let target = random.random_range(depth.clone());
                for _ in 0..4 {
                    let s = separation(&a, &b, None).unwrap();
                    b.position += s.normal * (target - s.separation);
                }
                poses.push(Pose::new(a, b));
            }
        }
    }
    poses
}

#[test]
fn poses_near_contact_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for aspect in [3.0, 20.0, 100.0, 1000.0] {
        let poses = random_poses(400, &[aspect], -0.2..0.5, 7);
        for precision in precisions(gpu) {
            let mut worst = Worst::default();
            for (pose, answer) in poses.iter().zip(answers(gpu, precision, false, &poses)) {
                let expected = separation(&pose.a, &pose.b, None).unwrap();
                worst.add(pose.kind(), errors(pose, &answer, &expected));
            }
            worst.print(&format!("{aspect}"), precision);
        }
    }
}
