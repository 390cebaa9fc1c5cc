//! Hands: a user of a run that goes on drags a body by a spring, places bodies and removes them. The spring is a
//! `pull`, the last of the scene's `forces`; each of its motions, and what is placed or removed, is one of the scene's
//! `changes`.

use super::Run;
use crate::dynamics::Force;
use crate::error::Error;
use crate::scene::{Body, FaultKind, KeyChange, Scene, SceneError};
use crate::shape::Shape;
use serde_json::{Value, json};

/// The part of the way to the hand that a free body goes in a step without inertia: ten steps to follow, a twentieth of
/// what is stable.
const FOLLOWS: f64 = 0.1;
/// The most that the spring moves a free body in a step without inertia, in its thicknesses: a step with contacts at a
/// quarter of the thickness never failed in tests of crowds and chainmail.
const FARTHEST: f64 = 0.25;
/// With inertia: the square of the spring's phase in a step, so that a period has 63 steps.
const PHASE_SQUARED: f64 = 0.01;
/// With inertia: the most that the spring moves a body at rest in a step, in its thicknesses. With critical damping the
/// body is never faster than a tenth of its thickness in a step.
const FARTHEST_FROM_REST: f64 = 0.02;

impl Run {
    /// Pulls the point `point` of a body, in body axes, towards a place from the present state on: a new pull, or
    /// another target of the one that pulls this body there already. The spring follows from the body and the step.
    ///
    /// # Errors
    /// As [`Run::change`]; no body has the id.
    pub fn pull(&mut self, body: u64, point: [f64; 3], target: [f64; 3]) -> Result<(), Error> {
        let scene = self.simulation.coming_scene();
        let target = if scene.planar { [target[0], target[1], scene.plane()] } else { target };
        if let Some((place, held)) = last_pull(&scene).filter(|(_, held)| held.body == body && held.point == point) {
            if held.target == target {
                return Ok(());
            }
            return self.change([(format!("forces.{place}.pull.target"), json!(target))].into());
        }
        let state = self.simulation.coming_state()?;
        let of = state.bodies.lineage.iter().position(|line| line.id == body);
        let Some(shape) = of.map(|row| state.bodies.shape[row]) else {
            return Err(SceneError::new(FaultKind::BadValue, "body", format!("no body has the id {body} now")).into());
        };
        let pull = spring(&scene, &shape, body, point, target);
        self.change([(format!("forces.{}", scene.forces.len()), pull)].into())
    }

    /// Removes and adds bodies from the present state on. In a planar scene the plane gives the z of those that come.
    ///
    /// # Errors
    /// As [`Run::change_by`].
    pub fn place(&mut self, remove: Vec<u64>, mut add: Vec<Body>) -> Result<(), Error> {
        let scene = self.simulation.scene();
        if scene.planar {
            let plane = scene.plane();
            add.iter_mut().for_each(|body| body.position[2] = plane);
        }
        self.change_by(KeyChange::new(self.simulation.time(), []).with_bodies(remove, add))
    }

    /// Ends the pull of [`Run::pull`] on a body, if there is one.
    ///
    /// # Errors
    /// As [`Run::change`].
    pub fn let_go(&mut self, body: u64) -> Result<(), Error> {
        let scene = self.simulation.coming_scene();
        match last_pull(&scene).filter(|(_, held)| held.body == body) {
            Some((place, _)) => self.change([("forces".into(), json!(scene.forces[..place]))].into()),
            None => Ok(()),
        }
    }
}

/// A pull of a scene.
struct Held {
    body: u64,
    point: [f64; 3],
    target: [f64; 3],
}

/// The last force, if it is a pull that always acts, and its place in the list.
fn last_pull(scene: &Scene) -> Option<(usize, Held)> {
    match scene.forces.last() {
        Some(&Force::Pull { body, point, target, window: None, .. }) => {
            Some((scene.forces.len() - 1, Held { body, point, target }))
        }
        _ => None,
    }
}

/// A pull that is stable, and that moves the body so little in a step that contacts are found in time.
fn spring(scene: &Scene, shape: &Shape, body: u64, point: [f64; 3], target: [f64; 3]) -> Value {
    let (way, turn) = scene.dynamics.yields(shape, scene.time.dt);
    // Beside the centre it also turns the body, by which the point gives way more.
    let lever = glam::DVec3::from(point).length_squared() * turn.max_element() / way;
    let (way, thickness) = (way * (1.0 + lever), shape.thickness());
    let pull = match scene.dynamics.has_inertia() {
        false => json!({ "body": body, "target": target, "stiffness": FOLLOWS / way, "point": point,
            "most": FARTHEST * thickness / way }),
        true => json!({ "body": body, "target": target, "stiffness": PHASE_SQUARED / way, "point": point,
            "most": FARTHEST_FROM_REST * thickness / way,
            "damping": 2.0 * PHASE_SQUARED.sqrt() * scene.time.dt / way }),
    };
    json!({ "pull": pull })
}
