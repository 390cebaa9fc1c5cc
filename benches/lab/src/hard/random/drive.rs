//! The dynamics of a drawn scene: the law, forces, growth, speeds, spins, the step, and settings that differ from the
//! defaults.

use super::shapes::Mixture;
use crate::hard::start::Random;
use glam::DVec3;
use relcp::scene::{
    Body, ContactSettings, Drag, Dynamics, Force, Growth, OnFailure, OnNoRoom, Recursion, Scene, Solver, SolverKind,
    Stepping, Stop,
};

/// Two decades of steps.
pub(super) const DT: [f64; 2] = [1e-3, 1e-1];
/// What a force moves a free body by in a step, in its lengths: from far too little to be seen to a third of it.
const WAY: [f64; 2] = [1e-4, 0.3];
/// The same of the speeds at the start.
const SPEED: [f64; 2] = [1e-4, 0.3];
/// Turns of a spinning body in a step, in radians: up to the most that a step of constant velocity can mean.
const SPIN: [f64; 2] = [1e-3, 1.0];
/// Drags and densities.
const UNIT: [f64; 2] = [0.3, 3.0];
/// What cells grow by in a step.
const GROWTH: [f64; 2] = [1e-4, 2e-2];
/// Sensitivities to pressure that slow a pressed cell from a little to nearly to rest.
const SENSITIVITY: [f64; 2] = [1e-3, 1.0];
/// Overlap tolerances that are not the default.
const TOLERANCE: [f64; 2] = [1e-8, 1e-3];
/// The largest number of bodies by which a growing scene grows before it stops.
const POPULATION: u64 = 60;
/// Groups that forces may be on.
const GROUPS: [&str; 2] = ["a", "b"];

pub(super) fn dynamics(random: &mut Random) -> Dynamics {
    let unit = random.log_within(UNIT[0], UNIT[1]);
    random.either(0.5, Dynamics::Overdamped { drag: unit.into() }, Dynamics::Inertial { density: unit, drag: None })
}

pub(super) fn stepping(random: &mut Random) -> Stepping {
    random.either(0.3, Stepping::Midpoint, Stepping::Euler)
}

/// Growth of the rods, where there are any and the draw says so; noises of every size that is allowed.
pub(super) fn growth(random: &mut Random, mixture: &Mixture, dt: f64, bodies: u64) -> Option<Growth> {
    let thickest = mixture.thickest_rod()?;
    if random.chance(0.6) {
        return None;
    }
    let noise = |random: &mut Random, most: f64| {
        let drawn = random.within(0.0, most);
        random.either(0.5, drawn, 0.0)
    };
    let division_length_noise = noise(random, 0.3);
    let sensitivity = random.log_within(SENSITIVITY[0], SENSITIVITY[1]);
    let reorientation_degrees = noise(random, 20.0);
    Some(with!(
        rate: random.log_within(GROWTH[0], GROWTH[1]) / dt,
        division_length: Some(random.within(2.0, 4.0) * thickest / (1.0 - division_length_noise)),
        reorientation_degrees,
        division_length_noise,
        rate_noise: noise(random, 0.9),
        stress_sensitivity: random.either(0.3, sensitivity, 0.0),
        stop: Some(with!(population: Some(bodies + POPULATION), ..Stop::default())),
        on_no_room: random.either(0.3, OnNoRoom::Stall, OnNoRoom::Stop),
        ..Growth::new(0.0, 0.0)
    ))
}

/// Groups, forces, speeds and spins, for bodies that stand where they start.
pub(super) fn drive(random: &mut Random, scene: &mut Scene, reach: f64) -> String {
    let (dt, planar) = (scene.time.dt, scene.planar);
    if random.chance(0.3) {
        scene.bodies.iter_mut().for_each(|body| body.group = Some(GROUPS[random.below(GROUPS.len())].into()));
    }
    let forces = random.below(3);
    scene.forces = (0..forces).map(|_| force(random, scene, reach)).collect();
    let mut said: Vec<&str> = scene.forces.iter().map(named).collect();
    if scene.dynamics.has_inertia() {
        let moves = random.chance(0.5).then(|| random.log_within(SPEED[0], SPEED[1]) * reach / dt);
        let spins = random.chance(0.5).then(|| random.log_within(SPIN[0], SPIN[1]) / dt);
        said.extend(moves.map(|_| "moving"));
        said.extend(spins.map(|_| "spinning"));
        scene.bodies.iter_mut().for_each(|body| set_moving(random, body, moves, spins, planar));
    }
    if said.is_empty() { "nothing drives them".into() } else { said.join(", ") }
}

