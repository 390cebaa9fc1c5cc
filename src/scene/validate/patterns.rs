//! The rules of lattices, fences and chains.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::reach_of_link;
use super::super::key::Key;
use super::super::{Chain, ChainPath, Fence, Lattice, LatticeKind, Scene};
use super::generate::at_least;
use super::shapes::check_shape;
use super::walls::direction;
use super::{MAX_BODIES, number, numbers, positive};
use crate::digits::{exact, short};
use glam::DVec3;

/// The least number of bodies of a ring: two have one bond.
const LEAST_RING: u64 = 3;

impl Scene {
    pub(super) fn check_lattice(&self, key: &Key, lattice: &Lattice) -> Result<(), SceneError> {
        check_shape(&key.field("shape").field(lattice.shape.name()), &lattice.shape)?;
        positive(&key.field("spacing"), lattice.spacing)?;
        lattice.center.map_or(Ok(()), |center| numbers(&key.field("center"), &center))?;
        self.check_lattice_axis(key, lattice)?;
        match (lattice.counts, &lattice.region) {
            (Some(_), Some(_)) => {
                let message = "conflicts with `counts`: either gives the number of bodies; omit one of them";
                return Err(SceneError::bad(key.field("region"), message));
            }
            (None, None) => {
                let message = "is missing, and `region` too: one of them gives the number of bodies";
                return Err(SceneError::new(FaultKind::MissingKey, key.field("counts"), message));
            }
            (Some(counts), None) => return check_counts(&key.field("counts"), lattice.kind, counts),
            (None, Some(region)) => self.check_region(&key.field("region"), region)?,
        }
        let region = key.field("region");
        if !lattice.is_enclosed() {
            return Err(SceneError::bad(region, "must be closed, as a box, a sphere or a cylinder with a length is"));
        }
        match lattice.count() {
            0 => Err(SceneError::new(FaultKind::Placement, region, "has no site whose body is wholly inside")),
            count if count > MAX_BODIES => {
                let message = format!("has {count} sites; at most {MAX_BODIES}");
                Err(SceneError::new(FaultKind::TooLarge, region, message))
            }
            _ => Ok(()),
        }
    }

    /// At most one way to say how the bodies of a lattice are oriented.
    fn check_lattice_axis(&self, key: &Key, lattice: &Lattice) -> Result<(), SceneError> {
        let given = [("axis", lattice.axis.is_some()), ("angle", lattice.angle.is_some()), ("random", lattice.random)];
        let mut given = given.into_iter().filter(|(_, given)| *given);
        if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
            let message = format!("conflicts with `{first}`, which sets the orientation too; omit one of them");
            return Err(SceneError::bad(key.field(second), message));
        }
        lattice.axis.map_or(Ok(()), |axis| direction(&key.field("axis"), &axis))?;
        let Some(angle) = lattice.angle else { return Ok(()) };
        number(&key.field("angle"), angle)?;
        if self.planar {
            return Ok(());
        }
        Err(SceneError::bad(key.field("angle"), "is an angle in the plane; in space, give `axis`"))
    }

    pub(super) fn check_fence(&self, key: &Key, fence: &Fence) -> Result<(), SceneError> {
        positive(&key.field("diameter"), fence.diameter)?;
        let list = key.field("points");
        check_line(&list, &fence.points, 1)?;
        if fence.closed && fence.points.len() < 3 {
            let message = "needs at least three points: with fewer, the last rod would lie on the first";
            return Err(SceneError::bad(key.field("closed"), message));
        }
        if fence.closed && fence.points.first() == fence.points.last() {
            let message = "is the first point already, to which `closed` leads; omit it";
            return Err(SceneError::bad(list.index(fence.points.len() - 1), message));
        }
        fence.components().iter().try_for_each(|(_, rod)| check_shape(key, rod))
    }

    pub(super) fn check_chain(&self, key: &Key, chain: &Chain) -> Result<(), SceneError> {
        at_least(key, "count", chain.count, 2)?;
        let shape = key.field("shape");
        check_shape(&shape.field(chain.shape.name()), &chain.shape)?;
        if reach_of_link(&chain.shape).is_none() {
            let message = "has no ends to be bonded at; chains are of spheres, spherocylinders or ellipsoids";
            return Err(SceneError::bad(shape.field(chain.shape.name()), message));
        }
        if !chain.stiffness.is_infinite() {
            positive(&key.field("stiffness"), chain.stiffness)?;
        }
        if let Some(bending) = chain.bending.filter(|bending| !bending.is_infinite()) {
            positive(&key.field("bending"), bending)?;
        }
        if let Some(gap) = chain.gap {
            number(&key.field("gap"), gap)?;
            if gap < 0.0 {
                return Err(SceneError::bad(key.field("gap"), format!("must not be negative, not {}", exact(gap))));
            }
        }
        chain.break_force.map_or(Ok(()), |force| positive(&key.field("break_force"), force))?;
        let path = key.field("path");
        chain.path.as_ref().map_or(Ok(()), |of| check_path(key, &path.field(of.name()), chain, of))
    }
}

