//! Bodies that are added to a running simulation obey the rules of a scene's own.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::nearest::nearest;
use super::super::{Body, Scene};
use super::MAX_BODIES;
use crate::digits::exact;
use crate::scene::FaultKind;

impl Scene {
    /// The index of a group, as in [`Bodies::group`](crate::bodies::Bodies::group).
    ///
    /// # Errors
    /// [`SceneError`] with the nearest name, if no body of the scene starts in this group.
    pub fn group_index(&self, name: &str) -> Result<u32, SceneError> {
        let names = self.group_names();
        let index = (0..).zip(&names).find(|(_, known)| *known == name);
        index.map(|(index, _)| index).ok_or_else(|| unknown_group(&Key::ROOT.field("group"), name, &names))
    }

    /// Checks bodies that are added at `time` to `present` others; keys are those of a list `bodies`.
    ///
    /// # Errors
    /// What a scene with these bodies would be refused for, a group that this scene does not have, `fixed` and
    /// `lineage`.
    pub(crate) fn check_added(&self, added: &[Body], time: f64, present: usize) -> Result<(), SceneError> {
        let (list, names) = (Key::ROOT.field("bodies"), self.group_names());
        if (present + added.len()) as u64 > MAX_BODIES {
            let message = format!("{} bodies; at most {MAX_BODIES}", present + added.len());
            return Err(SceneError::new(FaultKind::TooLarge, list, message));
        }
        for (i, body) in added.iter().enumerate() {
            let key = list.index(i);
            self.check_new(&key, body, &names)?;
        }
        if added.is_empty() { Ok(()) } else { self.with_only(added, time).validate() }
    }

    /// What a body of a scene may have, and one that is added may not.
    fn check_new(&self, key: &Key, body: &Body, names: &[String]) -> Result<(), SceneError> {
        if body.lineage.is_some() {
            return Err(SceneError::bad(key.field("lineage"), "is given by the simulation to a body that is added"));
        }
        if body.fixed {
            let message = "has no meaning for a body that is added; give it a group with `fixed` in the scene";
            return Err(SceneError::bad(key.field("fixed"), message));
        }
        if self.planar && body.position[2] != self.plane() {
            let (plane, z) = (exact(self.plane()), exact(body.position[2]));
            let message = format!("bodies of a planar scene share one z, here {plane}, not {z}");
            return Err(SceneError::bad(key.field("position").index(2), message));
        }
        match &body.group {
            Some(group) if !names.contains(group) => Err(unknown_group(&key.field("group"), group, names)),
            _ => Ok(()),
        }
    }

    /// This scene at `time` with no other bodies, and without what names bodies or groups that are not among them.
    fn with_only(&self, added: &[Body], time: f64) -> Scene {
        let mut scene = self.clone();
        (scene.bodies, scene.generate) = (added.to_vec(), Vec::new());
        scene.bonds.clear();
        scene.joints.clear();
        scene.removal.clear();
        scene.next_id = None;
        // Those would add these bodies again.
        #[cfg(feature = "files")]
        scene.changes.clear();
        scene.forget_empty_groups();
        scene.time.start = time;
        scene.time.end = self.time.end.max(time);
        scene
    }
}

/// What is wrong with a group that no body of the scene starts in.
fn unknown_group(key: &Key, group: &str, names: &[String]) -> SceneError {
    let known = match (names.is_empty(), nearest(group, names.iter().map(String::as_str))) {
        (true, _) => "the scene has no groups".to_owned(),
        (false, Some(near)) => format!("did you mean `{near}`?"),
        (false, None) => format!("the scene's groups are {}", names.join(", ")),
    };
    SceneError::bad(key, format!("no body of the scene starts in the group `{group}`; {known}"))
}
