//! The rules of periodic scenes: that bodies meet at one image only, and that all else of the scene has the same
//! periods.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::isotropic_volume;
use super::super::key::Key;
use super::super::{Generate, Growth, Scene};
use super::positive;
use crate::digits::{at_least, at_most, short};
use crate::periodic::Periods;
use crate::separation::Surface;
use crate::shape::Shape;

/// How far the volume fraction of a rule that fills a whole cell may be from what count and cell make of it, as a part
/// of that: enough to write it with two digits and more.
const FRACTION_SLACK: f64 = 0.02;

/// The names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

impl Scene {
    pub(super) fn check_periodic(&self, root: &Key) -> Result<(), SceneError> {
        let Some(periodic) = &self.periodic else { return Ok(()) };
        let key = root.field("periodic");
        let key = key.field("lengths");
        for (axis, length) in periodic.lengths.into_iter().enumerate() {
            let Some(length) = length else { continue };
            let key = key.index(axis);
            positive(&key, length)?;
            if length * f64::EPSILON > self.contact.overlap_tolerance {
                let message = "is so long that 64-bit floats are coarser there than contact.overlap_tolerance";
                return Err(SceneError::bad(key, message));
            }
            if self.planar && axis == 2 {
                return Err(SceneError::bad(key, "must be null in a planar scene, which has no extent along z"));
            }
            self.check_length(&key, length)?;
        }
        if periodic.lengths == [None; 3] {
            return Err(SceneError::bad(key, "must name the period of at least one axis; omit `periodic` for none"));
        }
        self.check_strain(root, periodic)?;
        self.check_shear(root, periodic)?;
        self.check_periodic_forces(root)?;
        self.check_periodic_walls(root, Periods::new(periodic.lengths))?;
        self.check_periodic_rules(root, self.periods())
    }

    /// Bodies so long, or growing so long, that a pair could meet at two images.
    pub(super) fn check_length(&self, key: &Key, length: f64) -> Result<(), SceneError> {
        let cutoff = self.cutoff();
        let growing = self.growing().map(|(list, index, shape, growth, _)| (list, index, self.longest(&shape, growth)));
        for (list, index, shape) in growing.chain(self.shapes()) {
            let longest = 2.0 * shape.bounding_radius();
            if longest + cutoff > 0.5 * length {
                let message = format!(
                    "must be at least {}, twice what the longest body and the cutoff take, not {length}: {list}.{index} {} {longest}, the cutoff is {cutoff}",
                    at_least(2.0 * (longest + cutoff)),
                    if self.is_as_given(list, index, &shape) { "measures" } else { "grows to" },
                    length = short(length),
                    longest = at_most(longest),
                    cutoff = short(cutoff)
                );
                return Err(SceneError::bad(key, message));
            }
        }
        Ok(())
    }

    /// Whether a body or the bodies of a rule have this shape at the start.
    fn is_as_given(&self, list: &str, index: usize, shape: &Shape) -> bool {
        self.shapes().any(|(of, at, given)| of == list && at == index && given == *shape)
    }

    /// A shape at the longest that it grows to.
    pub(super) fn longest(&self, shape: &Shape, growth: &Growth) -> Shape {
        let Some(length) = shape.growing_length() else { return *shape };
        let span = (self.time.dt, self.time.end - self.time.start);
        let division = growth.longest_division(length, shape.shortest_length(), span);
        shape.grown(length.max(division * (growth.fastest_rate() * self.time.dt).exp())).unwrap_or(*shape)
    }

    fn check_periodic_forces(&self, root: &Key) -> Result<(), SceneError> {
        for (i, force) in self.forces.iter().enumerate() {
            if force.is_radial() {
                let message = "needs a single centre, which a periodic scene does not have";
                return Err(SceneError::bad(root.field("forces").index(i).field(force.name()), message));
            }
        }
        for (i, growth) in self.growth.iter().enumerate() {
            if growth.stop.is_some_and(|stop| stop.radius.is_some()) {
                let (message, key) =
                    ("is the radius of a colony, which a periodic scene does not have", root.field("growth"));
                let entry = key.index(i);
                let entry = if self.is_one_growth() { &key } else { &entry };
                return Err(SceneError::bad(entry.field("stop").field("radius"), message));
            }
        }
        Ok(())
    }

    /// Walls stand along all periodic axes.
    fn check_periodic_walls(&self, root: &Key, periods: Periods) -> Result<(), SceneError> {
        for (i, wall) in self.walls.iter().enumerate() {
            for axis in (0..3).filter(|axis| periods.lengths()[*axis].is_some()) {
                if wall.surfaces(self.planar).iter().any(|surface| ends(surface, axis)) {
                    let message = format!(
                        "ends space along {}, where the scene is periodic; walls must be parallel to every periodic axis",
                        AXES[axis]
                    );
                    return Err(SceneError::bad(root.field("walls").index(i).field(wall.name()), message));
                }
            }
        }
        Ok(())
    }

    /// A rule that fills a whole cell has the volume fraction that its count makes there.
    fn check_periodic_rules(&self, root: &Key, periods: Periods) -> Result<(), SceneError> {
        let Some(cell) = periods.volume(self.planar) else { return Ok(()) };
        for (i, rule) in self.generate.iter().enumerate() {
            let Generate::Isotropic { volume_fraction: Some(volume_fraction), .. } = rule else { continue };
            let (count, fraction) = (rule.count(), isotropic_volume(rule, self.planar) / cell);
            if (volume_fraction / fraction - 1.0).abs() > FRACTION_SLACK {
                let message = format!(
                    "must be {fraction}, the volume fraction of {count} of these bodies in the periodic cell; omit it, or change the count or the cell",
                    fraction = short(fraction)
                );
                let key = root.field("generate");
                let key = key.index(i);
                return Err(SceneError::new(
                    FaultKind::BadValue,
                    key.field(rule.name()).field("volume_fraction"),
                    message,
                ));
            }
        }
        Ok(())
    }
}

/// Whether a surface ends somewhere along an axis.
fn ends(surface: &Surface, axis: usize) -> bool {
    match surface {
        Surface::Plane { normal, .. } => normal[axis] != 0.0,
        Surface::Sphere { .. } => true,
        Surface::Cylinder { axis: along, .. } => (0..3).any(|other| other != axis && along[other] != 0.0),
    }
}
