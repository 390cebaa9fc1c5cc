//! Building blocks of the cases: bodies, scenes of them, and a pull that does not depend on the origin.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::bodies::Bodies;
use relcp::dynamics::{ForceField, Load};
use relcp::scene::{Body, Dynamics, Force, Scene, Time};
use relcp::shape::Shape;

/// Where a run starts: a scene, and the pull on its bodies where there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// The scene.
    pub scene: Scene,
    /// The pull.
    pub pull: Option<Pull>,
}

/// A force `stiffness (centre - x)` on every body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// Where to.
    pub centre: DVec3,
    /// Its stiffness, force over distance.
    pub stiffness: f64,
}

impl ForceField for Pull {
    fn load(&self, bodies: &Bodies, i: usize, _time: f64) -> Load {
        Load { force: self.stiffness * (self.centre - bodies.position[i]), torque: DVec3::ZERO }
    }
}

impl Start {
    /// Bodies at rest without inertia; steps of `dt`.
    pub fn still(dt: f64, bodies: Vec<Body>) -> Start {
        // The end is never reached: the study counts the steps.
        let scene = with!(seed: 1, bodies, ..Scene::new("hard", Time::new(dt, 1e3 * dt)));
        Start { scene, pull: None }
    }

    /// As [`Start::still`], with inertia at density 1.
    pub fn inertial(dt: f64, bodies: Vec<Body>) -> Start {
        let mut start = Start::still(dt, bodies);
        start.scene.dynamics = Dynamics::Inertial { density: 1.0, drag: None };
        start
    }

    /// Pulled to the origin.
    pub fn pulled(mut self, stiffness: f64) -> Start {
        self.pull = Some(Pull { centre: DVec3::ZERO, stiffness });
        self
    }

    /// With a force of its own on each of some bodies.
    pub fn pushed(mut self, forces: &[(usize, [f64; 3])]) -> Start {
        for (i, force) in forces {
            let group = format!("pushed-{i}");
            if let Some(body) = self.scene.bodies.get_mut(*i) {
                body.group = Some(group.clone());
            }
            self.scene.forces.push(Force::Uniform { force: *force, group: Some(group), window: None });
        }
        self
    }

    /// Solved to `tolerance`, a length.
    pub fn solved_to(mut self, tolerance: f64) -> Start {
        self.scene.solver.tolerance = Some(tolerance);
        self
    }
}

pub(super) fn sphere(radius: f64) -> Shape {
    Shape::Sphere { radius }
}

pub(super) fn rod(diameter: f64, length: f64) -> Shape {
    Shape::Spherocylinder { diameter, length }
}

pub(super) fn ellipsoid(radii: [f64; 3]) -> Shape {
    Shape::Ellipsoid { radii }
}

pub(super) fn ring(major_radius: f64, minor_radius: f64) -> Shape {
    Shape::Torus { major_radius, minor_radius }
}

pub(super) fn body(shape: Shape, position: [f64; 3], orientation: DQuat) -> Body {
    let DQuat { x, y, z, w } = orientation;
    with!(orientation: Some([w, x, y, z]), ..Body::new(shape, position))
}

pub(super) fn upright(shape: Shape, position: [f64; 3]) -> Body {
    body(shape, position, DQuat::IDENTITY)
}

pub(super) fn moving(body: Body, velocity: [f64; 3], angular_velocity: [f64; 3]) -> Body {
    with!(velocity: Some(velocity), angular_velocity: Some(angular_velocity), ..body)
}

/// Draws from a seed.
pub(super) struct Random(ChaCha8Rng);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Random(ChaCha8Rng::seed_from_u64(seed))
    }

    /// The stream of a seed that belongs to a number: each is there without those before it.
    pub(super) fn of_stream(seed: u64, number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        Random(random)
    }

    /// Any number.
    pub(super) fn any(&mut self) -> u64 {
        u64::from(self.0.random::<u32>())
    }

    /// Whether something of probability `part` is so.
    pub(super) fn chance(&mut self, part: f64) -> bool {
        self.within(0.0, 1.0) < part
    }

    /// Uniform in the logarithm.
    pub(super) fn log_within(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    /// A whole number under `count`, which is not zero.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.within(0.0, count as f64) as usize).min(count.saturating_sub(1))
    }

    /// One of two.
    pub(super) fn either<T>(&mut self, part: f64, one: T, other: T) -> T {
        if self.chance(part) { one } else { other }
    }

    pub(super) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Uniform in the cube from -1 to 1.
    pub(super) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0))
    }

    pub(super) fn direction(&mut self) -> DVec3 {
        self.orientation() * DVec3::Z
    }

    /// Uniform over all (K. Shoemake, Graphics Gems III, 1992).
    pub(super) fn orientation(&mut self) -> DQuat {
        let (part, turns) = (self.within(0.0, 1.0), [self.within(0.0, 1.0), self.within(0.0, 1.0)]);
        let [(a, b), (c, d)] = turns.map(|turn| (std::f64::consts::TAU * turn).sin_cos());
        let (low, high) = ((1.0 - part).sqrt(), part.sqrt());
        DQuat::from_xyzw(low * a, low * b, high * c, high * d).normalize()
    }
}

/// Positions are multiples of this, so that a shift by a whole number to under 2^32 changes no difference of them.
const GRID: f64 = 1.0 / (1 << 20) as f64;

/// `count` bodies of these shapes in turn, anywhere in the cube from `-half` to `half`, overlaps and all.
pub(super) fn heap(seed: u64, shapes: &[Shape], count: usize, half: f64) -> Vec<Body> {
    let mut random = Random::new(seed);
    let shapes = shapes.iter().cycle().take(count);
    let place = |shape: &Shape| {
        let position = (half / GRID * random.vector()).round() * GRID;
        body(*shape, position.to_array(), random.orientation())
    };
    shapes.map(place).collect()
}
