//! The sources of kernels: that they are valid, and what they depend on.

use crate::gpu::{Made, Precision, Source, validate};
use crate::lcp::SolverKind;
use crate::lcp::gpu::kernels::{Lcp, SMALL_WORKGROUP, SMALL_WORKGROUP_ON_SOFTWARE};
use crate::lcp::gpu::layout::{MOST_NUMBERS, MOST_VECTORS, Slots, Variant};
use crate::lcp::gpu::number::Number;
use crate::lcp::gpu::shape::{Shape, ShapeWork, StageArguments};
use crate::lcp::gpu::stage::{Action, Block, Stage};
use crate::lcp::gpu::straight::ELEMENT_WORDS;
use crate::lcp::gpu::tape::Tape;

fn check(source: &Source) {
    validate(&Lcp::sources(source.clone())[0])
        .unwrap_or_else(|e| panic!("{} {:?}: {e}", source.name(), source.precision()));
}

fn variants_of_friction() -> Vec<Variant> {
    let variant = |precision, planar| Variant {
        precision,
        planar,
        slots: Slots::of_friction(),
        small_workgroup: SMALL_WORKGROUP,
    };
    let of = |precision| [true, false].map(|planar| variant(precision, planar));
    [Precision::F32, Precision::F64].map(of).concat()
}

fn variants() -> Vec<Variant> {
    let mut all = Vec::new();
    for precision in [Precision::F32, Precision::F64] {
        for planar in [true, false] {
            for kind in [SolverKind::Auto, SolverKind::Bbpgd, SolverKind::ProjectedJacobi] {
                for small_workgroup in [SMALL_WORKGROUP, SMALL_WORKGROUP_ON_SOFTWARE] {
                    let slots = Slots::of(kind, precision);
                    all.push(Variant { precision, planar, slots, small_workgroup });
                }
            }
        }
    }
    all
}

#[test]
fn sources_are_valid() {
    for v in variants() {
        let common = [v.small(), v.prepare_rows(), v.prepare_entries()];
        common.iter().for_each(check);
        if v.slots.coupling.is_some() {
            check(&v.prepare_pairs());
        }
    }
    for v in variants_of_friction() {
        [v.prepare_rows(), v.prepare_entries(), v.prepare_pairs()].iter().for_each(check);
    }
}

#[test]
fn kernels_without_friction_know_nothing_of_it() {
    let of = |v: &Variant| [v.small(), v.prepare_rows(), v.prepare_entries(), v.stage(&Shape::default())];
    let words = ["friction", "COMPLIANCE_AT", "FOLLOW"];
    for source in variants().iter().flat_map(of) {
        assert!(words.iter().all(|word| !source.code().contains(word)), "{}", source.name());
    }
    for source in variants_of_friction().iter().map(|v| v.prepare_rows()) {
        assert!(words.iter().all(|word| source.code().contains(word)), "{}", source.name());
    }
}

#[test]
fn the_places_of_an_element_are_where_the_host_writes_them() {
    let variant = variants()[0];
    let module = validate(&variant.straight(&[Shape::default()])).unwrap();
    let places = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Places")).unwrap().1;
    let naga::TypeInner::Struct { members, span } = &places.inner else { panic!("Places is no struct") };
    let offsets: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
    let numbers = 4 * MOST_VECTORS / 4;
    let base = numbers + 4 * MOST_NUMBERS / 2;
    assert_eq!(offsets, [("vectors", 0), ("numbers", numbers), ("base", base), ("looks", base + 4)]);
    assert_eq!(*span as usize, 4 * ELEMENT_WORDS);
}

#[test]
fn another_tolerance_needs_no_other_kernel() {
    let shapes = |tolerance: f64| {
        let mut tape = Tape::new(true, false);
        let residual = tape.sum(Action::Residual, [7, 8, 9]);
        tape.look(residual, tolerance);
        tape.clusters(residual, [7, 8], tolerance, [12, 11]);
        let segment = tape.all();
        let shape = |stage: &Stage| StageArguments::of(tape.constants(), stage, &[]).shape;
        segment.stages.iter().map(shape).collect::<Vec<_>>()
    };
    assert_eq!(shapes(1e-3), shapes(1e-5));
}

#[test]
fn generated_sources_are_valid() {
    for exact in [false, true] {
        check_generated(exact, false);
    }
    check_generated(false, true);
}

fn check_generated(exact: bool, friction: bool) {
    let actions = if friction { Action::ALL.len() } else { Action::OF_ROWS };
    // All actions before and after pairs, and after a product, with constants and with computed scalars.
    let mut tape = Tape::new(true, exact);
    let computed = tape.sum(Action::Dot, [7, 8, 8]);
    let all = |tape: &mut Tape| {
        for action in Action::ALL.into_iter().take(actions) {
            if action.is_sum() {
                let sum = tape.sum(action, [7, 8, 9]);
                tape.look(-sum, 1.0);
            } else {
                tape.row(action, 10, [7, 8, 9], [computed, Number::Known(-1.5)]);
            }
        }
    };
    all(&mut tape);
    tape.pairs(Block { x: 7, w: None, g: Some(8), out: 11 });
    tape.pairs(Block { x: 7, w: Some(11), g: None, out: 11 });
    all(&mut tape);
    tape.product(7, None, 10, true);
    all(&mut tape);
    if !friction {
        tape.clusters(computed, [7, 8], 1e-6, [12, 11]);
        all(&mut tape);
    }
    tape.pairs(Block { x: 7, w: None, g: Some(8), out: 12 });
    let late = tape.sum(Action::Dot, [10, 10, 10]);
    tape.row(Action::CopyIf, 7, [8, 8, 7], [late, Number::Known(0.0)]);
    tape.product(7, None, 10, false);
    let segment = tape.all();
    let mut kinds = Vec::new();
    let mut arguments = Vec::new();
    for stage in &segment.stages {
        arguments.push(StageArguments::of(tape.constants(), stage, &kinds));
        kinds = Stage::kinds(stage);
    }
    let shapes = || arguments.iter().map(|arguments| &arguments.shape);
    assert!(shapes().any(Shape::has_block) && shapes().any(Shape::has_product) && shapes().any(Shape::looks));
    assert!(friction || (shapes().any(Shape::is_clusters) && shapes().any(Shape::gathers)));
    assert!(shapes().any(|shape| matches!(shape.work, ShapeWork::Bodies { instead: Some(_), .. })));
    if friction {
        for v in variants_of_friction() {
            shapes().for_each(|shape| check(&v.stage(shape)));
        }
        return;
    }
    for v in variants() {
        let has_blocks = v.slots.coupling.is_some();
        let possible = |shape: &&Shape| {
            (has_blocks || !(shape.has_block() || shape.is_clusters())) && (v.slots.low.is_some() || !shape.is_exact())
        };
        shapes().filter(possible).for_each(|shape| check(&v.stage(shape)));
        // In one workgroup, without the operations that only dispatches support.
        let alone = |shape: &&Shape| {
            let chooses = matches!(shape.work, ShapeWork::Bodies { instead: Some(_), .. });
            !shape.is_clusters() && !shape.gathers() && !chooses
        };
        let in_one: Vec<Shape> = shapes().filter(possible).filter(alone).cloned().collect();
        check(&v.straight(&in_one));
    }
}
