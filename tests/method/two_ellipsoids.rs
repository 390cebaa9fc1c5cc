//! Two ellipsoids pushed past each other (the paper's first test): first-order convergence to an independent f64
//! solution.

use glam::DVec3;
use relcp::Scene;
use relcp::simulation::Simulation;

struct Passage {
    /// x, y and long-axis angle of the upper body at t = 30.
    at_30: [f64; 3],
    first_contact: f64,
    last_contact: f64,
    recursions: u32,
    worst: f64,
    end: relcp::bodies::Bodies,
}

fn pass(dt: f64, method: &str) -> Passage {
    let sets = [format!("time.dt={dt}"), format!("contact.method=\"{method}\"")];
    let scene = Scene::load("two-ellipsoids", &sets).unwrap();
    let mut simulation = Simulation::new(scene).unwrap();
    let mut touching = Vec::new();
    let mut passage = Passage {
        at_30: [0.0; 3],
        first_contact: 0.0,
        last_contact: 0.0,
        recursions: 0,
        worst: 0.0,
        end: Default::default(),
    };
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert_eq!(report.unconverged, 0);
        passage.recursions += report.recursions;
        passage.worst = passage.worst.max(report.max_overlap);
        if simulation.state().unwrap().warm.iter().any(|w| w.gamma > 0.0) {
            touching.push(report.time);
        }
        if (report.time - 30.0).abs() < 0.5 * dt {
            let bodies = &simulation.state().unwrap().bodies;
            let axis = bodies.orientation[0] * DVec3::Z;
            let axis = if axis.x < 0.0 { -axis } else { axis };
            passage.at_30 = [bodies.position[0].x, bodies.position[0].y, axis.y.atan2(axis.x)];
        }
    }
    passage.first_contact = touching[0] - dt;
    passage.last_contact = *touching.last().unwrap();
    passage.end = simulation.state().unwrap().bodies.clone();
    passage
}

const EXPECTED: [f64; 3] = [0.99505, 0.54426, -0.49413];

#[test]
fn converges_at_first_order_to_the_independent_solution() {
    let passages = [0.1, 0.01, 0.001].map(|dt| pass(dt, "relcp"));
    let errors = passages.each_ref().map(|p| [0, 1, 2].map(|i| (p.at_30[i] - EXPECTED[i]).abs()));
    for (p, e) in passages.iter().zip(errors) {
        println!(
            "{:?} errors {e:.2?} contact {:.3} to {:.3}, {} recursions",
            p.at_30, p.first_contact, p.last_contact, p.recursions
        );
        assert!(p.worst <= 1e-5, "{}", p.worst);
    }
    for i in 0..3 {
        // The expected values have five digits.
        let rounding = 5e-6;
        assert!(errors[2][i] < 2e-4 * (1.0 + EXPECTED[i].abs()), "{:?}", errors[2]);
        let (coarse, fine) = (errors[0][i], errors[1][i]);
        assert!(coarse / (fine + rounding) > 4.0, "not first order: {coarse} {fine}");
        assert!(fine / (errors[2][i] + rounding) > 4.0, "not first order: {fine} {}", errors[2][i]);
    }
    assert!((passages[2].first_contact - 4.00).abs() < 0.01, "{}", passages[2].first_contact);
    assert!((passages[2].last_contact - 37.74).abs() < 0.01, "{}", passages[2].last_contact);
}

#[test]
fn at_a_small_step_it_is_snsd_bit_for_bit() {
    let relcp = pass(0.001, "relcp");
    assert_eq!(relcp.recursions, 0);
    assert_eq!(relcp.end, pass(0.001, "snsd").end);
}
