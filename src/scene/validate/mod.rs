//! What a scene must satisfy beyond its types, and the limits of a run.
//!
//! Every rule names its key. Starting bodies may overlap, even be concentric: the first step parts them. They may not
//! reach past a wall.

mod added;
mod bodies;
mod bonds;
mod drag;
mod fields;
mod flow;
mod forces;
mod friction;
mod generate;
mod growth;
mod joints;
mod loads;
mod patterns;
mod periodic;
mod planar;
mod removal;
mod shapes;
mod shear;
mod strain;
mod walls;

use super::error::{FaultKind, SceneError};
use super::key::Key;
use super::{Dump, DumpWhen, MEASURES, Scene};
use crate::digits::{at_most, exact, few};
use crate::shape;
use crate::step::MOST_DUMPED;

/// Most bodies of a scene. A body's state is about 200 bytes and its contacts some ten times that, so this many need
/// tens of gigabytes.
pub const MAX_BODIES: u64 = 1 << 24;
/// Most steps of a run: at a microsecond a step, eleven days; and step numbers times `dt` keep four digits below a
/// step.
pub const MAX_STEPS: f64 = 1e12;
/// Most recorded states of a run; each is at least one file.
pub const MAX_STATES: f64 = 1e6;
/// Largest magnitude of any number: that of a size.
pub const LARGEST_NUMBER: f64 = shape::LARGEST_SIZE;
/// Smallest of the numbers that must be positive: that of a size.
pub const SMALLEST_NUMBER: f64 = shape::SMALLEST_SIZE;
/// Smallest norm of an orientation; below it the direction is made of rounding.
pub const SMALLEST_QUATERNION: f64 = 1e-6;
/// Longest name, in bytes: it names a folder, and file systems take 255 bytes with what a program appends.
const MAX_NAME_BYTES: usize = 128;

impl Scene {
    /// Checks that this scene can be run: numbers finite and in range, sizes positive, settings consistent.
    ///
    /// Scenes from files are already validated; this (and [`Scene::build`]) validates scenes made in code.
    ///
    /// # Errors
    /// [`SceneError`] with the key of the first fault; only the reader knows its location.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.check_without_changes()?;
        #[cfg(feature = "files")]
        self.check_changes()?;
        Ok(())
    }

    /// [`Scene::validate`], whatever its `changes`.
    pub(super) fn check_without_changes(&self) -> Result<(), SceneError> {
        let root = &Key::ROOT;
        self.check_name(root)?;
        self.check_time(&root.field("time"))?;
        self.check_dynamics(&root.field("dynamics"))?;
        self.check_bodies(root)?;
        self.check_generate(root)?;
        self.check_fixed(root)?;
        self.check_contact(&root.field("contact"))?;
        self.check_solver(&root.field("solver"))?;
        self.check_forces(&root.field("forces"))?;
        self.check_bonds(root)?;
        self.check_joints(root)?;
        self.check_thermal(root)?;
        self.check_flow(root)?;
        self.check_growth(&root.field("growth"))?;
        self.check_traps(&root.field("forces"))?;
        self.check_fields(&root.field("fields"))?;
        self.check_removal(&root.field("removal"))?;
        self.check_walls(root)?;
        self.check_friction(root)?;
        self.check_periodic(root)?;
        if self.planar {
            self.check_planar(root)?;
        }
        self.check_output(&root.field("output"))
    }

    fn check_name(&self, root: &Key) -> Result<(), SceneError> {
        let bad = |message: &str| Err(SceneError::bad(root.field("name"), message));
        if self.name.is_empty() || self.name == "." || self.name == ".." {
            return bad("must be a name; it names the run's folder");
        }
        if self.name.len() > MAX_NAME_BYTES {
            return bad(&format!("must be at most {MAX_NAME_BYTES} bytes long; it names the run's folder"));
        }
        if self.name.contains(|c: char| c == '/' || c == '\\' || c.is_control()) {
            return bad("must not contain slashes, backslashes or control characters; it names the run's folder");
        }
        Ok(())
    }

    fn check_time(&self, key: &Key) -> Result<(), SceneError> {
        let time = &self.time;
        positive(&key.field("dt"), time.dt)?;
        number(&key.field("start"), time.start)?;
        number(&key.field("end"), time.end)?;
        if time.end < time.start {
            return Err(SceneError::bad(
                key.field("end"),
                format!("must not be before time.start, {}", exact(time.start)),
            ));
        }
        let steps = (time.end - time.start) / time.dt;
        if steps > MAX_STEPS {
            let message = format!("the run would take {steps} steps; at most {MAX_STEPS:.0e}", steps = few(steps));
            return Err(SceneError::new(FaultKind::TooLarge, key.field("dt"), message));
        }
        Ok(())
    }

    fn check_solver(&self, key: &Key) -> Result<(), SceneError> {
        if let Some(tolerance) = self.solver.tolerance {
            positive(&key.field("tolerance"), tolerance)?;
            if tolerance > self.contact.overlap_tolerance {
                let limit = self.contact.overlap_tolerance;
                let message = format!("must not exceed contact.overlap_tolerance, {limit}", limit = at_most(limit));
                return Err(SceneError::bad(key.field("tolerance"), message));
            }
        }
        if self.solver.max_iterations == Some(0) {
            return Err(SceneError::bad(key.field("max_iterations"), "must be at least 1"));
        }
        self.solver.dump.map_or(Ok(()), |dump| check_dump(&dump, &key.field("dump")))
    }

    fn check_output(&self, key: &Key) -> Result<(), SceneError> {
        if let Some(every) = self.output.every {
            positive(&key.field("every"), every)?;
            let states = (self.time.end - self.time.start) / every;
            if states > MAX_STATES {
                let message =
                    format!("the run would record {states} states; at most {MAX_STATES:.0e}", states = few(states));
                return Err(SceneError::new(FaultKind::TooLarge, key.field("every"), message));
            }
        }
        if self.output.step_stride == 0 {
            return Err(SceneError::bad(key.field("step_stride"), "must be at least 1"));
        }
        let (key, names) = (key.field("measures"), &self.output.measures);
        for (i, name) in names.iter().enumerate() {
            if !MEASURES.contains(&name.as_str()) {
                let known = MEASURES.join(", ");
                return Err(SceneError::bad(
                    key.index(i),
                    format!("unknown measure {name:?}; the measures are {known}"),
                ));
            }
            if names[..i].contains(name) {
                return Err(SceneError::bad(key.index(i), "is listed twice"));
            }
        }
        Ok(())
    }
}

