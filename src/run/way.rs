//! The displacement of bodies in a step, which shows whether the step is much too long; and other warnings of a run.

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

/// Warnings for the user of a run, once each: about its scene, about the displacement of its bodies in a step, and
/// about the largest gap that friction left at a contact that pushes.
pub(super) fn warnings(scene: &Scene, farthest: f64, friction_gap: f64) -> Vec<String> {
    let moved = warning(scene, farthest).filter(|_| scene.long_step().is_none());
    let rough = of_friction(scene.contact.overlap_tolerance.max(scene.elastic_slip()), friction_gap);
    scene.warnings().into_iter().chain(moved).chain(rough).collect()
}

/// A step whose friction leaves a larger gap than `allowed` is taken in pieces, and the shortest pieces as they are.
fn of_friction(allowed: f64, gap: f64) -> Option<String> {
    (gap > allowed).then(|| {
        format!(
            "friction left gaps of up to {} where bodies slide, more than the {} that a step allows: forces are rough there; a smaller time.dt or coefficient helps",
            few(gap),
            few(allowed)
        )
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_of_friction_that_no_piece_of_a_step_could_close_are_told() {
        assert_eq!(of_friction(1e-4, 1e-4), None);
        let told = of_friction(1e-4, 0.25).unwrap();
        assert!(told.contains("up to 0.25") && told.contains(&few(1e-4)), "{told}");
    }
}
