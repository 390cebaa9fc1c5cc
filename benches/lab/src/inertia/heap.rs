//! Heaps of bodies that are dropped with spins and settle: does their energy ever rise?

use super::StudyError;
use super::top::spin;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::bodies::Bodies;
use relcp::scene::{Scene, Stepping};
use relcp::simulation::Simulation;
use relcp::step::State;
use serde::Serialize;
use serde_json::json;

/// The acceleration by gravity, downwards.
const GRAVITY: f64 = 9.81;
/// Layers of four bodies, and the distance between neighbours: no two shapes touch at the start.
const LAYERS: usize = 5;
const APART: f64 = 1.7;
/// Components of velocities and of spins at the start are drawn from this range about zero.
const SPEED: f64 = 1.0;
const SPIN: f64 = 8.0;

/// Shapes of heaps, and steps.
const SHAPES: [(&str, &str); 4] = [
    ("spheres", r#"{"sphere": {"radius": 0.4}}"#),
    ("rods", r#"{"spherocylinder": {"diameter": 0.5, "length": 1.6}}"#),
    ("ellipsoids", r#"{"ellipsoid": {"radii": [0.3, 0.45, 0.7]}}"#),
    ("rings", r#"{"torus": {"major_radius": 0.6, "minor_radius": 0.15}}"#),
];
const PLACES: [(&str, &str); 2] = [
    ("plane", r#"[{"half_space": {"normal": [0, 0, 1], "offset": 0}}]"#),
    ("box", r#"[{"box": {"minimum": [-1.8, -1.8, 0], "maximum": [1.8, 1.8, 12]}}]"#),
];
const STEPS: [f64; 5] = [0.002, 0.005, 0.01, 0.02, 0.05];

/// One of the heaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heap {
    /// Its number, which says all but the stepping.
    pub number: usize,
    /// The stepping scheme.
    pub stepping: Stepping,
    /// The time for which it is followed.
    pub end: f64,
}

impl Heap {
    /// The heap of this number: four shapes in two places by five steps come round after 40.
    pub fn number(number: usize, stepping: Stepping, end: f64) -> Self {
        Heap { number, stepping, end }
    }

    fn shape(&self) -> (&'static str, &'static str) {
        SHAPES[self.number % SHAPES.len()]
    }

    fn place(&self) -> (&'static str, &'static str) {
        PLACES[self.number / SHAPES.len() % PLACES.len()]
    }

    fn dt(&self) -> f64 {
        STEPS[self.number / (SHAPES.len() * PLACES.len()) % STEPS.len()]
    }

    fn scene(&self) -> Result<Scene, StudyError> {
        let mut random = ChaCha8Rng::seed_from_u64(self.number as u64);
        let mut vector = |size: f64| DVec3::from_array(std::array::from_fn(|_| random.random_range(-size..size)));
        let parsed = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap_or_default();
        let mut bodies = Vec::new();
        for k in 0..4 * LAYERS {
            let at = |n: usize| APART * ((n % 2) as f64 - 0.5);
            let [x, y, z, w] = DQuat::from_scaled_axis(vector(std::f64::consts::PI)).to_array();
            bodies.push(json!({
                "shape": parsed(self.shape().1), "position": [at(k), at(k / 2), 1.0 + APART * (k / 4) as f64],
                "orientation": [w, x, y, z], "velocity": vector(SPEED).to_array(), "angular_velocity": vector(SPIN).to_array(),
            }));
        }
        let text = json!({
            "name": "heap", "time": {"dt": self.dt(), "end": self.end, "stepping": self.stepping}, "dynamics": {"inertial": {"density": 1.0}},
            "forces": [{"gravity": {"acceleration": [0.0, 0.0, -GRAVITY]}}], "walls": parsed(self.place().1), "bodies": bodies,
        });
        Ok(Scene::parse(&text.to_string(), "heap")?)
    }
}

/// What a heap's energy did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeapRow {
    /// Its number.
    pub number: usize,
    /// Its bodies.
    pub shape: &'static str,
    /// On a plane, or in a box.
    pub place: &'static str,
    /// The stepping scheme.
    pub stepping: Stepping,
    /// The step.
    pub dt: f64,
    /// Steps taken.
    pub steps: u64,
    /// Kinetic and potential energy at the start, above the plane.
    pub first_energy: f64,
    /// The same at the end.
    pub last_energy: f64,
    /// The largest energy after any step, as a part of the first.
    pub most_energy: f64,
    /// The largest rise in a step, as a part of the first energy.
    pub most_rise: f64,
    /// The largest part of it that what the tolerances allow does not cover, as a part of the first energy.
    pub unexplained: f64,
    /// Steps that rise by more than the tolerances allow.
    pub rises: u64,
    /// The largest overlap after any step.
    pub max_overlap: f64,
    /// Steps whose solves did not reach their tolerance, or that went past the overlap tolerance.
    pub missed: u64,
    /// Steps in which bodies went through each other.
    pub passed: u64,
}

/// Kinetic energy and potential energy above the plane, at a density of one.
fn energy(bodies: &Bodies) -> f64 {
    let of_body = |i: usize| {
        let mass = bodies.shape[i].volume();
        spin(bodies, i).1 + mass * (0.5 * bodies.velocity[i].length_squared() + GRAVITY * bodies.position[i].z)
    };
    (0..bodies.len()).map(of_body).sum()
}

/// What a step may add: contact forces push what overlaps apart, by the overlap tolerance and the residual of their
/// solve at most. In a midpoint step half of gravity's impulse comes after contact's, which sees nothing of it until
/// the next step: `m (g dt)^2 / 8` a body at most.
fn allowed(scene: &Scene, state: &State) -> f64 {
    let force: f64 = state.warm.iter().map(|warm| warm.gamma).sum();
    let by_contact = force * (scene.contact.overlap_tolerance + scene.lcp_settings().tolerance);
    let after = match scene.time.stepping {
        Stepping::Midpoint => {
            let mass: f64 = state.bodies.shape.iter().map(|shape| shape.volume()).sum();
            mass * (GRAVITY * scene.time.dt).powi(2) / 8.0
        }
        _ => 0.0,
    };
    by_contact + after
}

/// Follows a heap while it settles.
///
/// # Errors
/// [`StudyError::Fault`] where a step cannot be taken.
pub fn settle(heap: &Heap) -> Result<HeapRow, StudyError> {
    let scene = heap.scene()?;
    let bodies = scene.build()?;
    let first = energy(&bodies);
    let mut row = HeapRow {
        number: heap.number,
        shape: heap.shape().0,
        place: heap.place().0,
        stepping: heap.stepping,
        dt: heap.dt(),
        steps: 0,
        first_energy: first,
        last_energy: first,
        most_energy: 1.0,
        most_rise: 0.0,
        unexplained: 0.0,
        rises: 0,
        max_overlap: 0.0,
        missed: 0,
        passed: 0,
    };
    let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).build()?;
    // Sums of about a hundred terms.
    let rounding = 1e-13 * first;
    while !simulation.done() {
        let report = simulation.step()?;
        let state = simulation.state()?;
        let now = energy(&state.bodies);
        let rise = now - row.last_energy;
        let unexplained = rise - allowed(&scene, state);
        row.steps += 1;
        row.most_rise = row.most_rise.max(rise / first);
        row.most_energy = row.most_energy.max(now / first);
        if unexplained > rounding {
            row.rises += 1;
            row.unexplained = row.unexplained.max(unexplained / first);
        }
        row.max_overlap = row.max_overlap.max(report.max_overlap);
        let over = report.max_overlap > scene.contact.overlap_tolerance;
        row.missed += u64::from(over || report.unconverged > 0);
        row.passed += u64::from(report.passed.is_some());
        row.last_energy = now;
    }
    Ok(row)
}
