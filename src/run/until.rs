//! Continuing past a run's end.

use crate::digits::exact;
use crate::record::{Header, scene_hash};
use crate::scene::Scene;

/// The recorded scene with a later end and the same interval of states; or the reason why this is not possible, with a
/// remedy.
pub(super) fn extended(scene: &Scene, taken: u64, until: f64) -> Result<Scene, String> {
    // Changes may have set other steps than those of the scene.
    let time = scene.steps_before(taken);
    let last = time.steps();
    // NaN is not a later time.
    if until < time.end || until.is_nan() {
        let early = if taken < last { SHORT_OF_ITS_END } else { "" };
        return Err(format!("its end is at time {}; name a later one, not {}{early}", exact(time.end), exact(until)));
    }
    if taken >= last && time.span(last) < 1.0 && until > time.end {
        return Err(format!(
            "time.dt, {}, does not divide its time, so its last step was shorter; start a new run from its final.json",
            exact(time.dt)
        ));
    }
    let mut extended = scene.clone();
    extended.output.every = scene.output_every();
    extended.time.end = until;
    extended.validate().map_err(|error| error.to_string())?;
    Ok(extended)
}

/// Whether a checkpoint belongs to this scene, also after a crash between the later end in `scene.json` and its
/// checkpoint.
pub(super) fn is_of(header: &Header, scene: &Scene) -> bool {
    let mut ended = scene.clone();
    ended.time.end = header.time;
    header.scene == scene_hash(scene) || header.scene == scene_hash(&ended)
}

/// What follows where a run has not come to its end.
const SHORT_OF_ITS_END: &str = " (it has not come there: resume it without another end; if growth.stop ended it, start \
                                a new run from its final.json, with another growth.stop)";

/// The reason for a run whose bodies were all removed.
pub(super) const EMPTY: &str = "no body is left; start a new run";

/// The reason for a run that `growth.stop` ended.
pub(super) const STOPPED: &str = "growth.stop ended it, which a later end does not lift; start a new run from its \
                                  final.json, with another growth.stop";
