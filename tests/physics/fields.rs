//! Forces added in code that compute all loads together, and those that fail.

use crate::device::{device, precisions};
use crate::scenes::parse;
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::dynamics::{ForceField, Load};
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::Fault;
use serde_json::json;
use std::sync::{Arc, Mutex};

/// A spring whose loads are made together, until a time from which on it fails. It keeps when it was asked.
struct Springs {
    loads: Mutex<Vec<Load>>,
    asked: Arc<Mutex<Vec<f64>>>,
    fails_from: f64,
}

impl ForceField for Springs {
    fn prepare(&self, bodies: &Bodies, time: f64) -> Result<(), String> {
        self.asked.lock().unwrap().push(time);
        if time >= self.fails_from {
            return Err("the spring broke".into());
        }
        *self.loads.lock().unwrap() = bodies.position.iter().map(|x| Load { force: -*x, torque: DVec3::X }).collect();
        Ok(())
    }

    fn load(&self, _bodies: &Bodies, i: usize, _time: f64) -> Load {
        self.loads.lock().unwrap()[i]
    }
}

fn rods(stepping: &str) -> Scene {
    let rod = json!({"spherocylinder": {"diameter": 0.5, "length": 1.5}});
    parse(&json!({"name": "rods", "time": {"dt": 0.02, "end": 0.12, "stepping": stepping},
        "bodies": [{"shape": rod, "position": [1, 0, 0]}, {"shape": rod, "position": [-1, 0.2, 0.1]}]}))
}

fn sprung(scene: &Scene, compute: &Compute, fails_from: f64) -> (Simulation, Arc<Mutex<Vec<f64>>>) {
    let mut simulation = Simulation::builder(scene.clone()).on(compute).build().unwrap();
    let asked = Arc::new(Mutex::new(Vec::new()));
    let force = Springs { loads: Mutex::default(), asked: asked.clone(), fails_from };
    simulation.add_force(Box::new(force));
    (simulation, asked)
}

#[test]
fn a_field_sees_each_step_first_and_its_fault_leaves_the_state() {
    let gpu = device();
    let on_device = gpu
        .iter()
        .flat_map(|gpu| precisions(gpu).into_iter().map(|precision| Compute::Gpu { gpu: Arc::clone(gpu), precision }));
    let machines: Vec<Compute> = [Compute::Cpu].into_iter().chain(on_device).collect();
    for stepping in ["euler", "midpoint"] {
        let scene = rods(stepping);
        let plain = |bodies: &Bodies, i: usize, _: f64| Load { force: -bodies.position[i], torque: DVec3::X };
        for compute in &machines {
            let mut other = Simulation::builder(scene.clone()).on(compute).build().unwrap();
            other.add_force(Box::new(plain));
            let (mut simulation, asked) = sprung(&scene, compute, f64::INFINITY);
            while !simulation.done() {
                simulation.step().unwrap();
                other.step().unwrap();
            }
            assert_eq!(simulation.state().unwrap(), other.state().unwrap());
            let halves: &[f64] = if stepping == "euler" { &[0.0] } else { &[0.0, 0.5] };
            let expected = (0..6).flat_map(|k| halves.iter().map(move |half| 0.02 * (f64::from(k) + half)));
            let asked = asked.lock().unwrap();
            assert_eq!(asked.len(), 6 * halves.len());
            assert!(asked.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{asked:?}");
            // From the fourth step on it fails, each time that it is asked, and is asked once for it.
            let (mut broken, asked) = sprung(&scene, compute, 0.055);
            for _ in 0..3 {
                broken.step().unwrap();
            }
            let before = broken.state().unwrap().clone();
            for _ in 0..2 {
                let fault = broken.step().unwrap_err();
                assert_eq!(fault, Fault::Force { step: 4, what: "the spring broke".into() });
                assert_eq!(fault.to_string(), "step 4: an added force failed: the spring broke");
            }
            assert_eq!((broken.steps(), broken.state().unwrap()), (3, &before));
            assert_eq!(asked.lock().unwrap().len(), 3 * halves.len() + 2);
        }
    }
}
