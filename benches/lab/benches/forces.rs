//! How exact the contact forces of crowds are: the net contact force on each body in a step, against the same step with
//! a tolerance of 1e-4 of it, in parts of the load.
//!
//! `cargo bench -p relcp-lab --bench forces` prints a row for each scene and each `dt`, with a tolerance of 1e-6 and
//! with the scene's default. `docs/forces.md` has the table.

use glam::DVec3;
use relcp::{Scene, Simulation};
use serde_json::{Value, json};
use std::error::Error;

/// Steps before the one that is measured: a crowd takes some to rest at another `dt`.
const BEFORE: u32 = 10;
const STEPS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];
/// The part of a tolerance that the step it is compared with keeps to.
const TIGHT: f64 = 1e-4;
const SMALLEST_TOLERANCE: f64 = 1e-14;
const RADII: [f64; 3] = [0.4, 0.5, 0.8];

/// A crowd that has settled.
struct Crowd {
    name: &'static str,
    scene: Scene,
    /// The change of a body's velocity in a step by the load alone, by `dt`.
    loaded: fn(f64) -> f64,
}

/// The state that a scene ends in, as a scene.
fn settled(scene: Scene) -> Result<Scene, Box<dyn Error>> {
    let mut simulation = Simulation::new(scene)?;
    while !simulation.done() {
        simulation.step()?;
    }
    Ok(simulation.final_scene()?)
}

fn weight() -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * RADII.iter().product::<f64>()
}

/// Sixty ellipsoids that a force lays on the floor of a box.
fn heap(dynamics: &Value, force: &Value) -> Result<Scene, Box<dyn Error>> {
    let scene = json!({"name": "heap", "seed": 1, "dynamics": dynamics, "time": {"dt": 0.02, "end": 60},
        "walls": [{"box": {"minimum": [-3, -3, -3], "maximum": [3, 3, 12]}}], "forces": [force],
        "generate": [{"isotropic": {"count": 60, "shape": {"ellipsoid": {"radii": RADII}}, "volume_fraction": 0.15}}]});
    settled(Scene::parse(&scene.to_string(), "heap")?)
}

/// Forty discs between walls of which one comes nearer with speed 1.
fn suspension() -> Result<Scene, Box<dyn Error>> {
    let scene = json!({"name": "suspension", "planar": true, "seed": 1, "time": {"dt": 0.01, "end": 2.4},
        "walls": [{"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 8}},
            {"half_space": {"normal": [1, 0, 0], "offset": -4}},
            {"half_space": {"normal": [-1, 0, 0], "offset": -4, "motion": {"velocity": [-1, 0, 0]}}}],
        "generate": [{"isotropic": {"count": 40, "shape": {"sphere": {"radius": 0.45}}, "volume_fraction": 0.4}}]});
    settled(Scene::parse(&scene.to_string(), "suspension")?)
}

/// Two hundred growing cells.
fn colony() -> Result<Scene, Box<dyn Error>> {
    let mut scene = settled(Scene::load("colony", ["growth.stop.population=200"])?)?;
    scene.growth.iter_mut().for_each(|growth| growth.stop = None);
    Ok(scene)
}

fn crowds() -> Result<Vec<Crowd>, Box<dyn Error>> {
    let inertial = json!({"inertial": {"density": 1, "drag": 1}});
    let overdamped = json!({"overdamped": {"drag": 1}});
    let gravity = json!({"gravity": {"acceleration": [0, 0, -1]}});
    let push = json!({"uniform": {"force": [0, 0, -weight()]}});
    Ok(vec![
        Crowd { name: "heap at rest, with inertia", scene: heap(&inertial, &gravity)?, loaded: |dt| dt },
        // The drag of a body is 1 times its length.
        Crowd { name: "heap, overdamped", scene: heap(&overdamped, &push)?, loaded: |_| weight() / 1.6 },
        Crowd { name: "squeezed suspension, overdamped", scene: suspension()?, loaded: |_| 1.0 },
        Crowd { name: "colony of 200 cells, overdamped", scene: colony()?, loaded: |_| 1.0 },
    ])
}

/// Velocities after one step from `scene` with this tolerance.
fn velocities(scene: &Scene, tolerance: f64) -> Result<Vec<DVec3>, Box<dyn Error>> {
    let mut scene = scene.clone();
    scene.time.end = scene.time.start + 1.5 * scene.time.dt;
    scene.solver.tolerance = Some(tolerance);
    let mut simulation = Simulation::new(scene)?;
    simulation.step()?;
    Ok(simulation.state()?.bodies.velocity.clone())
}

/// The largest and the root mean square error of the forces, in parts of the load; the tolerance; products of the steps
/// before.
fn measured(crowd: &Crowd, dt: f64, tolerance: Option<f64>) -> Result<([f64; 2], f64, u64), Box<dyn Error>> {
    let mut scene = crowd.scene.clone();
    scene.time.dt = dt;
    scene.time.end = scene.time.start + (f64::from(BEFORE) + 0.5) * dt;
    scene.solver.tolerance = tolerance;
    scene.output.every = None;
    let tolerance = scene.lcp_settings().tolerance;
    let mut simulation = Simulation::new(scene)?;
    let mut products = 0;
    for _ in 1..BEFORE {
        products += simulation.step()?.products;
    }
    let now = simulation.final_scene()?;
    let ours = velocities(&now, tolerance)?;
    let exact = velocities(&now, (TIGHT * tolerance).max(SMALLEST_TOLERANCE))?;
    let off: Vec<f64> = ours.iter().zip(&exact).map(|(a, b)| a.distance(*b) / (crowd.loaded)(dt)).collect();
    let square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
    Ok(([off.iter().copied().fold(0.0, f64::max), square.sqrt()], tolerance, products))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("| crowd | dt | tolerance | largest error | mean square root | products of 9 steps |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for crowd in crowds()? {
        for dt in STEPS {
            for tolerance in [Some(1e-6), None] {
                match measured(&crowd, dt, tolerance) {
                    Ok(([largest, root], tolerance, products)) => {
                        println!(
                            "| {} | {dt:e} | {tolerance:.1e} | {largest:.1e} | {root:.1e} | {products} |",
                            crowd.name
                        );
                    }
                    Err(why) => println!("| {} | {dt:e} | | {why} | | |", crowd.name),
                }
            }
        }
    }
    Ok(())
}
