//! Bodies that turn freely on a device: a step against the CPU's, and their angular momentum and energy over many.

use crate::device::{device, precisions};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::gpu::Precision;
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::SPATIAL;
use relcp::internals::step::{Keeper, Verbs};
use relcp::scene::{Scene, Stepping};
use relcp::simulation::{Compute, Simulation};
use relcp::step::State;

const OTHERS: [&str; 4] = [
    r#"{"sphere": {"radius": 0.6}}"#,
    r#"{"spherocylinder": {"diameter": 0.3, "length": 2}}"#,
    r#"{"ellipsoid": {"radii": [0.2, 0.5, 1]}}"#,
    r#"{"ellipsoid": {"radii": [0.8, 0.8, 0.1]}}"#,
];
const RINGS: [&str; 1] = [r#"{"torus": {"major_radius": 0.7, "minor_radius": 0.2}}"#];

/// Tops of every shape, too far from each other to meet, with turns of up to one a step.
fn tops(stepping: Stepping, rings: bool) -> Scene {
    // Rings and ellipsoids cannot be in one scene.
    let shapes = if rings { &RINGS[..] } else { &OTHERS[..] };

    let body = |(i, shape): (usize, &&str)| {
        let t = i as f64;
        let q = DQuat::from_scaled_axis(DVec3::new(t.sin(), 0.3 * t, 1.0 - t));
        let w = [[10.0, 40.0, -5.0], [60.0, 1.0, 70.0], [5.0, 90.0, 3.0]][i % 3];
        format!(
            r#"{{"shape": {shape}, "position": [{}, 0, 0], "orientation": [{}, {}, {}, {}], "velocity": [0, 1, 0], "angular_velocity": {w:?}}}"#,
            4.0 * t,
            q.w,
            q.x,
            q.y,
            q.z
        )
    };
    let bodies: Vec<String> = shapes.iter().chain(shapes).chain(shapes).enumerate().map(body).collect();
    let text = format!(
        r#"{{"name": "tops", "time": {{"dt": 0.01, "end": 1.5}}, "dynamics": {{"inertial": {{"density": 1.5}}}}, "bodies": [{}]}}"#,
        bodies.join(",")
    );
    let mut scene = Scene::parse(&text, "tops").unwrap();
    scene.time.stepping = stepping;
    scene
}

const CASES: [(Stepping, bool); 4] =
    [(Stepping::Euler, false), (Stepping::Midpoint, false), (Stepping::Euler, true), (Stepping::Midpoint, true)];

fn worst(count: usize, of: impl Fn(usize) -> f64) -> f64 {
    (0..count).map(of).fold(0.0, f64::max)
}

#[test]
fn a_free_step_is_the_cpus() {
    let Some(gpu) = device() else { return };
    for (stepping, rings) in CASES {
        let scene = tops(stepping, rings);
        for precision in precisions(gpu) {
            let state = || State { bodies: scene.build().unwrap(), ..State::default() };
            let mut ours = Device::new(gpu.clone(), precision, &scene.model(), state()).unwrap();
            let mut theirs = Cpu::<SPATIAL>::new(&scene.model(), state()).unwrap();
            let take = |backend: &mut dyn Verbs| {
                backend.add_force(Box::new(|_: &Bodies, i: usize, _: f64| Load {
                    force: DVec3::X,
                    torque: DVec3::new(3.0, -2.0, i as f64),
                }));
                backend.begin().unwrap();
                backend.append_near().unwrap();
                backend.solve(1e-6).unwrap();
                if stepping == Stepping::Midpoint {
                    backend.middle().unwrap();
                    backend.append_near().unwrap();
                    backend.solve(1e-6).unwrap();
                }
                backend.trial(1e-5).unwrap();
                backend.accept().unwrap();
            };
            take(&mut ours);
            take(&mut theirs);
            let (a, b) = (&ours.state().unwrap().bodies, &theirs.state().unwrap().bodies);
            let off = [
                worst(a.len(), |i| a.position[i].distance(b.position[i])),
                worst(a.len(), |i| (a.orientation[i] - b.orientation[i]).length()),
                worst(a.len(), |i| a.velocity[i].distance(b.velocity[i])),
                worst(a.len(), |i| {
                    a.angular_velocity[i].distance(b.angular_velocity[i]) / b.angular_velocity[i].length()
                }),
            ];
            println!("{stepping:?} {precision:?}: off by {off:?}");
            let bound = if precision == Precision::F32 { 1e-5 } else { 1e-13 };
            assert!(off.iter().all(|off| *off < bound), "{stepping:?} {precision:?}: {off:?}");
        }
    }
}

/// Each body's angular momentum and its energy of rotation.
fn spins(bodies: &Bodies) -> Vec<(DVec3, f64)> {
    let of_body = |i: usize| {
        let (q, w) = (bodies.orientation[i], bodies.angular_velocity[i]);
        let in_body = q.inverse() * w;
        let momentum = bodies.shape[i].unit_inertia() * in_body;
        (q * momentum, 0.5 * momentum.dot(in_body))
    };
    (0..bodies.len()).map(of_body).collect()
}

#[test]
fn a_free_spin_does_not_gain_energy() {
    let Some(gpu) = device() else { return };
    for (stepping, rings) in CASES {
        let scene = tops(stepping, rings);
        for precision in precisions(gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision };
            let mut simulation = Simulation::builder(scene.clone()).on(&compute).build().unwrap();
            let begin = spins(&simulation.state().unwrap().bodies);
            while !simulation.done() {
                simulation.step().unwrap();
            }
            let end = spins(&simulation.state().unwrap().bodies);
            let momentum = worst(end.len(), |i| end[i].0.distance(begin[i].0) / begin[i].0.length());
            let energy = worst(end.len(), |i| (end[i].1 / begin[i].1 - 1.0).abs());
            println!("{stepping:?} {precision:?}: momentum off by {momentum:.1e}, energy by {energy:.1e}");
            // In f32 the momentum itself is kept.
            let bounds = if precision == Precision::F32 { [1e-6, 2e-4] } else { [1e-11, 1e-11] };
            assert!(momentum < bounds[0] && energy < bounds[1], "{stepping:?} {precision:?}: {momentum:e} {energy:e}");
        }
    }
}
