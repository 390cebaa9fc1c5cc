//! Separations on the device against the reference pairs and the CPU's, in both precisions.
//!
//! Errors are fractions of the size of a pair, both bounding radii and the distance of the centres. Separations, and the points along the
//! normal, are held to 2e-6 in 32 bits and to 1e-11 in 64. Points sideways and normals are only as well defined as the surfaces are curved:
//! a point of a disc of aspect 1000 moves by 1000 radii where its normal turns by one radian, and a normal at a tip the other way round.

mod poses;

use crate::device::{device, precisions};
use glam::{DQuat, DVec3, DVec4};
use poses::Pose;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Buffer, Gpu, Kernel, Precision, Source};
use relcp::separation::gpu::PairFamilies;
use relcp::separation::{Placed, Separation, bound, planar_separation, separation};
use relcp::shape::Shape;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::time::Instant;

/// Reads a pair as six vectors and writes four: the separation, the lower bound at its normal, and body a's radius and box.
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

/// What a kernel says of a pair.
#[derive(Clone, Copy, Debug)]
struct Answer {
    found: Separation,
    bound: f64,
    bounding_radius: f64,
    half_extents: DVec3,
}

fn encoded(pose: &Pose) -> impl Iterator<Item = f64> {
    let (kind_a, sizes_a) = pose.a.shape.code();
    let (kind_b, sizes_b) = pose.b.shape.code();
    [
        pose.delta().extend(f64::from(kind_a)),
        DVec3::from_array(sizes_a).extend(f64::from(kind_b)),
        DVec4::from(pose.a.orientation),
        DVec3::from_array(sizes_b).extend(0.0),
        DVec4::from(pose.b.orientation),
        pose.warm.extend(0.0),
    ]
    .into_iter()
    .flat_map(|v| v.to_array())
}

/// Runs the kernels that the poses need. The answers are in the order of the poses.
fn answers(gpu: &Gpu, precision: Precision, planar: bool, poses: &[Pose]) -> Vec<Answer> {
    let mut answers = vec![None; poses.len()];
    for pair in PairFamilies::needed(poses.iter().flat_map(|pose| [pose.a.shape, pose.b.shape])) {
        let chosen: Vec<usize> = (0..poses.len()).filter(|i| poses[*i].families() == pair).collect();
        let source = pair.add_to(Source::new(pair.name(), precision), planar).text(LIST);
        let kernel = Kernel::new(gpu, &source).unwrap();
        let count = chosen.len() as u64;
        let numbers = chosen.iter().flat_map(|i| encoded(&poses[*i]));
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
fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => 2e-6,
        Precision::F64 => 1e-11,
    }
}

#[derive(Clone, Copy, Default)]
struct Errors {
    separation: f64,
    /// The gap between the points along the normal, against the separation.
    along: f64,
    /// The gap between the points across the normal.
    across: f64,
    normal: f64,
    lever: f64,
}

