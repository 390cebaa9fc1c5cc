//! Tops that turn freely.

use super::StudyError;
use crate::paper::COMPUTED_BY;
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::{Scene, Stepping};
use relcp::simulation::{Compute, Simulation};
use serde::Serialize;
use serde_json::json;

/// The angular speed of every top; their steps are what differs.
const SPEED: f64 = 2.0;
/// The number of states of a run on a device that are read and checked. On the CPU every state is checked.
const LOOKS_ON_A_DEVICE: u64 = 100;
/// The time after which attitudes are compared.
const ATTITUDE_TIME: f64 = 8.0;

/// A top: its name, its shape, and the axis that it turns about at the start, body axes.
pub type Top = (&'static str, &'static str, [f64; 3]);

/// Tops of every shape; the first turns about its middle axis but for a hundredth, which it tumbles from, the others
/// askew.
pub const SHAPES: [Top; 6] = [
    ("triaxial, about its middle axis", r#"{"ellipsoid": {"radii": [0.3, 0.5, 0.8]}}"#, [0.01, 1.0, 0.01]),
    ("triaxial, askew", r#"{"ellipsoid": {"radii": [0.15, 0.35, 0.6]}}"#, [0.5, 0.6, 0.7]),
    ("prolate", r#"{"ellipsoid": {"radii": [0.35, 0.35, 0.6]}}"#, [0.2, 0.6, 0.8]),
    ("oblate", r#"{"ellipsoid": {"radii": [0.5, 0.5, 0.2]}}"#, [0.3, 0.5, 0.8]),
    ("rod", r#"{"spherocylinder": {"diameter": 0.3, "length": 1.5}}"#, [0.3, 0.5, 0.8]),
    ("ring", r#"{"torus": {"major_radius": 0.7, "minor_radius": 0.1}}"#, [0.3, 0.5, 0.8]),
];

/// What a top kept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopRow {
    /// Which.
    pub top: &'static str,
    /// The stepping scheme.
    pub stepping: Stepping,
    /// What computed it.
    pub computed_by: String,
    /// The angle that it turns by in a step, radians.
    pub angle: f64,
    /// Steps taken.
    pub steps: u64,
    /// Turns made.
    pub turns: f64,
    /// The largest change of its angular momentum in space, as a part of what it was.
    pub momentum: f64,
    /// The largest change of its energy, as a part of what it was.
    pub energy: f64,
    /// The change of its energy at the end, as a part of what it was.
    pub last_energy: f64,
}

/// The scene of tops that turn by `angle` in a step.
fn tops(tops: &[Top], stepping: Stepping, angle: f64) -> Result<Scene, StudyError> {
    let body = |(i, (_, shape, axis)): (usize, &Top)| {
        let orientation = DQuat::from_scaled_axis(DVec3::new(0.3, -0.7, 1.1));
        let velocity = orientation * (SPEED * DVec3::from(*axis).normalize());
        let [x, y, z, w] = orientation.to_array();
        let shape: serde_json::Value = serde_json::from_str(shape).unwrap_or_default();
        json!({
            "shape": shape, "position": [4.0 * i as f64, 0.0, 0.0], "orientation": [w, x, y, z],
            "angular_velocity": velocity.to_array(),
        })
    };
    let bodies: Vec<_> = tops.iter().enumerate().map(body).collect();
    let text = json!({
        "name": "tops", "time": {"dt": angle / SPEED, "end": 1e9, "stepping": stepping}, "dynamics": {"inertial": {"density": 1.0}}, "bodies": bodies,
    });
    Ok(Scene::parse(&text.to_string(), "tops")?)
}

/// A body's angular momentum about its centre and its energy of rotation, at a density of one.
pub(super) fn spin(bodies: &Bodies, i: usize) -> (DVec3, f64) {
    let (q, w) = (bodies.orientation[i], bodies.angular_velocity[i]);
    let in_body = q.inverse() * w;
    let momentum = bodies.shape[i].unit_inertia() * in_body;
    (q * momentum, 0.5 * momentum.dot(in_body))
}

/// Turns all tops by `angle` per step for `steps` steps.
///
/// # Errors
/// [`StudyError::Fault`] where a step cannot be taken.
pub fn turn(compute: &Compute, stepping: Stepping, angle: f64, steps: u64) -> Result<Vec<TopRow>, StudyError> {
    let scene = tops(&SHAPES, stepping, angle)?;
    let mut simulation = Simulation::builder(scene).on(compute).build()?;
    let (computed_by, look_every) = match compute {
        Compute::Gpu { gpu, precision } => {
            (format!("{} {}", gpu.name(), precision.name()), (steps / LOOKS_ON_A_DEVICE).max(1))
        }
        _ => (COMPUTED_BY.to_owned(), 1),
    };
    let begin = simulation.state()?.bodies.clone();
    let begin: Vec<_> = (0..begin.len()).map(|i| spin(&begin, i)).collect();
    let mut worst = vec![[0.0f64; 3]; begin.len()];
    for step in 1..=steps {
        simulation.step()?;
        if step % look_every != 0 && step != steps {
            continue;
        }
        let bodies = &simulation.state()?.bodies;
        for (i, ((momentum, energy), worst)) in begin.iter().zip(&mut worst).enumerate() {
            let (now, kinetic) = spin(bodies, i);
            let change = kinetic / energy - 1.0;
            let momentum = (now - momentum).length() / momentum.length();
            *worst = [worst[0].max(momentum), worst[1].max(change.abs()), change];
        }
    }
    let row = |((top, _, _), [momentum, energy, last_energy]): (&Top, [f64; 3])| TopRow {
        top,
        stepping,
        computed_by: computed_by.clone(),
        angle,
        steps,
        turns: steps as f64 * angle / std::f64::consts::TAU,
        momentum,
        energy,
        last_energy,
    };
    Ok(SHAPES.iter().zip(worst).map(row).collect())
}

/// How far a symmetric top's attitude is from the closed form.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Order {
    /// The stepping scheme.
    pub stepping: Stepping,
    /// The angle that it turns by in a step, radians.
    pub angle: f64,
    /// The angle between both attitudes after some turns, radians.
    pub error: f64,
}

/// Lets the prolate top turn and compares its attitude: it turns by `t L / J_x` about `L`, and by `t (1 / J_z - 1 /
/// J_x) L_z` about its axis.
///
/// # Errors
/// [`StudyError::Fault`] where a step cannot be taken.
pub fn attitude_error(stepping: Stepping, angle: f64) -> Result<Order, StudyError> {
    let scene = tops(&SHAPES[2..3], stepping, angle)?;
    let steps = (ATTITUDE_TIME / scene.time.dt).round();
    let end = steps * scene.time.dt;
    let bodies = scene.build()?;
    let (start, moments, (momentum, _)) = (bodies.orientation[0], bodies.shape[0].unit_inertia(), spin(&bodies, 0));
    let along = (start.inverse() * momentum).z;
    let exact = DQuat::from_scaled_axis(end / moments.x * momentum)
        * start
        * DQuat::from_rotation_z(end * along * (1.0 / moments.z - 1.0 / moments.x));
    let mut simulation = Simulation::builder(scene).bodies(bodies).build()?;
    for _ in 0..steps as u64 {
        simulation.step()?;
    }
    let q = simulation.state()?.bodies.orientation[0];
    // Of two unit quaternions this is half the angle between the attitudes, for small ones.
    let error = 2.0 * (q - exact).length().min((q + exact).length());
    Ok(Order { stepping, angle, error })
}