/// The rules of `solver.dump`.
fn check_dump(dump: &Dump, key: &Key) -> Result<(), SceneError> {
    if dump.products.is_some() && dump.when != DumpWhen::Slow {
        let message = "is for `when`: \"slow\", the solves that take at least so many products";
        return Err(SceneError::bad(key.field("products"), message));
    }
    if dump.products == Some(0) {
        return Err(SceneError::bad(key.field("products"), "must be at least 1"));
    }
    if dump.most.is_some_and(|most| most == 0 || most > MOST_DUMPED) {
        return Err(SceneError::bad(key.field("most"), format!("must be from 1 to {MOST_DUMPED}")));
    }
    Ok(())
}

/// A finite number of a sane magnitude.
fn number(key: &Key, value: f64) -> Result<(), SceneError> {
    if !value.is_finite() {
        return Err(SceneError::bad(key, "must be finite"));
    }
    if value.abs() > LARGEST_NUMBER {
        return Err(SceneError::bad(
            key,
            format!("must be at most {LARGEST_NUMBER:e} in magnitude, not {value}", value = exact(value)),
        ));
    }
    Ok(())
}

/// A number above zero.
fn positive(key: &Key, value: f64) -> Result<(), SceneError> {
    number(key, value)?;
    if value <= 0.0 {
        return Err(SceneError::bad(key, format!("must be positive, not {value}", value = exact(value))));
    }
    if value < SMALLEST_NUMBER {
        return Err(SceneError::bad(
            key,
            format!("must be at least {SMALLEST_NUMBER:e}, not {value}", value = exact(value)),
        ));
    }
    Ok(())
}

/// Three or four finite numbers.
fn numbers(key: &Key, values: &[f64]) -> Result<(), SceneError> {
    values.iter().enumerate().try_for_each(|(i, &v)| number(&key.index(i), v))
}