fn check_path(key: &Key, path_key: &Key, chain: &Chain, path: &ChainPath) -> Result<(), SceneError> {
    match path {
        ChainPath::Straight { center, axis } => {
            numbers(&path_key.field("center"), center)?;
            direction(&path_key.field("axis"), axis)
        }
        ChainPath::Ring { center } => {
            at_least(key, "count", chain.count, LEAST_RING)?;
            numbers(&path_key.field("center"), center)
        }
        ChainPath::Along { points } => check_line(&path_key.field("points"), points, 2),
        ChainPath::RandomWalk { start, largest_bend } => {
            numbers(&path_key.field("start"), start)?;
            let Some(bend) = *largest_bend else { return Ok(()) };
            let key = path_key.field("largest_bend");
            positive(&key, bend)?;
            if bend > 180.0 {
                return Err(SceneError::bad(key, format!("must be at most 180 degrees, not {}", short(bend))));
            }
            Ok(())
        }
    }
}

/// Points of a line, each apart from the one before.
fn check_line(list: &Key, points: &[[f64; 3]], least: usize) -> Result<(), SceneError> {
    if points.len() < least {
        let what = if least == 1 { "a point" } else { "two points" };
        return Err(SceneError::bad(list, format!("must have {what} at least")));
    }
    for (i, point) in points.iter().enumerate() {
        let key = list.index(i);
        numbers(&key, point)?;
        if i > 0 && points[i - 1] == *point {
            return Err(SceneError::bad(key, "is the point before it again"));
        }
    }
    Ok(())
}

fn check_counts(list: &Key, kind: LatticeKind, counts: [u64; 3]) -> Result<(), SceneError> {
    for (axis, count) in counts.into_iter().enumerate() {
        if count == 0 {
            return Err(SceneError::bad(list.index(axis), "must be at least 1"));
        }
    }
    if kind.is_sheet() && counts[2] != 1 {
        let message = format!("must be 1, not {}: a square or hexagonal lattice is a sheet", counts[2]);
        return Err(SceneError::bad(list.index(2), message));
    }
    Ok(())
}

/// The rules of these in a planar scene: all in the plane z = 0.
pub(super) fn check_planar_lattice(key: &Key, lattice: &Lattice) -> Result<(), SceneError> {
    if !lattice.kind.is_sheet() {
        let message = "leaves the plane; in a planar scene a lattice is \"square\" or \"hexagonal\"";
        return Err(SceneError::bad(key.field("kind"), message));
    }
    flat(&key.field("center"), &lattice.center.unwrap_or_default())?;
    let orientation = super::super::generate::orientation_of_lattice(lattice);
    if lattice.random && lattice.shape.is_general() {
        let name = lattice.shape.name();
        let message = format!("a {name} need not be mirrored by the plane as it is drawn; give its `angle`");
        return Err(SceneError::bad(key.field("random"), message));
    }
    if !lattice.random && !lattice.shape.is_planar_symmetric(orientation) {
        let name = if lattice.axis.is_some() { "axis" } else { "shape" };
        let message = "the bodies must be mirrored by the plane: their axis in it or across it, or one of their principal axes across it";
        return Err(SceneError::bad(key.field(name), message));
    }
    Ok(())
}

pub(super) fn check_planar_fence(key: &Key, fence: &Fence) -> Result<(), SceneError> {
    let list = key.field("points");
    fence.points.iter().enumerate().try_for_each(|(i, point)| flat(&list.index(i), point))
}

pub(super) fn check_planar_chain(key: &Key, chain: &Chain) -> Result<(), SceneError> {
    let Some(path) = &chain.path else { return Ok(()) };
    let path_key = key.field("path");
    let key = path_key.field(path.name());
    match path {
        ChainPath::Straight { center, axis } => {
            flat(&key.field("center"), center)?;
            flat(&key.field("axis"), axis)
        }
        ChainPath::Ring { center } => flat(&key.field("center"), center),
        ChainPath::Along { points } => {
            let list = key.field("points");
            points.iter().enumerate().try_for_each(|(i, point)| flat(&list.index(i), point))
        }
        ChainPath::RandomWalk { start, .. } => flat(&key.field("start"), start),
    }
}

/// A point or a direction of the plane z = 0.
pub(super) fn flat(key: &Key, vector: &[f64; 3]) -> Result<(), SceneError> {
    if DVec3::from(*vector).z == 0.0 {
        return Ok(());
    }
    let message = format!("must be 0 in a planar scene, whose rules place bodies at z = 0, not {}", exact(vector[2]));
    Err(SceneError::bad(key.index(2), message))
}
