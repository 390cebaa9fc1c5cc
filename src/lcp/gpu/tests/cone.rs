//! Tests of `shaders/lcp/cone.wgsl` against `lcp::cone`, function by function.

use crate::gpu::{Buffer, Gpu, Kernel, Precision, Source, fragment, precisions, test_device};
use crate::lcp::cone;

/// The functions in the order of the results of the kernel for each triple.
const FUNCTIONS: [&str; 12] = [
    "project",
    "lack",
    "admit",
    "contains",
    "contains3",
    "is_free",
    "is_bound",
    "change_to_bound",
    "change",
    "allows",
    "room",
    "residual",
];

/// All functions of the triple x, d, s, where d is a change, a direction and a gap.
const TEXT: &str = "
@group(0) @binding(0) var<storage, read> triples: array<real>;
@group(0) @binding(1) var<storage, read_write> found: array<real>;

fn say(it: bool) -> real { return select(real(0.0), real(1.0), it); }

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) local: u32) {
    for (var nth = local; nth < TRIPLES; nth += WORKGROUP) {
        let x = triples[3u * nth];
        let d = triples[3u * nth + 1u];
        let s = triples[3u * nth + 2u];
        let out = FUNCTIONS * nth;
        found[out] = cone_project(x);
        found[out + 1u] = cone_lack(x);
        found[out + 2u] = cone_admit(x);
        found[out + 3u] = say(cone_contains(x));
        found[out + 4u] = say(cone_contains3(vec3r(x, x, d)));
        found[out + 5u] = say(cone_is_free(x));
        found[out + 6u] = say(cone_is_bound(x));
        found[out + 7u] = cone_change_to_bound(x);
        found[out + 8u] = cone_change(d, x);
        found[out + 9u] = say(cone_allows(d, x));
        found[out + 10u] = cone_room(x, d);
        found[out + 11u] = cone_residual(d, s, x);
    }
}
";

/// The results of the CPU for a triple. It has no functions for changes; their results follow from the other functions.
fn of_cpu([x, d, s]: [f64; 3]) -> [f64; FUNCTIONS.len()] {
    let say = |it: bool| f64::from(u8::from(it));
    [
        cone::project(x),
        cone::lack(x),
        cone::admit(x),
        say(cone::contains(x)),
        say(cone::contains(x) && cone::contains(d)),
        say(cone::is_free(x)),
        say(cone::is_bound(x)),
        -x,
        cone::project(x + d) - x,
        say(cone::contains(x + d)),
        cone::room(x, d),
        cone::residual(d, s, x),
    ]
}

fn of_device(gpu: &Gpu, precision: Precision, triples: &[[f64; 3]]) -> Vec<f64> {
    let source = Source::new("lcp-cone", precision)
        .integer("TRIPLES", triples.len() as u32)
        .integer("FUNCTIONS", FUNCTIONS.len() as u32)
        .include(fragment!("lcp/cone.wgsl"))
        .text(TEXT);
    let kernel = Kernel::new(gpu, &source).unwrap();
    let given = Buffer::reals(gpu, "triples", precision, 1, triples.as_flattened().iter().copied()).unwrap();
    let count = triples.len() * FUNCTIONS.len();
    let found = Buffer::new(gpu, "found", precision.bytes(), count as u64).unwrap();
    let mut record = gpu.record();
    record.run(&kernel, &[], &[&given, &found], 1);
    precision.decode(&record.read(&[(&found, 0..(count * precision.bytes()) as u64)]).unwrap()[0])
}

#[test]
fn the_cone_of_kernels_is_that_of_the_cpu() {
    let Some(gpu) = test_device() else { return };
    // Sums, products and quotients of these are exact in either precision.
    let mut triples = Vec::new();
    for x in [-3.0, -0.5, 0.0, 0.25, 0.75, 5.0] {
        for d in [-8.0, -0.5, -0.25, 0.0, 0.25, 2.0] {
            triples.extend([0.0, 0.5, 2.0].map(|s| [x, d, s]));
        }
    }
    for precision in precisions(gpu) {
        let made = of_device(gpu, precision, &triples);
        for (triple, made) in triples.iter().zip(made.chunks(FUNCTIONS.len())) {
            for ((name, wanted), made) in FUNCTIONS.iter().zip(of_cpu(*triple)).zip(made) {
                // The largest number of a kernel stands for infinity; a device may divide by a reciprocal.
                let same = if wanted.is_infinite() {
                    *made >= 3e38
                } else {
                    (made - wanted).abs() <= 4.0 * precision.epsilon() * wanted.abs()
                };
                assert!(same, "{} {name} of {triple:?}: {made:e}, not {wanted:e}", precision.name());
            }
        }
        // Values that are not finite are not multipliers.
        let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|x| [x, 0.0, 1.0]);
        let made = of_device(gpu, precision, &none);
        assert!(made.chunks(FUNCTIONS.len()).all(|made| made[2] == 0.0), "{}: {made:?}", precision.name());
    }
}
