//! Fields that cells take up and grow by: Monod's law, balances, borders, two parts of a run, and a device.

use crate::device::{device, precisions};
use crate::scenes::{in_two_parts, parse, refusal, run};
use relcp::bodies::Bodies;
use relcp::fields::Concentration;
use relcp::record::state_hash;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

const HALF: f64 = 0.5;
const RATE: f64 = 0.7;

/// A cell of length 1.2 that does not divide before length 50, in the middle of a grid.
fn alone(field: &Value, (dt, end): (f64, f64)) -> Value {
    json!({"name": "fed", "planar": true, "time": {"dt": dt, "end": end}, "dynamics": {"overdamped": {"drag": 1.0}},
        "fields": {"food": field},
        "growth": {"rate": RATE, "division_length": 50.0, "nutrient": {"field": "food", "half": HALF}},
        "generate": [{"founder": {"diameter": 0.5, "length": 1.2}}]})
}

/// A colony in a plane whose border has plenty.
fn colony(end: f64) -> Value {
    json!({"name": "fed", "planar": true, "time": {"dt": 0.02, "end": end}, "dynamics": {"overdamped": {"drag": 1.0}},
        "fields": {"food": {"cells": [12, 12, 1], "spacing": 1.0, "diffusion": 1.0, "initial": 1.0,
            "boundary": {"x": [{"value": 1}, {"value": 1}], "y": [{"value": 1}, {"value": 1}]},
            "exchange": [{"uptake": 2.0, "half": HALF}]}},
        "growth": {"rate": RATE, "division_length": 2.0, "reorientation_degrees": 8,
            "nutrient": {"field": "food", "half": HALF}},
        "generate": [{"founder": {"diameter": 0.5, "length": 1.2}}]})
}

fn length(bodies: &Bodies) -> f64 {
    bodies.shape[0].growing_length().unwrap()
}

#[test]
fn a_cell_grows_by_monods_law() {
    for concentration in [0.0, 0.05, 0.5, 20.0] {
        let field = json!({"cells": [6, 6, 1], "spacing": 2.0, "diffusion": 1.0, "initial": concentration});
        let end = run(parse(&alone(&field, (0.01, 2.0))), &Compute::Cpu).bodies;
        let expected = 1.2 * (RATE * concentration / (HALF + concentration) * 2.0).exp();
        assert!((length(&end) / expected - 1.0).abs() < 1e-12, "{concentration}: {} {expected}", length(&end));
    }
}

/// The steady state between two borders is a straight line.
#[test]
fn between_two_borders_a_field_becomes_a_straight_line() {
    let field = json!({"cells": [40, 3, 1], "spacing": 0.25, "diffusion": 5.0,
        "boundary": {"x": [{"value": 2}, {"value": 1}]}});
    let mut of = alone(&field, (0.5, 400.0));
    of.as_object_mut().unwrap().retain(|key, _| key != "growth" && key != "generate");
    of["bodies"] = json!([{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0]}]);
    let state = run(parse(&of), &Compute::Cpu);
    let Concentration { grid, values, .. } = &state.fields[0];
    for (cell, value) in values.iter().enumerate() {
        let expected = 1.5 - 0.1 * grid.center_of(cell)[0];
        assert!((value - expected).abs() < 1e-9, "{cell}: {value} {expected}");
    }
}

/// What cells take from a closed grid is missing there, and with a yield it is what they gained.
#[test]
fn what_is_taken_up_is_missing_in_a_closed_grid() {
    let mut of = colony(4.0);
    of["fields"]["food"].as_object_mut().unwrap().remove("boundary");
    of["fields"]["food"]["exchange"] = json!([{"uptake": 0.1, "half": 1e-9}]);
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    let amount = |simulation: &Simulation| simulation.state().unwrap().fields[0].amount(true);
    let (start, mut taken) = (amount(&simulation), 0.0);
    while !simulation.done() {
        let before = amount(&simulation);
        simulation.step().unwrap();
        // Far above `half`, the uptake is that of all bodies at the step's end.
        let bodies = &simulation.state().unwrap().bodies;
        let area: f64 = bodies.shape.iter().zip(&bodies.orientation).map(|(shape, q)| shape.section(*q)).sum();
        let expected = 0.1 * area * 0.02;
        taken += expected;
        assert!((before - amount(&simulation) - expected).abs() < 1e-7 * expected + 1e-9, "{expected}");
    }
    assert!((start - amount(&simulation) - taken).abs() < 1e-6, "{taken}");
    assert!(simulation.bodies() == 4 && taken > 0.3, "{taken}");
}

