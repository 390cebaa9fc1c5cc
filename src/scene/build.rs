//! From a scene to its starting bodies, and from bodies back to a scene.

use super::error::SceneError;
use super::orientation::written;
use super::{Body, Growth, Scene, generate};
use crate::bodies::{Bodies, Lineage, NO_GROUP};
use crate::dynamics::bonds::daughters::ENDS;
use crate::separation::Placed;
use crate::walls::left;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

impl Scene {
    /// The names of the groups, in order of first appearance in `bodies`, then `generate`: [`Bodies::group`] indexes
    /// them.
    pub fn group_names(&self) -> Vec<String> {
        let given = self.bodies.iter().map(|b| b.group.as_deref());
        let generated = self.generated().map(|(_, (.., group))| group);
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
    /// Everything that [`Scene::validate`] refuses, and a rule of `generate` that finds no free position for a body.
    pub fn build(&self) -> Result<Bodies, SceneError> {
        self.build_while(&mut |_| true)
    }

    /// [`Scene::build`] with an option to stop, as placing many bodies may take minutes. Every few thousand draws it
    /// calls `goes_on` with the number of bodies placed so far, and stops if that returns `false`.
    ///
    /// ```
    /// use relcp::scene::{FaultKind, Generate, Time};
    /// use relcp::{Scene, Shape};
    /// let mut scene = Scene::new("many", Time::new(0.1, 1.0));
    /// let shape = Shape::Sphere { radius: 0.5 };
    /// scene.generate.push(Generate::isotropic(10_000, shape, Some(0.02)));
    /// let stopped = scene.build_while(&mut |placed| placed < 100);
    /// assert_eq!(stopped.unwrap_err().kind(), FaultKind::Interrupted);
    /// ```
    ///
    /// # Errors
    /// As [`Scene::build`], and [`FaultKind::Interrupted`](super::FaultKind) if it was stopped.
    pub fn build_while(&self, goes_on: &mut dyn FnMut(usize) -> bool) -> Result<Bodies, SceneError> {
        self.validate()?;
        let names = self.group_names();
        let numbers: HashMap<&str, u32> = names.iter().map(String::as_str).zip(0..).collect();
        let group_of = |name: Option<&str>| name.and_then(|n| numbers.get(n).copied()).unwrap_or(NO_GROUP);
        let mut bodies = Bodies { periods: self.periods(), planar: self.planar, ..Bodies::default() };
        for body in &self.bodies {
            let placed =
                Placed { shape: body.shape, position: DVec3::from(body.position), orientation: body.rotation() };
            let index = bodies.push(placed, group_of(body.group.as_deref()));
            bodies.velocity[index] = body.velocity.map_or(DVec3::ZERO, DVec3::from);
            if let Some(ends) = body.daughter_bonds {
                let count = bodies.len();
                for (column, end) in ENDS.into_iter().zip(ends) {
                    bodies.columns.named_mut(column, count)[index] = end as f64;
                }
            }
            bodies.angular_velocity[index] = body.angular_velocity.map_or(DVec3::ZERO, DVec3::from);
        }
        for index in 0..self.generate.len() {
            let groups: Vec<u32> = self.generate[index].components().map(|(.., group)| group_of(group)).collect();
            generate::add(self, index, &mut bodies, &groups, goes_on)?;
        }
        self.add_lineage(&mut bodies);
        bodies.bonds = self.held_bonds(&bodies);
        Ok(bodies)
    }

    /// The ids of the starting bodies, an infinite sequence: a body without lineage gets the next id after the largest
    /// in the scene.
    pub(super) fn ids(&self) -> impl Iterator<Item = u64> + '_ {
        let given = self.bodies.iter().map(|b| b.lineage.map(|line| line.id)).chain(std::iter::repeat(None));
        // A parent's id stays reserved after the parent has divided or was removed.
        let taken = self.bodies.iter().filter_map(|b| b.lineage).map(|l| l.id.max(l.parent.unwrap_or(0)) + 1);
        // A bond of daughters has the number of the mother's id and one: those of the scene are not given again.
        let numbers = self.bodies.iter().filter_map(|b| b.daughter_bonds).flatten().max();
        let mut next = taken.chain(numbers).max().unwrap_or(0).max(self.next_id.unwrap_or(0));
        given.map(move |id| {
            id.unwrap_or_else(|| {
                next += 1;
                next - 1
            })
        })
    }

