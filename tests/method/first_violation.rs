//! What the first solve of a step leaves out: its order in `dt`, and that it is what the recursion works on.

use crate::laws::start;
use relcp::scene::{self, Scene};
use relcp::simulation::Simulation;
use relcp::step::StepReport;

fn load(name: &str, sets: &[&str]) -> scene::Scene {
    Scene::load(name, sets.iter().copied().map(str::to_owned).collect::<Vec<_>>()).unwrap()
}

/// The largest of a step that ends after `from`.
fn largest(simulation: &mut Simulation, from: f64) -> f64 {
    let mut largest = 0.0f64;
    while !simulation.done() {
        let report = simulation.step().unwrap();
        if report.time > from {
            largest = largest.max(report.first_violation);
        }
    }
    largest
}

fn halvings(name: &str, sets: &[&str], from: f64, dts: [f64; 4]) -> Vec<f64> {
    let of = |dt: f64| {
        let mut scene = load(name, sets);
        scene.time.dt = dt;
        largest(&mut start(scene), from)
    };
    let found = dts.map(of);
    let orders: Vec<f64> = found.windows(2).map(|v| (v[0] / v[1]).log2()).collect();
    println!("{name}: {found:.7?}, orders {orders:.2?}");
    orders
}

#[test]
fn of_ellipsoids_that_slide_it_falls_with_the_square_of_the_step() {
    let orders = halvings("two-ellipsoids", &["time.end=12"], 7.0, [0.2, 0.1, 0.05, 0.025]);
    assert!(orders.iter().all(|order| (1.9..2.1).contains(order)), "{orders:?}");
}

#[test]
fn of_cells_side_by_side_it_falls_with_the_step_itself() {
    // Where two rods lie side by side their contact jumps from end to end, so one row leaves an overlap of the order of
    // their turn.
    let orders = halvings("colony", &["time.end=3", "contact.rows=paper"], 2.85, [0.02, 0.01, 0.005, 0.0025]);
    let mean = orders.iter().sum::<f64>() / 3.0;
    assert!((0.7..1.4).contains(&mean), "{orders:?}");
}

#[test]
fn it_is_what_a_step_without_recursion_leaves() {
    let mut simulation = start(load("two-ellipsoids", &["time.end=10", "time.dt=0.05", "contact.method=\"snsd\""]));
    let mut left = 0.0f64;
    while !simulation.done() {
        let StepReport { first_violation, max_overlap, .. } = simulation.step().unwrap();
        assert_eq!(first_violation, max_overlap);
        left = left.max(max_overlap);
    }
    assert!(left > 1e-5, "nothing slides: {left:e}");
}

#[test]
fn a_step_recurs_exactly_where_it_is_above_the_tolerance() {
    for (name, sets) in [
        ("two-ellipsoids", &["time.end=10", "time.dt=0.05"][..]),
        ("colony", &["time.end=3", "time.dt=0.01"]),
        ("two-ellipsoids", &["time.end=10", "time.dt=0.2", "time.stepping=\"midpoint\""]),
    ] {
        let mut simulation = start(load(name, sets));
        let (mut with, mut without) = (0, 0);
        while !simulation.done() {
            let report = simulation.step().unwrap();
            assert_eq!(report.recursions > 0, report.first_violation > 1e-5, "{name}: {report:?}");
            assert!(report.max_overlap <= 1e-5);
            if report.recursions > 0 { with += 1 } else { without += 1 }
        }
        println!("{name}: {with} steps with recursions, {without} without");
        assert!(with > 3 && without > 3, "{name}: {with} {without}");
    }
}
