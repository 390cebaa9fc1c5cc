//! Three initially overlapping capsules (the paper's toy problem) against an independent program's figures.

use crate::random::parse;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

fn run(method: &str) -> Vec<relcp::step::StepReport> {
    let data: Value = serde_json::from_str(include_str!("../data/three_capsules.json")).unwrap();
    // All three pairs have rows at every step, as in the independent program.
    let scene = parse(&json!({
        "name": "three-capsules", "time": {"dt": data["dt"], "end": 8e-4}, "contact": {"method": method, "rows": "paper", "cutoff": 0.5}, "bodies": data["bodies"]
    }));
    let mut simulation = Simulation::new(scene).unwrap();
    assert_eq!(simulation.scene().time.steps(), 8);
    (0..8).map(|_| simulation.step().unwrap()).collect()
}

#[test]
fn snsd_jitters_as_the_independent_program_does() {
    let expected = [0.172603, 0.119724, 0.0834569, 0.0585534, 0.0411736, 0.028976, 0.0203984, 0.014362];
    for (report, expected) in run("snsd").iter().zip(expected) {
        println!("{} {}", report.step, report.max_overlap);
        assert!((report.max_overlap / expected - 1.0).abs() < 0.01, "{} against {expected}", report.max_overlap);
        assert_eq!((report.recursions, report.constraints), (0, 3));
    }
}

#[test]
fn relcp_resolves_them_in_one_step() {
    let reports = run("relcp");
    assert_eq!((reports[0].recursions, reports[0].constraints), (1, 5));
    for report in &reports {
        assert!(report.max_overlap < 1e-5, "step {}: {}", report.step, report.max_overlap);
        assert_eq!(report.unconverged, 0);
    }
    assert!(reports[1..].iter().all(|r| (r.recursions, r.constraints) == (0, 3)));
}
