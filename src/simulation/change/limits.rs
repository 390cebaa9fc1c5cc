//! What a scene allows its bodies to be.

use crate::bodies::{Bodies, NO_GROUP};
use crate::digits::{at_most, exact, short};
use crate::dynamics::Species;
use crate::scene::{LARGEST_NUMBER, Scene};
use crate::shape::{PLANAR_TOLERANCE, Shape};
use crate::step::Model;
use crate::walls::Walls;
use glam::DVec3;
use std::f64::consts::LN_2;

/// What a scene allows its bodies to be; it does not depend on the state.
pub(in super::super) struct Limits {
    pub model: Model,
    /// The z of all bodies, in a planar scene.
    pub plane: Option<f64>,
}

/// Why a value is not allowed.
pub(super) type Refused = Result<(), String>;

/// A finite number of a magnitude that scenes allow.
pub(super) fn number(value: f64) -> Refused {
    if !value.is_finite() {
        return Err(format!("must be finite, not {value}"));
    }
    if value.abs() > LARGEST_NUMBER {
        return Err(format!("must be at most {LARGEST_NUMBER:e} in magnitude, not {}", exact(value)));
    }
    Ok(())
}

/// Three such numbers.
pub(super) fn vector(value: DVec3) -> Refused {
    value.to_array().into_iter().try_for_each(number)
}

impl Limits {
    pub fn of(scene: &Scene) -> Limits {
        Limits { model: scene.model(), plane: scene.planar.then(|| scene.plane()) }
    }

    /// How a body grows, if it does.
    pub fn species(&self, bodies: &Bodies, i: usize) -> Option<Species<'_>> {
        Some(self.model.cells.as_ref()?.of_body(bodies.group[i], &bodies.shape[i])?.0)
    }

    pub fn is_fixed(&self, bodies: &Bodies, i: usize) -> bool {
        self.model.fixed.holds(bodies.lineage[i].id, bodies.group[i])
    }

    pub fn position(&self, position: DVec3) -> Refused {
        vector(position)?;
        match self.plane {
            Some(plane) if position.z != plane => {
                let (z, plane) = (exact(position.z), exact(plane));
                Err(format!("has z = {z}; bodies of this planar scene have z = {plane}"))
            }
            _ => Ok(()),
        }
    }

    /// A velocity, or an angular one, of body `i`.
    pub fn velocity(&self, bodies: &Bodies, i: usize, velocity: DVec3, angular: bool) -> Refused {
        vector(velocity)?;
        if !self.model.dynamics.has_inertia() {
            return Err("has no meaning without inertia, where forces make the velocity of each step".into());
        }
        if velocity != DVec3::ZERO && self.is_fixed(bodies, i) {
            return Err("must be zero for a body that is fixed".into());
        }
        let out = if angular { velocity.truncate() != glam::DVec2::ZERO } else { velocity.z != 0.0 };
        match self.plane.is_some() && out {
            true if angular => Err("must have x and y zero in a planar scene".into()),
            true => Err("must have z zero in a planar scene".into()),
            false => Ok(()),
        }
    }

    /// The shape of a body at another length.
    pub fn lengthened(&self, bodies: &Bodies, i: usize, length: f64) -> Result<Shape, String> {
        number(length)?;
        let shape = bodies.shape[i];
        if shape.rod_length().is_none() && self.species(bodies, i).is_none() {
            let message = "has no length that can be set; spherocylinders and ellipsoids that grow have";
            return Err(format!("a {} {message}", shape.name()));
        }
        let least = shape.shortest_length();
        let longer = shape.grown(length).ok_or_else(|| {
            let what = if shape.rod_length().is_some() { "the diameter" } else { "the diameter of its tips" };
            format!("must be at least {what}, {}, not {}", short(least), exact(length))
        })?;
        longer.validate().map_err(|no| no.to_string())?;
        Ok(longer)
    }

    /// A growth rate of body `i`.
    pub fn rate(&self, bodies: &Bodies, i: usize, rate: f64) -> Refused {
        number(rate)?;
        if rate < 0.0 {
            return Err(format!("must not be negative, not {}", exact(rate)));
        }
        if rate * self.model.time.dt >= LN_2 {
            return Err(format!("a cell would divide more than once in a step of {}", exact(self.model.time.dt)));
        }
        self.grows(bodies, i)
    }

    /// A division length of body `i`.
    pub fn division_length(&self, bodies: &Bodies, i: usize, length: f64) -> Refused {
        if length.is_nan() || length <= 0.0 {
            return Err(format!("must be positive, not {length}"));
        }
        self.grows(bodies, i)
    }

    fn grows(&self, bodies: &Bodies, i: usize) -> Refused {
        let grows = self.species(bodies, i).is_some() && !self.is_fixed(bodies, i);
        if grows { Ok(()) } else { Err("the body does not grow: `growth` of the scene has no entry for it".into()) }
    }

    pub fn group(&self, group: u32) -> Refused {
        let groups = &self.model.groups;
        if group == NO_GROUP || (group as usize) < groups.len() {
            return Ok(());
        }
        let message = format!("{group} is no group: the scene has {}, from 0", groups.len());
        Err(message)
    }

    /// What a body must be after all edits, with the quantity at fault.
    pub fn body(
        &self,
        scene: &Scene,
        bodies: &Bodies,
        i: usize,
        (walls, cutoff): (&Walls, f64),
    ) -> Result<(), (&'static str, String)> {
        let (shape, placed) = (&bodies.shape[i], bodies.placed(i));
        let grows = self.species(bodies, i).is_some();
        if grows && self.is_fixed(bodies, i) {
            return Err(("group", "the body would grow, which a fixed body cannot".into()));
        }
        if self.plane.is_some() {
            if !shape.is_planar_symmetric(placed.orientation) {
                return Err(("orientation", "the body must be mirrored by the plane of the scene".into()));
            }
            if grows && (placed.orientation * DVec3::Z).z.abs() > PLANAR_TOLERANCE {
                let message = "a growing body of a planar scene must lie in the x-y plane";
                return Err(("orientation", message.into()));
            }
        }
        let tolerance = self.model.contact.overlap_tolerance;
        if let Some((depth, wall)) = walls.deepest(&placed).filter(|(depth, _)| *depth > tolerance) {
            return Err(("position", scene.outside(depth, wall)));
        }
        let span = 2.0 * shape.bounding_radius() + cutoff;
        match bodies.periods.shortest().filter(|period| span > 0.5 * period) {
            Some(period) => {
                let message = format!(
                    "the body and the cutoff span {} of a period of {}; at most half",
                    at_most(span),
                    short(period)
                );
                Err(("length", message))
            }
            None => Ok(()),
        }
    }
}