impl Errors {
    fn of(pose: &Pose, found: &Separation, expected: &Separation) -> Errors {
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
struct Worst(BTreeMap<String, Errors>);

impl Worst {
    fn add(&mut self, kind: String, errors: Errors) {
        let worst = self.0.entry(kind).or_default();
        *worst = worst.max(errors);
    }

    fn print(&self, what: &str, precision: Precision) {
        let name = precision.name();
        for (kind, Errors { separation, along, across, normal, lever }) in &self.0 {
            println!(
                "{what}, {name}, {kind}: separation {separation:.1e}, along {along:.1e}, across {across:.1e}, normal {normal:.1e}, lever {lever:.1e}"
            );
        }
    }
}

/// Compares with the CPU. A normal or a point may differ from the CPU's where two places are equally near or nearly so: `ties` are the
/// fractions of the poses in which it may, in 32 and in 64 bits.
fn compare(gpu: &Gpu, what: &str, aspect: f64, ties: [f64; 2], poses: &[Pose]) {
    let expected: Vec<Separation> = poses.iter().map(|p| separation(&p.a, &p.b, None).unwrap()).collect();
    for precision in precisions(gpu) {
        let (mut worst, mut other, mut nearer) = (Worst::default(), 0, 0);
        for ((pose, answer), expected) in poses.iter().zip(answers(gpu, precision, false, poses)).zip(&expected) {
            let mut errors = Errors::of(pose, &answer.found, expected);
            let limit = tolerance(precision);
            if is_nearer(pose, &answer.found, expected, limit) {
                (nearer, errors) = (nearer + 1, Errors::default());
            }
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
        println!("{what}, {}: another normal or point in {other} of {count}, nearer in {nearer}", precision.name());
        let ties = ties[usize::from(precision == Precision::F64)];
        assert!(other as f64 <= ties * count as f64 && nearer * 100 <= count, "{other} {nearer} {count}");
    }
}

/// Whether the points found are on both curves of a ring and another body, and nearer to each other than the CPU's: its search of a
/// ring in whose plane a rod lies can end at the centre.
fn is_nearer(pose: &Pose, found: &Separation, expected: &Separation, limit: f64) -> bool {
    let off = |body: &Placed, lever: DVec3| {
        let p = body.orientation.inverse() * lever;
        match body.shape {
            Shape::Torus { major_radius, .. } => (p.x.hypot(p.y) - major_radius).hypot(p.z),
            Shape::Spherocylinder { diameter, length } => {
                let half = 0.5 * (length - diameter);
                (p - DVec3::Z * p.z.clamp(-half, half)).length()
            }
            _ => p.length(),
        }
    };
    let on_surface =
        |body: &Placed, lever| (off(body, lever) - 0.5 * body.shape.thickness()).abs() <= limit * pose.size();
    !pose.is_convex()
        && found.separation < expected.separation - limit * pose.size()
        && on_surface(&pose.a, found.lever_a)
        && on_surface(&pose.b, found.lever_b)
}

/// A unit normal, points that agree with the separation along it, a lower bound that is one, the body's radius and box.
fn check_sound(pose: &Pose, answer: &Answer, precision: Precision, aspect: f64) {
    let limit = tolerance(precision);
    let (found, size) = (answer.found, pose.size());
    let errors = Errors::of(pose, &found, &found);
    assert!((found.normal.length() - 1.0).abs() <= 8.0 * precision.epsilon(), "{precision:?} {pose:?} {answer:?}");
    assert!(errors.along <= limit, "{precision:?} {pose:?} {answer:?} {}", errors.along);
    assert!(errors.across <= limit * (1.0 + aspect / 50.0), "{precision:?} {pose:?} {answer:?} {}", errors.across);
    assert!((answer.bound - bound(&pose.a, &pose.b, found.normal)).abs() <= limit * size, "{pose:?} {answer:?}");
    assert!(answer.bound <= found.separation + limit * size, "{precision:?} {pose:?} {answer:?}");
    let a = &pose.a;
    let radius = a.shape.bounding_radius();
    assert!((answer.bounding_radius - radius).abs() <= precision.epsilon() * radius);
    let off = (answer.half_extents - a.shape.half_extents(a.orientation)).abs().max_element();
    assert!(off <= 8.0 * precision.epsilon() * radius, "{precision:?} {a:?} {:?}", answer.half_extents);
}

/// A reference pair, computed in extended precision.
#[derive(Deserialize)]
struct Reference {
    kind: String,
    a: Body,
    b: Body,
    normal: [f64; 3],
    separation: f64,
    point_a: Option<[f64; 3]>,
    point_b: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Body {
    shape: Shape,
    position: [f64; 3],
    orientation: [f64; 4],
}

impl Body {
    fn placed(&self) -> Placed {
        let [w, x, y, z] = self.orientation;
        let orientation = DQuat::from_xyzw(x, y, z, w).normalize();
        Placed { shape: self.shape, position: DVec3::from_array(self.position), orientation }
    }
}

#[test]
fn reference_pairs_agree() {
    let Some(gpu) = device() else { return };
    let pairs: Vec<Reference> = serde_json::from_str(include_str!("../data/pairs.json")).unwrap();
    assert_eq!(pairs.len(), 868);
    let cold: Vec<Pose> = pairs.iter().map(|p| Pose::new(p.a.placed(), p.b.placed())).collect();
    let normals = pairs.iter().map(|p| DVec3::from_array(p.normal));
    let warm: Vec<Pose> = cold.iter().zip(normals).map(|(pose, warm)| Pose { warm, ..*pose }).collect();
    for (precision, (what, poses)) in
        precisions(gpu).into_iter().flat_map(|p| [("cold", &cold), ("warm", &warm)].map(|w| (p, w)))
    {
        let mut worst = Worst::default();
        for ((p, pose), answer) in pairs.iter().zip(poses).zip(answers(gpu, precision, false, poses)) {
            let lever = |body: &Placed, point: Option<[f64; 3]>, found: DVec3| {
                point.map_or(found, |point| DVec3::from_array(point) - body.position)
            };
            let expected = Separation {
                separation: p.separation,
                normal: DVec3::from_array(p.normal),
                lever_a: lever(&pose.a, p.point_a, answer.found.lever_a),
                lever_b: lever(&pose.b, p.point_b, answer.found.lever_b),
            };
            let errors = Errors::of(pose, &answer.found, &expected);
            assert!(errors.separation <= tolerance(precision), "{precision:?} {pose:?} {answer:?} {expected:?}");
            // The rings' reference normals have seven digits.
            let limits = if precision == Precision::F32 { [2e-5, 2e-6] } else { [2e-7, 2e-8] };
            assert!(errors.normal <= limits[0], "{precision:?} {} {pose:?} {answer:?} {}", p.kind, errors.normal);
            assert!(errors.lever <= limits[1], "{precision:?} {} {pose:?} {answer:?} {}", p.kind, errors.lever);
            check_sound(pose, &answer, precision, 100.0);
            worst.add(p.kind.clone(), errors);
        }
        worst.print(what, precision);
    }
}

#[test]
fn pairs_near_contact_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for aspect in [3.0, 20.0, 100.0, 1000.0] {
        compare(
            gpu,
            &format!("near contact, aspect {aspect}"),
            aspect,
            [2e-3, 2e-3],
            &poses::near_contact(600, aspect),
        );
    }
}

#[test]
fn deep_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for aspect in [3.0, 20.0, 100.0, 1000.0] {
        compare(gpu, &format!("deep, aspect {aspect}"), aspect, [5e-3, 5e-3], &poses::deep(200, aspect));
    }
}

#[test]
fn rings_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    compare(gpu, "rings", 100.0, [0.5, 0.35], &poses::rings(3000));
}

#[test]
fn degenerate_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    compare(gpu, "degenerate", 1000.0, [0.2, 0.2], &poses::degenerate());
}

