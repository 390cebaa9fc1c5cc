//! A state with the edits of a change.

use super::limits::{Limits, number, vector};
use super::{Change, ChangeError, Edit, Values, Which};
use crate::bodies::{Bodies, Lineage, NO_GROUP};
use crate::scene::{Body, SMALLEST_QUATERNION, Scene, quaternion_norm, unit_quaternion};
use crate::separation::Placed;
use crate::step::State;
use crate::walls::surface_of;
use glam::{DQuat, DVec3};

/// The state after all edits.
pub(in crate::simulation) struct Applied {
    pub state: State,
    /// The ids of added bodies.
    pub added: Vec<u64>,
    /// Whether anything differs.
    pub differs: bool,
    /// Whether bodies were added, moved, turned or lengthened.
    pub placed: bool,
    /// Whether bodies were added or removed.
    pub counted: bool,
    /// Whether bodies were lengthened.
    pub lengthened: bool,
    /// The bodies that were moved, turned or lengthened, whose multipliers no longer fit.
    moved: Vec<bool>,
    /// The bodies that an edit has named.
    touched: Vec<bool>,
}

/// A row of the values that were given, and the body that it is for.
#[derive(Clone, Copy)]
struct At<'a> {
    what: &'a str,
    row: usize,
    body: usize,
}

impl At<'_> {
    fn refused(self, bodies: &Bodies, why: String) -> ChangeError {
        let (row, body) = (self.row, self.body);
        ChangeError::Value { what: self.what.to_owned(), row, body, id: bodies.lineage[body].id, why }
    }
}

impl Limits {
    /// The state after a change.
    pub(in crate::simulation) fn apply(
        &self,
        scene: &Scene,
        state: &State,
        change: &Change,
    ) -> Result<Applied, ChangeError> {
        let none = vec![false; state.bodies.len()];
        let mut applied = Applied {
            state: state.clone(),
            added: Vec::new(),
            differs: false,
            placed: false,
            counted: false,
            lengthened: false,
            moved: none.clone(),
            touched: none,
        };
        for edit in &change.edits {
            match edit {
                Edit::Set(which, values) => applied.set(self, which, values)?,
                Edit::Add(bodies) => applied.add(scene, bodies)?,
                Edit::Remove(which) => applied.remove(which)?,
                Edit::Share(share) => {
                    let shared = applied.share(self, share);
                    let refused = |(body, why)| At { what: "length", row: body, body }.refused(&state.bodies, why);
                    shared.map_err(refused)?;
                }
            }
        }
        applied.finish(self, scene)
    }
}

impl Applied {
    fn set(&mut self, limits: &Limits, which: &Which, values: &Values) -> Result<(), ChangeError> {
        let chosen = which.indices(&self.state.bodies)?;
        if chosen.len() != values.len() {
            let (what, found) = (values.name().to_owned(), values.len());
            return Err(ChangeError::Count { what, found, expected: chosen.len() });
        }
        let what = values.name();
        if let (Values::Column(..), true) = (values, what.is_empty()) {
            return Err(ChangeError::Which("a column needs a name".into()));
        }
        for (row, body) in chosen.into_iter().enumerate() {
            let set = self.set_one(limits, values, row, body);
            set.map_err(|why| At { what, row, body }.refused(&self.state.bodies, why))?;
            self.touched[body] = true;
        }
        Ok(())
    }

    /// Notes that a body has another length and another place.
    pub(super) fn lengthened(&mut self, body: usize) {
        (self.moved[body], self.touched[body]) = (true, true);
        (self.lengthened, self.differs) = (true, true);
    }

    /// Gives body `i` the value of a row.
    fn set_one(&mut self, limits: &Limits, values: &Values, row: usize, i: usize) -> Result<(), String> {
        let bodies = &mut self.state.bodies;
        let count = bodies.len();
        let differs = match values {
            Values::Position(of) => {
                limits.position(of[row])?;
                let moves = replaced(&mut bodies.position[i], of[row]);
                self.moved[i] |= moves;
                moves
            }
            Values::Orientation(of) => {
                let turns = replaced(&mut bodies.orientation[i], normalized(of[row])?);
                self.moved[i] |= turns;
                turns
            }
            Values::Velocity(of) => {
                limits.velocity(bodies, i, of[row], false)?;
                replaced(&mut bodies.velocity[i], of[row])
            }
            Values::AngularVelocity(of) => {
                limits.velocity(bodies, i, of[row], true)?;
                replaced(&mut bodies.angular_velocity[i], of[row])
            }
            Values::Length(of) => {
                let shape = limits.lengthened(bodies, i, of[row])?;
                let lengthens = replaced(&mut bodies.shape[i], shape);
                self.moved[i] |= lengthens;
                self.lengthened |= lengthens;
                lengthens
            }
            Values::Rate(of) => {
                limits.rate(bodies, i, of[row])?;
                replaced(&mut bodies.columns.growth_mut(i, count).rate, Some(of[row]))
            }
            Values::DivisionLength(of) => {
                limits.division_length(bodies, i, of[row])?;
                replaced(&mut bodies.columns.growth_mut(i, count).division_length, Some(of[row]))
            }
            Values::Group(of) => {
                limits.group(of[row])?;
                let joins = replaced(&mut bodies.group[i], of[row]);
                if joins && limits.is_fixed(bodies, i) {
                    (bodies.velocity[i], bodies.angular_velocity[i]) = (DVec3::ZERO, DVec3::ZERO);
                }
                joins
            }
            Values::Column(name, of) => {
                number(of[row])?;
                let is_new = bodies.columns.get(name).is_none();
                replaced(&mut bodies.columns.named_mut(name, count)[i], of[row]) || is_new
            }
        };
        self.differs |= differs;
        Ok(())
    }

