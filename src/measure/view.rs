//! A state with the data that several measures need, computed once.

use super::{Frame, LeftOut, Settings, axis};
use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, BroadPhase, Grid, Periodic};
use crate::dynamics::virial_of_wall;
use crate::record::{ContactForce, Snapshot, TOUCHING, contacts};
use crate::separation::{branch, is_branch, separate_in};
use crate::shape::Shape;
use crate::walls::surface_of;
use crate::warm::Warm;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// A state, and the data that its measures share.
pub struct View<'a> {
    /// The state.
    pub state: &'a Snapshot,
    /// Information from its run's scene.
    pub frame: &'a Frame,
    /// The user's settings.
    pub settings: &'a Settings,
    /// The mean of the bodies' centres.
    pub centre: DVec3,
    /// The bodies' axes as unit vectors; see [`axis`].
    pub axes: Vec<Option<DVec3>>,
    /// The bodies' volumes; in the plane the areas of their sections.
    pub volumes: Vec<f64>,
    contacts: OnceLock<Vec<ContactForce>>,
}

impl<'a> View<'a> {
    /// The view of a state.
    pub fn new(state: &'a Snapshot, frame: &'a Frame, settings: &'a Settings) -> Self {
        let bodies = &state.bodies;
        let each = || bodies.shape.par_iter().zip(&bodies.orientation);
        let volume = |(shape, q): (&crate::shape::Shape, &glam::DQuat)| match frame.planar {
            true => shape.section(*q),
            false => shape.volume(),
        };
        View {
            state,
            frame,
            settings,
            centre: bodies.centre(),
            axes: each().map(|(shape, q)| axis(shape, *q, frame.planar)).collect(),
            volumes: each().map(volume).collect(),
            contacts: OnceLock::new(),
        }
    }

