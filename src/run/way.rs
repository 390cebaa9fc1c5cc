//! The displacement of bodies in a step, which shows whether the step is much too long; and other warnings of a run.

use crate::bodies::Bodies;
use crate::digits::{beside, few, short, significant};
use crate::record::Totals;
use crate::scene::Scene;
use crate::scene::remarks::{FARTHEST, PROPOSED};
use crate::step::deepest_pair_but;

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

/// Warnings for the user of a run, once each: about its scene, about overlaps at its start, about the displacement of
/// its bodies in a step, and about the largest gap that friction left at a contact that pushes.
pub(super) fn warnings(scene: &Scene, totals: &Totals) -> Vec<String> {
    let (farthest, allowed) = (totals.farthest_way, scene.contact.overlap_tolerance);
    let start = (totals.start_max_overlap > allowed).then(|| of_start("bodies", totals.start_max_overlap, allowed));
    let moved = warning(scene, farthest).filter(|_| scene.long_step().is_none());
    let rough = of_friction(allowed.max(scene.elastic_slip()), totals.largest_friction_gap);
    scene.warnings().into_iter().chain(start).chain(moved).chain(rough).collect()
}

/// A warning if bodies of a scene's start overlap by more than its tolerance, with the worst pair. Bodies past walls
/// are refused.
pub fn start_warning(scene: &Scene, bodies: &Bodies) -> Option<String> {
    let allowed = scene.contact.overlap_tolerance;
    let ([a, b], overlap) = deepest_pair_but(&scene.fixed(), bodies).filter(|(_, overlap)| *overlap > allowed)?;
    Some(of_start(&format!("bodies {a} and {b}"), overlap, allowed))
}

fn of_start(whose: &str, overlap: f64, allowed: f64) -> String {
    let overlap = beside(overlap, allowed);
    format!(
        "{whose} overlap by {overlap} at the start, {} is allowed: the first step parts them at once",
        short(allowed)
    )
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
    use crate::scene::{Body, Time};
    use crate::shape::Shape;

    #[test]
    fn overlaps_at_the_start_are_told_with_their_bodies() {
        let mut scene = Scene::new("balls", Time::new(0.01, 1.0));
        let ball = |x: f64| Body::new(Shape::Sphere { radius: 0.5 }, [x, 0.0, 0.0]);
        scene.bodies = vec![ball(0.0), ball(2.0), ball(2.75)];
        let told = start_warning(&scene, &scene.build().unwrap()).unwrap();
        assert!(told.starts_with("bodies 1 and 2 overlap by 0.25 at the start"), "{told}");
        // Nothing parts fixed bodies.
        scene.bodies.iter_mut().for_each(|body| body.fixed = true);
        assert_eq!(start_warning(&scene, &scene.build().unwrap()), None);
    }

    #[test]
    fn gaps_of_friction_that_no_piece_of_a_step_could_close_are_told() {
        assert_eq!(of_friction(1e-4, 1e-4), None);
        let told = of_friction(1e-4, 0.25).unwrap();
        assert!(told.contains("up to 0.25") && told.contains(&few(1e-4)), "{told}");
    }
}