    fn add(&mut self, scene: &Scene, added: &[Body]) -> Result<(), ChangeError> {
        let State { bodies, next_id, step, .. } = &mut self.state;
        let time = scene.time.after(*step);
        scene.check_added(added, time, bodies.len())?;
        let names = scene.group_names();
        for body in added {
            let group = body.group.as_ref().and_then(|group| names.iter().position(|name| name == group));
            let placed =
                Placed { shape: body.shape, position: DVec3::from(body.position), orientation: body.rotation() };
            let i = bodies.push(placed, group.map_or(NO_GROUP, |group| group as u32));
            bodies.velocity[i] = body.velocity.map_or(DVec3::ZERO, DVec3::from);
            bodies.angular_velocity[i] = body.angular_velocity.map_or(DVec3::ZERO, DVec3::from);
            bodies.lineage[i] = Lineage { id: *next_id, parent: None, birth: time, generation: 0, birth_length: None };
            self.added.push(*next_id);
            *next_id += 1;
            self.moved.push(true);
            self.touched.push(true);
        }
        self.counted |= !added.is_empty();
        self.differs |= !added.is_empty();
        self.state.unrounded = None;
        Ok(())
    }

    fn remove(&mut self, which: &Which) -> Result<(), ChangeError> {
        let gone = which.indices(&self.state.bodies)?;
        let mut keep = vec![true; self.state.bodies.len()];
        gone.iter().for_each(|i| keep[*i] = false);
        self.state.remove(&keep, &[]);
        crate::bodies::kept(&mut self.moved, &keep);
        crate::bodies::kept(&mut self.touched, &keep);
        self.counted |= !gone.is_empty();
        self.differs |= !gone.is_empty();
        Ok(())
    }

    /// Checks what bodies are after all edits, and drops the multipliers that no longer fit.
    fn finish(mut self, limits: &Limits, scene: &Scene) -> Result<Applied, ChangeError> {
        let State { bodies, warm, step, .. } = &mut self.state;
        let cutoff = scene.cutoff_of(bodies.shape.iter().copied());
        let walls = scene.walls().at(scene.time.after(*step)).gone(&bodies.walls);
        for (body, _) in self.touched.iter().enumerate().filter(|(_, touched)| **touched) {
            let checked = limits.body(scene, bodies, body, (&walls, cutoff));
            checked.map_err(|(what, why)| At { what, row: body, body }.refused(bodies, why))?;
        }
        let moved = |body: u32| self.moved.get(body as usize).copied().unwrap_or(false);
        warm.retain(|w| !moved(w.pair[0]) && (surface_of(w.pair[1]).is_some() || !moved(w.pair[1])));
        if let Some(cells) = &limits.model.cells {
            cells.settle(bodies);
        }
        self.placed = self.moved.contains(&true);
        self.state.changed |= self.placed;
        Ok(self)
    }
}

/// Sets a value, and says whether it is another one.
fn replaced<T: PartialEq>(place: &mut T, value: T) -> bool {
    let differs = *place != value;
    if differs {
        *place = value;
    }
    differs
}

/// A rotation as a scene has it: one that is normalized stays as it is.
fn normalized(q: DQuat) -> Result<DQuat, String> {
    vector(q.xyz())?;
    number(q.w)?;
    let numbers = [q.w, q.x, q.y, q.z];
    let norm = quaternion_norm(numbers);
    if norm < SMALLEST_QUATERNION {
        return Err(format!("has the norm {norm:e}; it is normalized, so it must be at least {SMALLEST_QUATERNION:e}"));
    }
    Ok(unit_quaternion(numbers))
}
