//! Bonds that divisions make and daughters inherit: chains of cells.

use crate::scenes::{in_two_parts, parse, refusal, run};
use glam::DVec3;
use relcp::Shape;
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

const DIAMETER: f64 = 0.5;
/// The default gap.
const GAP: f64 = 0.01 * DIAMETER;

/// One cell that divides at the length 2, four times in all by the time 2.6.
pub fn founder(bond: &Value, degrees: f64, planar: bool) -> Value {
    json!({"name": "chain", "planar": planar, "time": {"dt": 0.02, "end": 2.6}, "dynamics": {"overdamped": {"drag": 1.0}},
        "growth": {"rate": 1.0, "division_length": 2.0, "reorientation_degrees": degrees, "bond_daughters": bond},
        "generate": [{"founder": {"diameter": DIAMETER, "length": 1.8}}]})
}

/// The bonds of a state, from an upper end to a lower one.
pub fn bonds(bodies: &Bodies) -> Vec<[usize; 2]> {
    let column = |name: &str| bodies.columns.get(name).map_or(vec![0.0; bodies.len()], <[f64]>::to_vec);
    let (lower, upper) = (column("lower_bond"), column("upper_bond"));
    let partner = |a: usize| (0..bodies.len()).find(|b| upper[a] > 0.0 && lower[*b] == upper[a]).map(|b| [a, b]);
    (0..bodies.len()).filter_map(partner).collect()
}

fn length(bodies: &Bodies, i: usize) -> f64 {
    let Shape::Spherocylinder { length, .. } = bodies.shape[i] else { panic!("a cell is a rod") };
    length
}

/// The middle of a cell's end cap.
fn cap(bodies: &Bodies, i: usize, side: f64) -> DVec3 {
    bodies.position[i] + bodies.orientation[i] * (side * 0.5 * (length(bodies, i) - DIAMETER) * DVec3::Z)
}

/// The cells of the one chain that a state is, from its lowest end.
fn chain(bodies: &Bodies) -> Vec<usize> {
    let bonds = bonds(bodies);
    assert_eq!(bonds.len() + 1, bodies.len(), "one chain of all cells");
    let mut at = (0..bodies.len()).find(|i| bonds.iter().all(|[_, b]| b != i)).unwrap();
    let mut chain = vec![at];
    while let Some([_, next]) = bonds.iter().find(|[a, _]| *a == at) {
        at = *next;
        chain.push(at);
    }
    assert_eq!(chain.len(), bodies.len(), "without a loop");
    chain
}

#[test]
fn a_founder_becomes_one_chain_whose_caps_keep_together_as_cells_grow() {
    for planar in [true, false] {
        for bond in [json!({"stiffness": "rigid"}), json!({"stiffness": "rigid", "bending": 0.3, "gap": 0.1})] {
            let rest = DIAMETER + bond.get("gap").and_then(Value::as_f64).unwrap_or(GAP);
            let mut simulation = Simulation::new(parse(&founder(&bond, 8.0, planar))).unwrap();
            let mut worst = 0.0_f64;
            while !simulation.done() {
                simulation.step().unwrap();
                let bodies = &simulation.state().unwrap().bodies;
                for [a, b] in bonds(bodies) {
                    worst = worst.max((cap(bodies, a, 1.0).distance(cap(bodies, b, -1.0)) - rest).abs());
                }
            }
            let bodies = &simulation.state().unwrap().bodies;
            assert_eq!((bodies.len(), chain(bodies).len()), (16, 16));
            println!("planar {planar}, {bond}: bonds off by {worst:.1e}");
            assert!(worst <= 1.1e-5, "{planar} {bond}: {worst}");
        }
    }
}

/// Without a turn at birth the chain stays straight, and is as long as its cells and gaps together; cells grow as one.
#[test]
fn a_straight_chain_is_as_long_as_its_cells() {
    let end = run(parse(&founder(&json!({"stiffness": "rigid", "bending": 1.0}), 0.0, true)), &Compute::Cpu).bodies;
    let chain = chain(&end);
    let (first, last) = (chain[0], chain[chain.len() - 1]);
    let along = (cap(&end, last, 1.0) - cap(&end, first, -1.0)).length() + DIAMETER;
    let expected = 1.8 * 2.6_f64.exp() + 15.0 * GAP;
    assert!((along / expected - 1.0).abs() < 1e-4, "{along} {expected}");
}

/// The mean of the squared angles between neighbours.
fn roughness(bodies: &Bodies) -> f64 {
    let bonds = bonds(bodies);
    let axis = |i: usize| bodies.orientation[i] * DVec3::Z;
    bonds.iter().map(|[a, b]| axis(*a).angle_between(axis(*b)).powi(2)).sum::<f64>() / bonds.len() as f64
}

/// The growth of a chain presses it, by half of the drag and the rate times the square of its half length, 72 here: one
/// that buckles at less does not stay straight.
#[test]
fn bending_stiffness_keeps_a_chain_of_cells_straighter() {
    let rough = |bending: f64| {
        let bond = json!({"stiffness": "rigid", "bending": bending});
        roughness(&run(parse(&founder(&bond, 8.0, true)), &Compute::Cpu).bodies)
    };
    let [soft, stiff] = [1e-4, 1e4].map(rough);
    println!("mean squared angle {soft:.2e} of a soft chain, {stiff:.2e} of a stiff one");
    assert!(stiff < 0.05 * soft, "{soft} {stiff}");
}

