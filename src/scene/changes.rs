//! Changes of a scene's keys during a run: `changes`.
//!
//! A change at the time `at` acts from the first step on that begins at or after it. The scene of the steps after `k`
//! changes is the one before with the values of the `k`-th change, in order. So a scene with changes determines its run
//! alone: the run resumes and repeats to the same bits. Defaults that depend on other keys follow them at each change,
//! also those that a run has written into its `scene.json`.

use super::error::{FaultKind, SceneError};
use super::set::Override;
use super::{Body, Scene, Wall, read};
use crate::digits::{exact, few};
use crate::step::Time;
use glam::DQuat;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, HashSet};

/// Other values of keys from a time on, and bodies that leave and come then.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct KeyChange {
    /// It acts from the first step on that begins at or after this time.
    pub at: f64,
    /// The new values by their dotted keys, as `--set` has them: `{ "growth.rate": 0.5, "time.dt": 0.01 }`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, Value>,
    /// The ids of bodies that are taken out, with their bonds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remove: Vec<u64>,
    /// Bodies that are placed, as in `bodies`, in groups of the scene. They get the next free ids. Where they overlap
    /// others, the next step parts them first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub add: Vec<Body>,
}

impl KeyChange {
    /// At the time `at`, these values of dotted keys.
    pub fn new(at: f64, set: impl IntoIterator<Item = (String, Value)>) -> Self {
        KeyChange { at, set: set.into_iter().collect(), remove: Vec::new(), add: Vec::new() }
    }

    /// The same, and these bodies leave and come.
    #[must_use]
    pub fn with_bodies(self, remove: Vec<u64>, add: Vec<Body>) -> Self {
        KeyChange { remove, add, ..self }
    }

    /// Whether bodies leave or come.
    pub(crate) fn is_of_bodies(&self) -> bool {
        !(self.remove.is_empty() && self.add.is_empty())
    }
}

/// Keys that the state of a run has settled.
const SETTLED: [&str; 7] = ["planar", "periodic", "bodies", "generate", "groups", "next_id", "time.start"];

/// Keys of a bond that a state has settled, beside the number of bonds.
const SETTLED_OF_BONDS: [&str; 2] = ["bodies", "at"];

/// The same of a joint, after its number and its name.
const SETTLED_OF_JOINTS: [&str; 4] = ["bodies", "at", "axis", "rest"];

/// The same of a field, after its name.
const SETTLED_OF_FIELDS: [&str; 5] = ["cells", "spacing", "center", "initial", "values"];

/// Keys of the run as a whole, which a change within it cannot set.
const OF_RUN: [&str; 6] = ["name", "time.end", "output", "removal", "changes", "solver.dump"];

/// Keys that decide which contacts multipliers belong to.
const OF_CONTACTS: [&str; 2] = ["contact.method", "contact.rows"];

/// A time that is later than a step's start by this part of the step counts as its start.
const ROUNDING: f64 = 1e-6;

/// Whether a state has settled a dotted key.
pub(crate) fn is_settled(key: &str) -> bool {
    let of_bond = |key: &str| {
        let (_, of) = key.split_once('.').unwrap_or_default();
        of.is_empty() || SETTLED_OF_BONDS.iter().any(|settled| is_in(of, settled))
    };
    let of_joint = |key: &str| {
        let of = key.splitn(3, '.').nth(2).unwrap_or_default();
        of.is_empty() || SETTLED_OF_JOINTS.iter().any(|settled| is_in(of, settled))
    };
    let of_field = |key: &str| {
        let of = key.split_once('.').unwrap_or_default().1;
        of.is_empty() || SETTLED_OF_FIELDS.iter().any(|settled| is_in(of, settled))
    };
    SETTLED.iter().any(|settled| is_in(key, settled))
        || key == "fields"
        || key.strip_prefix("fields.").is_some_and(of_field)
        || key == "joints"
        || key.strip_prefix("joints.").is_some_and(of_joint)
        || key == "bonds"
        || key.strip_prefix("bonds.").is_some_and(of_bond)
}

