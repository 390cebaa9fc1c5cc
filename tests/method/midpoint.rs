//! The midpoint step.

use relcp::relcp::Simulation;
use relcp::scene::{self, Scene};
use glam::DVec3;

fn two_ellipsoids(dt: f64, stepping: &str) -> ([f64; 3], u32, f64) {
    let sets = [format!("time.dt={dt}"), format!("time.stepping=\"{stepping}\""), "time.end=30".to_owned()];
    let scene: Scene = scene::load("two-ellipsoids", &sets).unwrap();
    let bodies = scene.build().unwrap();
    let mut simulation = Simulation::new(scene, bodies).unwrap();
    let (mut recursions, mut worst) = (0, 0.0f64);
    while !simulation.done() {
        let report = simulation.step().unwrap();
        recursions += report.recursions;
        worst = worst.max(report.max_overlap);
    }
    let bodies = &simulation.state().unwrap().bodies;
    let axis = bodies.orientation[0] * DVec3::Z;
    let axis = if axis.x < 0.0 { -axis } else { axis };
    ([bodies.position[0].x, bodies.position[0].y, axis.y.atan2(axis.x)], recursions, worst)
}

#[test]
fn explore() {
    let fine = two_ellipsoids(0.4 / 512.0, "midpoint");
    println!("fine {fine:?}");
    for stepping in ["midpoint", "euler"] {
        for k in 0..6 {
            let dt = 0.4 / f64::from(1 << k);
            let found = two_ellipsoids(dt, stepping);
            let e = [0, 1, 2].map(|i| (found.0[i] - fine.0[i]).abs());
            println!("{stepping} {dt} {:.2e} {:.2e} {:.2e} recursions {} worst {:.1e}", e[0], e[1], e[2], found.1, found.2);
        }
    }
}