    fn add_lineage(&self, bodies: &mut Bodies) {
        let given = |i: usize| self.bodies.get(i).and_then(|b| b.lineage);
        for (i, (line, id)) in bodies.lineage.iter_mut().zip(self.ids()).enumerate() {
            let founder = Lineage { id, parent: None, birth: self.time.start, generation: 0, birth_length: None };
            *line = given(i).map_or(founder, Lineage::from);
        }
    }

    /// A scene that starts from `bodies` at `time` and continues this one: full precision, groups, lineage, and
    /// velocities if the law has inertia. Its `end` is this scene's, or `time` if that is later. Its steps draw other
    /// random numbers than this scene's, because it starts at another time.
    ///
    /// [`Simulation::final_scene`](crate::Simulation::final_scene) also knows the ids of cells that have died.
    ///
    /// `bodies` must originate from this scene, so that their group indices are this scene's.
    pub fn final_scene(&self, bodies: &Bodies, time: f64) -> Scene {
        let names = self.group_names();
        let (inertial, fixed) = (self.dynamics.has_inertia(), self.fixed());
        let written_bodies = (0..bodies.len()).map(|i| Body {
            shape: bodies.shape[i],
            position: bodies.position[i].to_array(),
            orientation: Some(written(bodies.orientation[i])),
            axis: None,
            angle: None,
            fixed: fixed.holds(bodies.lineage[i].id, NO_GROUP),
            velocity: inertial.then(|| bodies.velocity[i].to_array()),
            angular_velocity: inertial.then(|| bodies.angular_velocity[i].to_array()),
            group: names.get(bodies.group[i] as usize).cloned(),
            daughter_bonds: daughter_bonds(bodies, i),
            lineage: Some(bodies.lineage[i].into()),
        });
        let mut scene = self.with_defaults();
        scene.bodies = written_bodies.collect();
        scene.walls = left(&scene.walls, &bodies.walls);
        (scene.bonds, scene.joints) = self.bonds().left(bodies);
        scene.generate = Vec::new();
        if !scene.removal.is_empty() || scene.group_names().len() < names.len() {
            scene.forget_empty_groups();
        }
        scene.time.start = time;
        scene.time.end = self.time.end.max(time);
        scene
    }
}

/// The numbers of the bonds at both ends of a cell, if it has any.
fn daughter_bonds(bodies: &Bodies, i: usize) -> Option<[u64; 2]> {
    let ends = ENDS.map(|end| bodies.columns.get(end).map_or(0, |column| column[i] as u64));
    (ends != [0, 0]).then_some(ends)
}

impl Scene {
    /// Drops the settings of groups that no body is in.
    pub(super) fn forget_empty_groups(&mut self) {
        let names = self.group_names();
        let lives = |group: Option<&str>| group.is_none_or(|group| names.iter().any(|name| name == group));
        self.forces.retain(|force| lives(force.group()));
        self.growth.retain(|growth| lives(growth.group.as_deref()));
        self.removal.retain(|rule| lives(rule.group.as_deref()));
        self.groups.retain(|name, _| lives(Some(name)));
        self.contact.friction.groups.retain(|of| of.between.iter().all(|name| lives(Some(name))));
        // Species without bodies are omitted.
        let grows: Vec<Growth> = self.growing().map(|(_, _, _, growth, _)| growth.clone()).collect();
        self.growth.retain(|growth| grows.contains(growth));
    }
}