fn named(force: &Force) -> &'static str {
    match force {
        Force::Uniform { .. } => "uniform force",
        Force::Gravity { .. } => "gravity",
        Force::RadialInward { .. } => "drawn inwards",
        Force::RadialOutward { .. } => "driven outwards",
        Force::Propulsion { .. } => "propulsion",
        Force::Torque { .. } => "torque",
        _ => "trapped",
    }
}

fn vector(random: &mut Random, planar: bool) -> DVec3 {
    let vector = random.vector();
    if planar { vector.with_z(0.0) } else { vector }
}

fn force(random: &mut Random, scene: &Scene, reach: f64) -> Force {
    let dt = scene.time.dt;
    let named = random.below(GROUPS.len());
    // A group that no body is in would be refused.
    let group = scene.bodies.get(named).and_then(|body| body.group.clone()).filter(|_| random.chance(0.5));
    let way = random.log_within(WAY[0], WAY[1]) * reach;
    let along = vector(random, scene.planar);
    let radial = scene.periodic.is_none() && random.chance(0.5);
    match scene.dynamics {
        _ if radial => random.either(
            0.7,
            Force::RadialInward { group: group.clone(), window: None },
            Force::RadialOutward { group, window: None },
        ),
        Dynamics::Overdamped { drag: Drag::Even(drag) } => {
            let force = drag * 2.0 * reach * way / dt * along;
            Force::Uniform { force: force.to_array(), group, window: None }
        }
        Dynamics::Inertial { density, .. } if !random.chance(0.6) => {
            let mass = density * scene.bodies.first().map_or(1.0, |body| body.shape.volume());
            Force::Uniform { force: (0.02 * mass * way / (dt * dt) * along).to_array(), group, window: None }
        }
        // A body falls by this from rest in ten steps or so, not in one.
        _ => Force::Gravity { acceleration: (0.02 * way / (dt * dt) * along).to_array(), group, window: None },
    }
}

fn set_moving(random: &mut Random, body: &mut Body, moves: Option<f64>, spins: Option<f64>, planar: bool) {
    body.velocity = moves.map(|speed| (speed * vector(random, planar)).to_array());
    body.angular_velocity = spins.map(|rate| {
        let spin = rate * random.vector();
        if planar { [0.0, 0.0, spin.z] } else { spin.to_array() }
    });
}

/// Contact and solver: the defaults in four of five scenes.
pub(super) fn settings(random: &mut Random, thinnest: f64) -> (ContactSettings, Solver, String) {
    let (mut contact, mut solver) = (ContactSettings::default(), Solver::default());
    // A tolerance must be under the thinnest body's thickness.
    if contact.overlap_tolerance > 0.1 * thinnest {
        contact.overlap_tolerance = 1e-3 * thinnest;
    }
    if random.chance(0.8) {
        return (contact, solver, String::new());
    }
    let what = match random.below(5) {
        0 => {
            contact.overlap_tolerance = random.log_within(TOLERANCE[0], TOLERANCE[1]).min(0.1 * thinnest);
            format!("tolerance {:.0e}", contact.overlap_tolerance)
        }
        1 => {
            contact.recursion = Recursion::Inexact;
            "inexact recursion".into()
        }
        2 => {
            let kinds = [SolverKind::PairBlockCg, SolverKind::Bbpgd, SolverKind::Apgd, SolverKind::InteriorPoint];
            solver.kind = kinds[random.below(kinds.len())];
            format!("solver {:?}", solver.kind)
        }
        3 => {
            contact.on_failure = OnFailure::Continue;
            "going on after failures".into()
        }
        _ => {
            contact.cutoff = Some(random.either(0.5, 0.0, 0.5 * thinnest));
            "another cutoff".into()
        }
    };
    (contact, solver, what)
}