/// Whether a change during a run can set a dotted key, or keys inside of it.
pub(super) fn may_change(key: &str) -> bool {
    !is_settled(key) && !OF_RUN.iter().any(|of| is_in(key, of))
}

/// Whether a change of a dotted key makes multipliers of a state meaningless.
pub(crate) fn is_of_contacts(key: &str) -> bool {
    OF_CONTACTS.iter().any(|of| is_in(key, of) || is_in(of, key))
}

/// Whether a dotted key is `of`, or inside of it.
pub(crate) fn is_in(key: &str, of: &str) -> bool {
    key.strip_prefix(of).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// What follows the changes so far.
#[derive(Clone, Debug)]
pub(crate) struct Changed {
    /// The scene from a step on.
    pub scene: Scene,
    /// Steps taken before.
    pub step: u64,
    /// Whether multipliers of before fit the contacts of after.
    pub keeps_multipliers: bool,
}

impl Scene {
    /// The scene after change number `index` of this one; `before` is the scene before it.
    ///
    /// # Errors
    /// A key that does not exist or cannot change, a value that the scene refuses.
    pub(crate) fn changed(&self, before: &Scene, index: usize, not_before: u64) -> Result<Changed, SceneError> {
        let change = &self.changes[index];
        let named = |key: &str| format!("changes.{index}.set.{key}");
        let step = before.time.first_at(change.at).max(not_before);
        let mut sets = Vec::new();
        for (key, value) in &change.set {
            if is_settled(key) || OF_RUN.iter().any(|of| is_in(key, of) || is_in(of, key)) {
                let why = "cannot change during a run";
                return Err(SceneError::new(FaultKind::BadValue, named(key), why));
            }
            sets.push(Override::of_value(named(key), key, value.clone())?);
        }
        let under = |fault: SceneError| fault.under(&format!("changes.{index}.set"));
        let mut scene = before.with_sets(&sets).map_err(under)?;
        scene.follow_defaults(before);
        // As a run of its own, since the start that its steps seem to have may be far off.
        scene.time.start = self.time.start;
        scene.check_without_changes().map_err(under)?;
        scene.time = scene.time.continuing(&before.time, step);
        scene.check_bodies_of(change, index, before.time.after(step))?;
        if let Some((wall, why)) = scene.jump_from(before, before.time.after(step)) {
            return Err(under(SceneError::bad(format!("walls.{wall}"), why)));
        }
        Ok(Changed { scene, step, keeps_multipliers: !change.set.keys().any(|key| is_of_contacts(key)) })
    }

    /// The bodies that a change removes and adds at a time, as far as a scene knows of them.
    fn check_bodies_of(&self, change: &KeyChange, index: usize, time: f64) -> Result<(), SceneError> {
        if !change.is_of_bodies() {
            return Ok(());
        }
        let mut seen = HashSet::new();
        if let Some(twice) = change.remove.iter().position(|id| !seen.insert(id)) {
            let why = format!("names the body {} a second time", change.remove[twice]);
            return Err(SceneError::bad(format!("changes.{index}.remove.{twice}"), why));
        }
        self.check_added(&change.add, time, 0).map_err(|fault| match fault.key().strip_prefix("bodies") {
            Some(rest) => SceneError::new(fault.kind(), format!("changes.{index}.add{rest}"), fault.message()),
            None => fault.under(&format!("changes.{index}.add")),
        })
    }

    /// A wall that moves in one of two scenes and would jump if this one followed the other at a time, and by how much.
    pub(crate) fn jump_from(&self, before: &Scene, time: f64) -> Option<(usize, String)> {
        let place = |wall: &Wall| wall.moved(time).map_or(wall.reference(), |moved| moved.reference + moved.shift);
        let turn = |wall: &Wall| wall.moved(time).and_then(|moved| moved.turn).unwrap_or(DQuat::IDENTITY);
        let moves = |wall: &Wall| wall.motion().is_some();
        let walls = before.walls.iter().zip(&self.walls).enumerate();
        let jump = |(number, (from, to)): (usize, (&Wall, &Wall))| {
            let jump = (place(to) - place(from)).length();
            let turned = turn(from).angle_between(turn(to));
            let far = jump > ROUNDING * (1.0 + place(from).length()) || turned > ROUNDING;
            (far && (moves(from) || moves(to))).then(|| {
                let (jump, turned, time) = (few(jump), few(turned), exact(time));
                let why = format!(
                    "would jump by {jump} and {turned} radians at time {time}: its motion counts from time 0; give the new motion a window \
                     from {time} on, and put the wall where it is then"
                );
                (number, why)
            })
        };
        walls.filter_map(jump).next()
    }

    /// The scene with other values of keys, but its own bodies, whose list may be long.
    fn with_sets(&self, sets: &[Override]) -> Result<Scene, SceneError> {
        let without = Scene { bodies: Vec::new(), generate: Vec::new(), changes: Vec::new(), ..self.clone() };
        let scene = read::reread(&without, sets)?;
        Ok(Scene {
            bodies: self.bodies.clone(),
            generate: self.generate.clone(),
            changes: self.changes.clone(),
            ..scene
        })
    }

    /// What follows each change, in order, up to the first that is not valid.
    fn all_changed(&self) -> impl Iterator<Item = Changed> {
        let mut last: Option<Changed> = None;
        (0..self.changes.len()).map_while(move |index| {
            let (before, from) = last.as_ref().map_or((self, 0), |last| (&last.scene, last.step));
            last = self.changed(before, index, from).ok();
            last.clone()
        })
    }

    /// The scene after each of its changes.
    #[cfg(feature = "gpu")]
    pub(crate) fn changed_scenes(&self) -> impl Iterator<Item = Scene> {
        self.all_changed().map(|changed| changed.scene)
    }

    /// The time after these steps. Changes that are not valid are left out.
    pub(crate) fn time_after(&self, step: u64) -> f64 {
        self.steps_before(step).after(step)
    }

    /// The steps by which the state after so many of them was made. Changes that are not valid are left out.
    pub(crate) fn steps_before(&self, step: u64) -> Time {
        // The state before a change that is due at it has the time of the steps before.
        let last = self.all_changed().take_while(|changed| changed.step < step).last();
        last.map_or(self.time, |changed| changed.scene.time)
    }

    /// The scene by which the state after these steps was made, with the changes before it.
    #[cfg(feature = "python")]
    pub(crate) fn after(&self, step: u64) -> Option<Scene> {
        self.all_changed().take_while(|changed| changed.step < step).last().map(|changed| changed.scene)
    }

    /// Checks `changes`: their order, their keys, and that the scene after each is valid.
    pub(super) fn check_changes(&self) -> Result<(), SceneError> {
        let mut scene = None;
        let (mut last, mut step) = (f64::NEG_INFINITY, 0);
        for (index, change) in self.changes.iter().enumerate() {
            // NaN is not in order.
            if !(change.at >= last && change.at.is_finite()) {
                let why = "must be a number, not before the change above it";
                return Err(SceneError::bad(format!("changes.{index}.at"), why));
            }
            last = change.at;
            let changed = self.changed(scene.as_ref().unwrap_or(self), index, step)?;
            (step, scene) = (changed.step, Some(changed.scene));
        }
        Ok(())
    }
}

impl Time {
    /// The number of steps before the first one that begins at or after a time.
    fn first_at(&self, time: f64) -> u64 {
        ((time - self.start) / self.dt - ROUNDING).ceil().max(0.0) as u64
    }

    /// These steps after the first `step` ones of another, with a start such that the time goes on.
    pub(crate) fn continuing(self, before: &Time, step: u64) -> Time {
        let time = before.after(step);
        // With the same steps the time goes on to the same bits.
        let start = match self {
            Time { dt, .. } if dt == before.dt => before.start,
            same if same.after(step) == time => same.start,
            other => time - step as f64 * other.dt,
        };
        Time { start, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_settles_bodies_and_space_and_leaves_the_rest() {
        for key in ["planar", "bodies.3.shape", "bonds", "bonds.2", "bonds.2.bodies.0", "time.start", "periodic.x"] {
            assert!(is_settled(key), "{key}");
        }
        for key in ["growth.rate", "bonds.2.stiffness", "time.end", "planar_too", "walls", "seed"] {
            assert!(!is_settled(key), "{key}");
        }
        assert!(is_of_contacts("contact") && is_of_contacts("contact.method.multisphere.count"));
        assert!(!is_of_contacts("contact.friction"));
    }

    #[test]
    fn changes_follow_each_other_and_the_time_goes_on() {
        let text = r#"{ "name": "ball", "time": { "dt": 0.1, "end": 2 },
            "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ],
            "forces": [ { "uniform": { "force": [1, 0, 0] } } ],
            "changes": [ { "at": 0.55, "set": { "time.dt": 0.05 } },
                         { "at": 1, "set": { "forces.0.uniform.force": [0, 1, 0], "dynamics.overdamped.drag": 2 } } ] }"#;
        let scene = Scene::parse(text, "ball.json").unwrap();
        let first = scene.changed(&scene, 0, 0).unwrap();
        assert_eq!((first.step, first.scene.time.dt), (6, 0.05));
        assert!((first.scene.time.after(6) - 0.6).abs() < 1e-12);
        let second = scene.changed(&first.scene, 1, first.step).unwrap();
        assert_eq!(second.step, 14);
        assert_eq!(second.scene.time, first.scene.time);
        assert_eq!(second.scene.bodies, scene.bodies);
        assert_eq!(Scene::parse(&scene.to_json(), "copy").unwrap(), scene);
    }

    #[test]
    fn longer_steps_from_a_time_on_are_not_refused_for_the_start_that_they_seem_to_have() {
        let sets = ["time.end=3", "changes=[{\"at\": 2, \"set\": {\"time.dt\": 0.02}}, {\"at\": 2.5, \"set\": {}}]"];
        let scene = Scene::load("colony", sets).unwrap();
        let last = scene.all_changed().last().unwrap().scene;
        assert!(last.time.start < -30.0, "{:?}", last.time);
    }

    #[test]
    fn a_wall_goes_on_from_where_it_is() {
        let text = r#"{ "name": "ball", "time": { "dt": 0.1, "end": 2 },
            "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ],
            "walls": [ { "half_space": { "normal": [0, 0, 1], "offset": -9, "motion": { "velocity": [0, 0, 1] } } } ],
            "changes": [ { "at": 1, "set": { "walls.0.half_space.offset": -8,
                "walls.0.half_space.motion": { "velocity": [0, 0, 2], "window": { "from": 1 } } } } ] }"#;
        let scene = Scene::parse(text, "ball.json").unwrap();
        let after = scene.changed(&scene, 0, 0).unwrap().scene;
        let height = |scene: &Scene, time| scene.walls[0].moved(time).map(|at| (at.reference + at.shift).z).unwrap();
        assert!((height(&after, 1.0) - height(&scene, 1.0)).abs() < 1e-12);
        assert!((height(&after, 1.5) + 7.0).abs() < 1e-12);
    }

    #[test]
    fn the_table_of_keys_in_the_guide_is_that_of_the_code() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide.md");
        let guide = std::fs::read_to_string(path).unwrap();
        let rows = guide.split("| key | a change during a run |").nth(1).unwrap();
        let mut told = BTreeMap::new();
        for row in rows.lines().skip(2).take_while(|line| line.starts_with('|')) {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let keys = cells[1].split('`').skip(1).step_by(2);
            keys.for_each(|key| assert_eq!(told.insert(key.to_owned(), cells[2].to_owned()), None, "{key}"));
        }
        let schema = super::super::schema();
        let schema = serde_json::to_value(schema).unwrap();
        let keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
        for key in &keys {
            let says = told.get(*key).unwrap_or_else(|| panic!("docs/guide.md does not tell of {key}"));
            match says.split([',', ' ']).next() {
                Some("yes") => assert!(may_change(key), "{key}"),
                Some("no") => assert!(!may_change(key), "{key}"),
                _ => assert!(["time", "bonds", "joints", "fields"].contains(&key.as_str()), "{key}"),
            }
        }
        assert!(told.keys().all(|key| keys.contains(&key)), "{told:?}");
        for (key, may) in [
            ("time.dt", true),
            ("time.stepping", true),
            ("time.end", false),
            ("time.start", false),
            ("solver.dump", false),
            ("solver.kind", true),
            ("bonds.0.stiffness", true),
            ("bonds.0.at", false),
        ] {
            assert_eq!(may_change(key), may, "{key}");
        }
    }

    #[test]
    fn what_cannot_change_is_refused_with_its_key() {
        let parse = |changes: &str| {
            let text = format!(
                r#"{{ "name": "ball", "time": {{ "dt": 0.1, "end": 2 }},
                "bodies": [ {{ "shape": {{ "sphere": {{ "radius": 1 }} }}, "position": [0, 0, 0] }} ],
                "walls": [ {{ "half_space": {{ "normal": [0, 0, 1], "offset": -9,
                                             "motion": {{ "velocity": [0, 0, 1] }} }} }} ],
                "changes": {changes} }}"#
            );
            Scene::parse(&text, "ball.json")
        };
        for (changes, key) in [
            (r#"[{"at": 1, "set": {"planar": true}}]"#, "changes.0.set.planar"),
            (r#"[{"at": 1, "set": {"time": {"dt": 0.1, "end": 3}}}]"#, "changes.0.set.time"),
            (r#"[{"at": 1, "set": {"tim.dt": 0.1}}]"#, "tim"),
            (r#"[{"at": 1, "set": {"time.dt": -0.1}}]"#, "changes.0.set.time.dt"),
            (r#"[{"at": 1, "set": {"time.dt": "fast"}}]"#, "time.dt"),
            (r#"[{"at": 1, "set": {}}, {"at": 0.5, "set": {}}]"#, "changes.1.at"),
            (r#"[{"at": 1, "set": {"walls.0.half_space.motion.velocity": [0, 0, 2]}}]"#, "changes.0.set.walls.0"),
            (r#"[{"at": 1, "sets": {}}]"#, "changes.0.sets"),
            (r#"[{"at": 1, "remove": [3, 0, 3]}]"#, "changes.0.remove.2"),
            (r#"[{"at": 1, "remove": ["0"]}]"#, "changes.0.remove.0"),
            (
                r#"[{"at": 1, "add": [{"shape": {"sphere": {"radius": -1}}, "position": [0, 0, 0]}]}]"#,
                "changes.0.add.0.shape.sphere.radius",
            ),
            (
                r#"[{"at": 1, "add": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, -12]}]}]"#,
                "changes.0.add.0.position",
            ),
            (
                r#"[{"at": 1, "add": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0], "group": "a"}]}]"#,
                "changes.0.add.0.group",
            ),
            (
                r#"[{"at": 1, "add": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0], "fixed": true}]}]"#,
                "changes.0.add.0.fixed",
            ),
            (
                r#"[{"at": 1, "set": {"forces": [{"pull": {"body": 0, "target": [0, 0, 0], "stiffness": 1e3}}]}}]"#,
                "forces.0.pull.stiffness",
            ),
        ] {
            let refused = parse(changes).unwrap_err();
            assert!(refused.key().ends_with(key), "{changes}: {refused}");
            assert!(refused.to_string().contains("changes"), "{changes}: {refused}");
        }
    }
}