    /// The bodies.
    pub fn bodies(&self) -> &'a Bodies {
        &self.state.bodies
    }

    /// Whether it is a state of a planar run.
    pub fn planar(&self) -> bool {
        self.frame.planar
    }

    /// Refuses a measure of outlines or of distances from a centre in periodic space.
    ///
    /// # Errors
    /// [`LeftOut`] in periodic space.
    pub fn in_open_space(&self) -> Result<(), LeftOut> {
        match self.bodies().periods.is_none() {
            true => Ok(()),
            false => Err("a periodic scene has no outline and no centre".into()),
        }
    }

    /// The dimension, two or three.
    pub fn dimension(&self) -> f64 {
        if self.planar() { 2.0 } else { 3.0 }
    }

    /// Volume of a ball of this radius; in the plane the area of a disc.
    pub fn ball(&self, radius: f64) -> f64 {
        if self.planar() { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) }
    }

    /// Distance of body `i`'s centre from the centre of all.
    pub fn distance(&self, i: usize) -> f64 {
        self.bodies().position[i].distance(self.centre)
    }

    /// Width of bins of distance.
    pub fn bin(&self) -> f64 {
        self.settings.bin.unwrap_or_else(|| median(self.bodies().shape.iter().map(|shape| shape.thickness())))
    }

    /// The length of a rod, or of another body that grows.
    pub fn length(&self, shape: &Shape) -> Option<f64> {
        let grown = || self.frame.growth.iter().find_map(|growth| growth.length_of(shape));
        shape.rod_length().or_else(grown)
    }

    /// The distance up to which pairs touch.
    pub fn cutoff(&self) -> f64 {
        let thinnest = self.bodies().shape.iter().map(|shape| shape.thickness()).reduce(f64::min);
        self.settings.cutoff.unwrap_or(TOUCHING * thinnest.unwrap_or(0.0))
    }

    /// The contacts, as in an export.
    pub fn contacts(&self) -> &[ContactForce] {
        self.contacts.get_or_init(|| contacts(self.state, Some(self.cutoff())))
    }

    /// The contacts nearer than the cutoff.
    pub fn touching(&self) -> impl Iterator<Item = &ContactForce> {
        let cutoff = self.cutoff();
        self.contacts().iter().filter(move |contact| contact.separation <= cutoff)
    }

    /// The forces that the last step ended with, by branch or sub-sphere.
    ///
    /// # Errors
    /// [`LeftOut`] if the state has none.
    pub fn forces(&self) -> Result<&[Warm], LeftOut> {
        let Some(warm) = &self.state.warm else {
            return Err(
                "the state has no contact forces: only a checkpoint has, and states of a run with output.forces".into(),
            );
        };
        match self.state.step {
            0 => Err("no step has been taken, so there are no contact forces".into()),
            _ => Ok(warm),
        }
    }

    /// The contacts that push, with forces above zero.
    ///
    /// # Errors
    /// [`LeftOut`] if the state has no contact forces, or only those of sub-spheres.
    pub fn pushing(&self) -> Result<impl Iterator<Item = &ContactForce>, LeftOut> {
        let warm = self.forces()?;
        if warm.iter().any(|warm| surface_of(warm.pair[1]).is_none() && !is_branch(warm.feature)) {
            return Err("the contact forces are those of sub-spheres".into());
        }
        Ok(self.contacts().iter().filter(|contact| contact.gamma > 0.0))
    }

    /// The contact forces of pairs of bodies, each where it acts: a pair can touch in several places.
    ///
    /// # Errors
    /// As [`View::pushing`].
    pub fn pushes(&self) -> Result<impl Iterator<Item = Push>, LeftOut> {
        let _ = self.pushing()?;
        let of_bodies = self.state.warm.iter().flatten();
        let of_bodies = of_bodies.filter(|w| surface_of(w.pair[1]).is_none() && w.gamma > 0.0);
        Ok(of_bodies.filter_map(|warm| {
            let pair = warm.pair.map(|body| body as usize);
            let [of_a, of_b] = self.bodies().pair(pair[0], pair[1]);
            let nearest = separate_in(self.bodies().planar)(&of_a, &of_b, None)?;
            let found = branch(&of_a, &of_b, &nearest, warm.feature);
            let delta = of_b.position - of_a.position;
            let lever = 0.5 * (found.lever_a + delta + found.lever_b);
            Some(Push { pair, force: warm.force(found.normal), delta, lever })
        }))
    }

    /// The virial of each body's own contacts, including walls: the sum of force times lever. Divided by the body's
    /// volume and the dimension it is the body's pressure.
    ///
    /// # Errors
    /// As [`View::pushing`].
    pub fn virials(&self) -> Result<Vec<f64>, LeftOut> {
        let mut virials = vec![0.0; self.bodies().len()];
        for Push { pair: [a, b], force, delta, lever } in self.pushes()? {
            virials[a] += force.dot(lever);
            virials[b] -= force.dot(lever - delta);
        }
        for warm in self.state.warm.iter().flatten().filter(|warm| surface_of(warm.pair[1]).is_some()) {
            virials[warm.pair[0] as usize] += virial_of_wall(self.bodies(), warm).unwrap_or(0.0);
        }
        Ok(virials)
    }

    /// The pairs of bodies in `among`, by their indices in it, whose centres (in periodic space the nearest images) are
    /// at most `radius` apart.
    pub fn neighbours(&self, among: &[usize], radius: f64) -> Vec<[u32; 2]> {
        let at = |i: u32| self.bodies().position[among[i as usize]];
        let half = DVec3::splat(0.5 * radius);
        let boxes: Vec<Aabb> = among.iter().map(|&i| Aabb::from_centre(self.bodies().position[i], half)).collect();
        let mut pairs = Vec::new();
        let periods = self.bodies().periods;
        Periodic::new(Grid::default(), periods).pairs(&boxes, &mut pairs);
        pairs.retain(|[a, b]| periods.nearest(at(*b) - at(*a)).length_squared() <= radius * radius);
        pairs
    }
}

/// A contact force.
pub struct Push {
    pub pair: [usize; 2],
    /// Of the first body on the second.
    pub force: DVec3,
    /// From the first one's centre to the image of the second that it touches.
    pub delta: DVec3,
    /// From the first one's centre to the point of contact.
    pub lever: DVec3,
}

/// The median; the lower of the two middle values of an even number. Zero without values.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return 0.0;
    }
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