#[test]
fn cells_inside_of_a_colony_grow_more_slowly_than_those_at_its_rim() {
    let end = run(parse(&colony(9.0)), &Compute::Cpu);
    let Concentration { grid, values, .. } = &end.fields[0];
    let middle = values[6 * 12 + 6];
    assert!(grid.len() == 144 && values.iter().all(|value| (0.0..=1.0).contains(value)));
    assert!(end.bodies.len() > 20 && middle < 0.25 && values[0] > 0.9, "{} {middle}", end.bodies.len());
    // Fewer than cells with plenty would be.
    let mut plenty = colony(9.0);
    plenty["fields"]["food"]["exchange"] = json!([]);
    let free = run(parse(&plenty), &Compute::Cpu).bodies.len();
    assert!(free > end.bodies.len(), "{free} {}", end.bodies.len());
}

#[test]
fn runs_with_fields_resume_to_the_same_bits_and_their_ends_are_scenes() {
    let of = parse(&colony(3.0));
    let whole = run(of.clone(), &Compute::Cpu);
    assert_eq!(whole.fields.len(), 1);
    assert!(in_two_parts(&of, &Compute::Cpu) == whole);
    let mut simulation = Simulation::builder(of).resume(whole.clone()).build().unwrap();
    let end = simulation.final_scene().unwrap();
    let again = Scene::parse(&serde_json::to_string(&end).unwrap(), "end").unwrap();
    assert_eq!(again.fields["food"].values, whole.fields[0].values);
    assert!(simulation.step().is_ok());
}

#[test]
fn a_device_feeds_cells_as_the_cpu_does_and_resumes_to_the_same_bits() {
    let Some(gpu) = device() else { return };
    let of = parse(&colony(3.0));
    let cpu = run(of.clone(), &Compute::Cpu);
    for precision in precisions(gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let found = run(of.clone(), &compute);
        let pairs = || found.fields[0].values.iter().zip(&cpu.fields[0].values);
        let off = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{precision:?}: {} cells, concentrations within {off:.1e}", found.bodies.len());
        assert_eq!(found.bodies.len(), cpu.bodies.len());
        assert!(off < 1e-3, "{precision:?}: {off:e}");
        assert_eq!(state_hash(&in_two_parts(&of, &compute)), state_hash(&found), "{precision:?}");
    }
}

#[test]
fn fields_that_mean_nothing_are_refused_with_their_keys() {
    let refuse = |key: &str, change: &dyn Fn(&mut Value)| {
        let mut of = colony(1.0);
        change(&mut of);
        let (found, message) = refusal(&of);
        assert_eq!(found, key, "{message}");
    };
    let food = |of: &mut Value, key: &str, value: Value| of["fields"]["food"][key] = value;
    refuse("fields.food.cells.0", &|of| food(of, "cells", json!([0, 1, 1])));
    refuse("fields.food.cells.2", &|of| food(of, "cells", json!([4, 4, 4])));
    refuse("fields.food.cells", &|of| food(of, "cells", json!([100_000, 100_000, 1])));
    refuse("fields.food.spacing", &|of| food(of, "spacing", json!(0)));
    refuse("fields.food.diffusion", &|of| food(of, "diffusion", json!(-1)));
    refuse("fields.food.decay", &|of| food(of, "decay", json!(-0.1)));
    refuse("fields.food.initial", &|of| food(of, "initial", json!(-1)));
    refuse("fields.food.values", &|of| food(of, "values", json!([1, 2])));
    refuse("fields.food.boundary.x.1.value", &|of| food(of, "boundary", json!({"x": ["closed", {"value": -1}]})));
    refuse("fields.food.boundary.z.0", &|of| food(of, "boundary", json!({"z": [{"value": 1}, "closed"]})));
    refuse("fields.food.exchange.0.half", &|of| food(of, "exchange", json!([{"uptake": 1}])));
    refuse("fields.food.exchange.0.half", &|of| food(of, "exchange", json!([{"secretion": 1, "half": 1}])));
    refuse("fields.food.exchange.0", &|of| food(of, "exchange", json!([{}])));
    refuse("fields.food.exchange.0.secretion", &|of| {
        food(of, "exchange", json!([{"uptake": 1, "half": 1, "secretion": 1}]));
    });
    refuse("fields.food.exchange.0.group", &|of| food(of, "exchange", json!([{"secretion": 1, "group": "none"}])));
    refuse("fields.a b", &|of| of["fields"]["a b"] = of["fields"]["food"].clone());
    refuse("growth.nutrient.field", &|of| of["growth"]["nutrient"]["field"] = json!("none"));
    refuse("growth.nutrient.half", &|of| of["growth"]["nutrient"]["half"] = json!(0));
    refuse("fields.food.cells.0", &|of| of["periodic"] = json!({"lengths": [13, null, null]}));
    refuse("periodic", &|of| {
        of["periodic"] = json!({"lengths": [12, null, null], "strain_rate": [0.1, 0, 0]});
    });
}