#[test]
fn weak_bonds_of_daughters_break_and_stay_broken() {
    // Daughters that turn at birth pull at their bonds.
    let bond = |force: f64| json!({"stiffness": 1e4, "break_force": force});
    let whole = run(parse(&founder(&bond(1e3), 8.0, true)), &Compute::Cpu).bodies;
    assert_eq!(bonds(&whole).len(), 15);
    let of = parse(&founder(&bond(1e-3), 8.0, true));
    let broken = run(of.clone(), &Compute::Cpu);
    assert!(bonds(&broken.bodies).len() < 15, "{}", bonds(&broken.bodies).len());
    assert!(in_two_parts(&of, &Compute::Cpu) == broken);
}

#[test]
fn runs_with_bonds_of_daughters_resume_to_the_same_bits_and_their_ends_are_scenes() {
    for planar in [true, false] {
        let of = parse(&founder(&json!({"stiffness": 500.0, "bending": 2.0}), 8.0, planar));
        let whole = run(of.clone(), &Compute::Cpu);
        assert!(in_two_parts(&of, &Compute::Cpu) == whole, "{planar}");
        let mut end =
            Scene::parse(&serde_json::to_string(&of.final_scene(&whole.bodies, 2.6)).unwrap(), "end").unwrap();
        end.time.end = 3.2;
        let begun = end.build().unwrap();
        assert_eq!(bonds(&begun), bonds(&whole.bodies));
        let later = run(end, &Compute::Cpu).bodies;
        assert_eq!((later.len(), chain(&later).len()), (32, 32), "the next generation inherits");
    }
}

/// Three cells in a row with numbers at their ends, as a run writes them; the middle one is removed.
#[test]
fn a_cell_that_is_removed_leaves_two_chains() {
    let cell = |x: f64, ends: [u64; 2]| {
        json!({"shape": {"spherocylinder": {"diameter": DIAMETER, "length": 1.5}}, "position": [x, 0, 0], "angle": 0,
            "daughter_bonds": ends})
    };
    let mut of = founder(&json!({"stiffness": "rigid"}), 0.0, true);
    of["generate"] = json!([]);
    of["bodies"] = json!([cell(-1.5, [0, 7]), cell(0.0, [7, 9]), cell(1.5, [9, 0])]);
    of["time"]["end"] = json!(0.6);
    assert_eq!(bonds(&parse(&of).build().unwrap()), [[0, 1], [1, 2]]);
    let end = run(parse(&of), &Compute::Cpu).bodies;
    assert_eq!((end.len(), bonds(&end).len()), (6, 5));
    of["removal"] = json!([{"inside": {"sphere": {"center": [0, 0, 0], "radius": 0.3}}}]);
    let end = run(parse(&of), &Compute::Cpu).bodies;
    assert_eq!((end.len(), bonds(&end).len()), (4, 2));
}

#[test]
fn bonds_of_daughters_that_mean_nothing_are_refused_with_their_keys() {
    let base = || founder(&json!({"stiffness": 10.0}), 0.0, true);
    for (name, value) in [("stiffness", json!(0)), ("gap", json!(-1)), ("bending", json!(0)), ("break_force", json!(0))]
    {
        let mut of = base();
        of["growth"]["bond_daughters"][name] = value;
        assert_eq!(refusal(&of).0, format!("growth.bond_daughters.{name}"));
    }
    let mut of = base();
    of["time"]["stepping"] = json!("midpoint");
    let (key, message) = refusal(&of);
    assert!(key == "time.stepping" && message.contains("growth.bond_daughters"), "{message}");
    let mut of = base();
    of["growth"]["bond_daughters"]["implicit"] = json!(true);
    assert!(refusal(&of).0.starts_with("growth.bond_daughters"));
}

#[test]
fn numbers_of_bonds_that_a_scene_gives_are_checked_and_not_given_again() {
    let cell = |x: f64, ends: [u64; 2]| {
        json!({"shape": {"spherocylinder": {"diameter": DIAMETER, "length": 1.5}}, "position": [x, 0, 0], "angle": 0,
            "daughter_bonds": ends})
    };
    let of = |cells: Vec<Value>| {
        let mut of = founder(&json!({"stiffness": "rigid"}), 0.0, true);
        of["generate"] = json!([]);
        of["bodies"] = json!(cells);
        of["time"]["end"] = json!(0.6);
        of
    };
    for (cells, key) in [
        (vec![cell(0.0, [3, 3])], "bodies.0.daughter_bonds"),
        (vec![cell(-1.5, [0, 1]), cell(0.0, [0, 1])], "bodies.1.daughter_bonds.1"),
    ] {
        assert_eq!(refusal(&of(cells)).0, key);
    }
    let mut alone = of(vec![cell(-1.5, [0, 1]), cell(0.0, [1, 0])]);
    alone["growth"].as_object_mut().unwrap().remove("bond_daughters");
    assert_eq!(refusal(&alone).0, "bodies.0.daughter_bonds");
    // The number 1 would be that of the bond between the daughters of a cell with the id 0.
    let end = run(parse(&of(vec![cell(-1.5, [0, 1]), cell(0.0, [1, 0])])), &Compute::Cpu).bodies;
    assert_eq!((end.len(), bonds(&end).len()), (4, 3));
}
