//! The displacement of bodies in a step, which shows whether the step is much too long.

use crate::bodies::Bodies;
use crate::digits::{few, significant};
use crate::scene::Scene;
use crate::scene::remarks::{FARTHEST, PROPOSED};

/// The largest displacement of a body in a step by its velocity, in its own thicknesses. Not for scenes with a flow,
/// which carries all bodies alike.
pub(super) fn farthest(scene: &Scene, bodies: &Bodies) -> f64 {
    let cell_flows = scene.periodic.is_some_and(|cell| cell.changes());
    if scene.flow.is_some() || cell_flows {
        return 0.0;
    }
    let ways = bodies.velocity.iter().zip(&bodies.shape).map(|(v, shape)| v.length() / shape.thickness());
    scene.time.dt * ways.fold(0.0, f64::max)
}

/// Warnings for the user of a run: about its scene, and about the displacement of its bodies in a step, once each.
pub(super) fn warnings(scene: &Scene, farthest: f64) -> Vec<String> {
    let moved = warning(scene, farthest).filter(|_| scene.long_step().is_none());
    scene.warnings().into_iter().chain(moved).collect()
}

fn warning(scene: &Scene, farthest: f64) -> Option<String> {
    let proposed = scene.time.dt * PROPOSED / farthest;
    (farthest > FARTHEST).then(|| {
        format!(
            "bodies move by up to {} thicknesses in a step: time.dt is too long for accurate contacts; with {} they move by a tenth",
            few(farthest),
            significant(proposed, 1)
        )
    })
}
