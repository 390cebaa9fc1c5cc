//! All solvers find the same velocity, which the theory says is unique, on LCPs taken from every scene of the paper,
//! also from late recursions, where rows of one pair are nearly the same and the system is singular.

use crate::random::parse;
use glam::DVec3;
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::step::Verbs;
use relcp::lcp::{Problem, Settings, Solver, Status, velocity};
use relcp::scene::{Scene, SolverKind};
use relcp::simulation::Simulation;
use relcp::step::State;
use relcp::warm::Warm;
use serde_json::json;

const SOLVERS: [SolverKind; 7] = [
    SolverKind::ProjectedJacobi,
    SolverKind::ProjectedGaussSeidel,
    SolverKind::Apgd,
    SolverKind::Bbpgd,
    SolverKind::PairBlockCg,
    SolverKind::ClusterCg,
    SolverKind::InteriorPoint,
];

/// The largest systems of a scene's steps from `from` to `to`, as they stand at the last recursion.
fn lcps<const D: usize>(scene: &Scene, from: usize, to: usize) -> Vec<Problem<D>> {
    let bodies = scene.build().unwrap();
    let next_id = bodies.len() as u64;
    let mut backend =
        Cpu::<D>::new(&scene.model(), State { step: 0, next_id, bodies, warm: Vec::new(), ..State::default() })
            .unwrap();
    let mut taken = Vec::new();
    for step in 0..to {
        backend.begin().unwrap();
        backend.append_near().unwrap();
        backend.solve(scene.lcp_settings().tolerance).unwrap();
        while backend.trial(scene.contact.overlap_tolerance).unwrap().violations > 0 {
            backend.append_violations(false).unwrap();
            backend.solve(scene.lcp_settings().tolerance).unwrap();
        }
        if step >= from && backend.lcp().1.iter().any(|gamma| *gamma > 0.0) {
            taken.push(backend.lcp().0.clone());
        }
        backend.accept().unwrap();
    }
    taken.sort_by_key(|problem| std::cmp::Reverse(problem.q.len()));
    taken.truncate(2);
    assert!(!taken.is_empty());
    taken
}

fn compare<const D: usize>(name: &str, problems: &[Problem<D>]) {
    for problem in problems {
        let rows = problem.q.len();
        assert!(rows <= 200, "{name}: {rows} rows are too many for the oracle");
        let solve = |kind, tolerance| {
            let mut gamma = Vec::new();
            let outcome =
                Solver::new(kind, Settings { tolerance, max_iterations: 20_000_000 }).solve(problem, &mut gamma);
            (outcome, velocity(problem, &gamma))
        };
        let (outcome, reference) = solve(SolverKind::Dense, 1e-13);
        assert!(outcome.residual < 1e-11, "{name}: the oracle leaves {outcome:?}");
        let scale = reference.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
        for kind in SOLVERS {
            let (outcome, v) = solve(kind, 1e-9 * scale.min(1e-2));
            let apart = v.as_flattened().iter().zip(reference.as_flattened());
            let apart = apart.map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt() / scale;
            println!("{name} {rows} rows {kind:?}: {} products, v off by {apart:.1e}", outcome.products);
            assert_eq!(outcome.status, Status::Solved, "{name} {kind:?}: {outcome:?}");
            assert!(apart < 1e-7, "{name} {kind:?}: v is {apart:e} off");
        }
    }
}

fn small(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    Scene::load(name, &sets).unwrap()
}

#[test]
fn on_two_ellipsoids() {
    let scene = small("two-ellipsoids", &["time.dt=0.2"]);
    compare("two-ellipsoids", &lcps::<SPATIAL>(&scene, 30, 100));
}

#[test]
fn on_three_capsules() {
    compare("three-capsules", &lcps::<SPATIAL>(&small("three-capsules", &["contact.rows=paper"]), 0, 3));
}

#[test]
fn on_a_colony() {
    let scene = small("colony", &["time.dt=0.01"]);
    compare("colony", &lcps::<PLANAR>(&scene, 330, 350));
}

#[test]
fn on_a_compaction() {
    let shape = json!({"ellipsoid": {"radii": [1.0, 1.0, 2.0]}});
    let scene = parse(&json!({
        "name": "compaction", "seed": 3, "time": {"dt": 0.2, "end": 100.0}, "forces": [{"radial_inward": {}}],
        "generate": [{"isotropic": {"count": 24, "shape": shape, "volume_fraction": 0.02}}]
    }));
    compare("compaction", &lcps::<SPATIAL>(&scene, 300, 310));
}

#[test]
fn on_chainmail() {
    let sets = ["generate.0.chainmail.columns=3", "generate.0.chainmail.rows=3", "time.dt=0.01"];
    compare("chainmail", &lcps::<SPATIAL>(&small("chainmail", &sets), 300, 320));
}

#[test]
fn bodies_that_parted_do_not_go_on_pushing_each_other() {
    for kind in SOLVERS.into_iter().chain([SolverKind::Auto, SolverKind::Dense]) {
        let mut scene = parse(&json!({
            "name": "parted", "time": {"dt": 1e-3, "end": 1.0},
            "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0]},
                       {"shape": {"sphere": {"radius": 0.5}}, "position": [1.05, 0, 0]}],
        }));
        scene.solver.kind = kind;
        let bodies = scene.build().unwrap();
        let start = bodies.position[1];
        // It moves each by 2e-7 in a step, which a solver may do within its tolerance; in a hundred that would be 2e-5.
        let warm = vec![Warm { pair: [0, 1], feature: 0, gamma: 2e-4, normal: DVec3::X, tangent: DVec3::ZERO }];
        let mut simulation = Simulation::builder(scene)
            .resume(State { step: 0, next_id: 2, bodies, warm, ..State::default() })
            .build()
            .unwrap();
        for _ in 0..100 {
            let report = simulation.step().unwrap();
            assert_eq!((report.constraints, report.unconverged), (1, 0), "{kind:?}: {report:?}");
        }
        let moved = (simulation.state().unwrap().bodies.position[1] - start).length();
        assert!(moved < 1e-6, "{kind:?} moved it by {moved:e}");
    }
}
