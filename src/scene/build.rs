//! From a scene to its starting bodies, and from bodies back to a scene.

use super::error::SceneError;
use super::orientation::written;
use super::{Body, BodyLineage, Generate, Scene, generate};
use crate::bodies::{Bodies, Lineage, NO_GROUP};
use crate::separation::Placed;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

impl Scene {
    /// The names of the groups, in order of first appearance in `bodies`, then `generate`: [`Bodies::group`] indexes
    /// them.
    pub fn group_names(&self) -> Vec<String> {
        let given = self.bodies.iter().map(|b| b.group.as_deref());
        let generated = self.generate.iter().map(Generate::group);
        let mut seen = HashSet::new();
        given.chain(generated).flatten().filter(|name| seen.insert(*name)).map(str::to_owned).collect()
    }

    /// The starting bodies: those of `bodies`, then those of `generate` in order. The same scene gives the same bits.
    ///
    /// A body without lineage is its own founder, born at the start, with the next id after the largest that the scene
    /// gives.
    ///
    /// ```
    /// use relcp::scene::{Generate, Time};
    /// let mut scene = relcp::Scene::new("cell", Time::new(0.1, 1.0));
    /// scene.generate.push(Generate::founder(0.5, 2.0));
    /// assert_eq!(scene.build()?.len(), 1);
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// What [`Scene::validate`] refuses, and a rule of `generate` that finds no place for a body.
    pub fn build(&self) -> Result<Bodies, SceneError> {
        self.build_while(&mut |_| true)
    }

    /// As [`Scene::build`], which may take minutes where many bodies are placed by rule: asks `goes_on` every few
    /// thousand draws, with the number of bodies placed so far, and stops where it answers `false`.
    ///
    /// ```
    /// use relcp::scene::{FaultKind, Generate, Time};
    /// use relcp::{Scene, Shape};
    /// let mut scene = Scene::new("many", Time::new(0.1, 1.0));
    /// let shape = Shape::Sphere { radius: 0.5 };
    /// scene.generate.push(Generate::Isotropic { count: 10_000, shape, volume_fraction: Some(0.02), group: None });
    /// let stopped = scene.build_while(&mut |placed| placed < 100);
    /// assert_eq!(stopped.unwrap_err().kind(), FaultKind::Interrupted);
    /// ```
    ///
    /// # Errors
    /// As [`Scene::build`], and [`FaultKind::Interrupted`](super::FaultKind) where it was stopped.
    pub fn build_while(&self, goes_on: &mut dyn FnMut(usize) -> bool) -> Result<Bodies, SceneError> {
        self.validate()?;
        let names = self.group_names();
        let numbers: HashMap<&str, u32> = names.iter().map(String::as_str).zip(0..).collect();
        let group_of = |name: Option<&str>| name.and_then(|n| numbers.get(n).copied()).unwrap_or(NO_GROUP);
        let mut bodies = Bodies { periods: self.periods(), ..Bodies::default() };
        for body in &self.bodies {
            let placed =
                Placed { shape: body.shape, position: DVec3::from(body.position), orientation: body.rotation() };
            let index = bodies.push(placed, group_of(body.group.as_deref()));
            bodies.velocity[index] = body.velocity.map_or(DVec3::ZERO, DVec3::from);
            bodies.angular_velocity[index] = body.angular_velocity.map_or(DVec3::ZERO, DVec3::from);
        }
        for index in 0..self.generate.len() {
            generate::add(self, index, &mut bodies, group_of(self.generate[index].group()), goes_on)?;
        }
        self.add_lineage(&mut bodies);
        Ok(bodies)
    }

    fn add_lineage(&self, bodies: &mut Bodies) {
        let ids = self.ids(bodies.len());
        for (i, (lineage, id)) in bodies.lineage.iter_mut().zip(ids).enumerate() {
            *lineage = match self.lineage_given(i) {
                Some(given) => given.into(),
                None => Lineage { id, parent: None, birth: self.time.start, generation: 0, birth_length: None },
            };
        }
    }

    fn lineage_given(&self, body: usize) -> Option<BodyLineage> {
        self.bodies.get(body).and_then(|b| b.lineage)
    }

    /// The ids of the first `bodies` starting bodies.
    pub(super) fn ids(&self, bodies: usize) -> Vec<u64> {
        // A parent's id is taken too, although the parent is no more.
        let taken = self.bodies.iter().filter_map(|b| b.lineage).map(|l| l.id.max(l.parent.unwrap_or(0)) + 1);
        let mut free = taken.max().unwrap_or(0)..;
        (0..bodies).filter_map(|i| self.lineage_given(i).map(|line| line.id).or_else(|| free.next())).collect()
    }

    /// A scene that starts from `bodies` at `time` and goes on as this one: full precision, groups, lineage, and
    /// velocities where the law has inertia. Its `end` is this scene's, or `time` where that is later.
    ///
    /// `bodies` must have been built from this scene, so that their group numbers are this scene's.
    pub fn final_scene(&self, bodies: &Bodies, time: f64) -> Scene {
        let names = self.group_names();
        let inertial = self.dynamics.has_inertia();
        let written_bodies = (0..bodies.len()).map(|i| Body {
            shape: bodies.shape[i],
            position: bodies.position[i].to_array(),
            orientation: Some(written(bodies.orientation[i])),
            axis: None,
            angle: None,
            fixed: self.bodies.get(i).is_some_and(|body| body.fixed),
            velocity: inertial.then(|| bodies.velocity[i].to_array()),
            angular_velocity: inertial.then(|| bodies.angular_velocity[i].to_array()),
            group: names.get(bodies.group[i] as usize).cloned(),
            lineage: Some(bodies.lineage[i].into()),
        });
        let mut scene = self.with_defaults();
        scene.bodies = written_bodies.collect();
        scene.bonds = self.bonds().left(bodies);
        scene.generate = Vec::new();
        scene.time.start = time;
        scene.time.end = self.time.end.max(time);
        scene
    }
}

impl Generate {
    /// The group of the bodies that this rule makes.
    pub fn group(&self) -> Option<&str> {
        match self {
            Generate::Isotropic { group, .. } | Generate::Chainmail { group, .. } | Generate::Founder { group, .. } => {
                group.as_deref()
            }
        }
    }
}