#[test]
fn what_geometry_leaves_open_follows_the_same_rules() {
    let Some(gpu) = device() else { return };
    let (names, poses): (Vec<&str>, Vec<Pose>) = poses::ruled().into_iter().unzip();
    for precision in precisions(gpu) {
        let limit = if precision == Precision::F32 { 1e-5 } else { 1e-10 };
        for ((name, pose), answer) in names.iter().zip(&poses).zip(answers(gpu, precision, false, &poses)) {
            let expected = separation(&pose.a, &pose.b, None).unwrap();
            let errors = Errors::of(pose, &answer.found, &expected);
            assert!(errors.separation <= limit, "{name}: {precision:?} {answer:?} {expected:?}");
            assert!(errors.normal <= limit && errors.lever <= limit, "{name}: {precision:?} {answer:?} {expected:?}");
        }
    }
}

#[test]
fn a_warm_normal_changes_no_more_than_rounding() {
    let Some(gpu) = device() else { return };
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let poses = [poses::near_contact(40, 100.0), poses::deep(40, 20.0)].concat();
    for precision in precisions(gpu) {
        let cold = answers(gpu, precision, false, &poses);
        for round in 0..3 {
            let mut warm = poses.clone();
            for (pose, answer) in warm.iter_mut().zip(&cold) {
                let off = poses::direction(&mut random);
                pose.warm = [answer.found.normal, (answer.found.normal + off * 0.1).normalize(), off][round];
            }
            for ((pose, warm), cold) in warm.iter().zip(answers(gpu, precision, false, &warm)).zip(&cold) {
                let change = (warm.found.separation - cold.found.separation).abs();
                assert!(change <= tolerance(precision) * pose.size(), "{precision:?} {pose:?} {warm:?} {cold:?}");
            }
        }
    }
}

#[test]
fn planar_pairs_agree_with_the_cpu() {
    let Some(gpu) = device() else { return };
    for (precision, aspect) in precisions(gpu).into_iter().flat_map(|p| [3.0, 20.0, 100.0].map(|aspect| (p, aspect))) {
        let poses = poses::planar(200, aspect);
        let limit = tolerance(precision);
        let (mut worst, mut better, mut other) = (Worst::default(), 0, 0);
        for (pose, answer) in poses.iter().zip(answers(gpu, precision, true, &poses)) {
            let expected = planar_separation(&pose.a, &pose.b, None).unwrap();
            let mut errors = Errors::of(pose, &answer.found, &expected);
            if pose.is_convex() {
                assert!(answer.found.normal.z == 0.0, "{precision:?} {pose:?} {answer:?}");
                assert!((answer.bound - answer.found.separation).abs() <= limit * pose.size(), "{pose:?} {answer:?}");
                // The CPU's search in the plane places a normal to the root of a rounding.
                let turned = if precision == Precision::F32 { 1e-4 } else { 1e-6 };
                other += usize::from(errors.normal > turned);
                // The CPU samples the angles too; a larger maximum in the plane, which the bound confirms, is the better one.
                if answer.found.separation > expected.separation + limit * pose.size() {
                    (better, errors.separation) = (better + 1, 0.0);
                }
            }
            assert!(errors.separation <= limit, "{precision:?} {pose:?} {answer:?} {expected:?}");
            check_sound(pose, &answer, precision, aspect);
            worst.add(pose.kind(), errors);
        }
        worst.print(&format!("planar, aspect {aspect}"), precision);
        let count = poses.len();
        println!(
            "planar, {}: another normal in {other} of {count}, larger than the CPU's in {better}",
            precision.name()
        );
        assert!(other * 500 <= count && better * 100 <= count);
    }
}

/// With `MESA_SHADER_CACHE_DISABLE=true` these are the times that a first run takes.
#[test]
fn kernels_compile_in_seconds() {
    let Some(gpu) = device() else { return };
    let poses = poses::near_contact(1, 2.0);
    for precision in precisions(gpu) {
        for (pair, planar) in PairFamilies::ALL.into_iter().flat_map(|pair| [(pair, false), (pair, true)]) {
            let pose = poses.iter().find(|pose| pose.families() == pair && pose.a.shape.name() == pose.b.shape.name());
            let pose = pose.or(poses.iter().find(|pose| pose.families() == pair)).unwrap();
            let source = pair.add_to(Source::new(pair.name(), precision), planar).text(LIST);
            let begun = Instant::now();
            let kernel = Kernel::new(gpu, &source).unwrap();
            let pairs = Buffer::reals(gpu, "pair", precision, 4, encoded(pose)).unwrap();
            let out = Buffer::new(gpu, "separation", 4 * precision.bytes(), 4).unwrap();
            let mut record = gpu.record();
            record.run(&kernel, &[1, 0, 0, 0].map(u32::to_le_bytes).concat(), &[&pairs, &out], 1);
            record.read(&[(&out, 0..16)]).unwrap();
            let seconds = begun.elapsed().as_secs_f64();
            println!("{}, planar {planar}, {}: compiled and run once in {seconds:.2} s", precision.name(), pair.name());
            assert!(seconds < 20.0);
        }
    }
}
