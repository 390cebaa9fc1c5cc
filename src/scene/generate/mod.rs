//! Bodies placed by rule.

mod chainmail;
mod founder;
mod isotropic;
mod occupied;
mod room;

pub(super) use chainmail::MAX_RING_RATIO;
pub(super) use isotropic::{reachable_by_all, volume_of_all as isotropic_volume};

use super::error::{FaultKind, SceneError};
use super::orientation::ALONG_X;
use super::{Generate, Scene};
use crate::bodies::Bodies;
use crate::digits::short;
use crate::shape::Shape;
use crate::walls::Walls;
use glam::{DQuat, DVec3};

/// Called regularly with the number of bodies placed so far; placement stops if it returns false.
type GoesOn<'a> = &'a mut dyn FnMut(usize) -> bool;

/// Adds the bodies of the scene's rule `index`, inside the walls; `groups` has the group indices of its components.
pub(super) fn add(
    scene: &Scene,
    index: usize,
    bodies: &mut Bodies,
    groups: &[u32],
    goes_on: GoesOn,
) -> Result<(), SceneError> {
    let (first, walls) = (bodies.len(), scene.walls());
    place(scene, index, &walls, bodies, groups, goes_on)?;
    check_sheet(scene, index, bodies, first)?;
    for i in first..bodies.len() {
        if let Some((depth, wall)) =
            walls.deepest(&bodies.placed(i)).filter(|(d, _)| *d > scene.contact.overlap_tolerance)
        {
            let key = format!("generate.{index}.{}", scene.generate[index].name());
            return Err(SceneError::new(FaultKind::Placement, key, scene.outside(depth, wall)));
        }
    }
    Ok(())
}

/// Refuses a sheet of rings, or a row of cells, that is longer than a period: it would overlap itself.
fn check_sheet(scene: &Scene, index: usize, bodies: &Bodies, first: usize) -> Result<(), SceneError> {
    let rule = &scene.generate[index];
    let what = match rule {
        Generate::Chainmail { .. } => "sheet",
        Generate::Founder { .. } => "row",
        Generate::Isotropic { .. } => return Ok(()),
    };
    if bodies.periods.is_none() {
        return Ok(());
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in first..bodies.len() {
        let half = bodies.shape[i].half_extents(bodies.orientation[i]);
        (low, high) = (low.min(bodies.position[i] - half), high.max(bodies.position[i] + half));
    }
    for (axis, length) in bodies.periods.lengths().into_iter().enumerate() {
        if let Some(length) = length.filter(|length| high[axis] - low[axis] > *length) {
            let message = format!(
                "the {what} is {} long along a periodic axis, over the period, {}",
                short(high[axis] - low[axis]),
                short(length)
            );
            return Err(SceneError::new(FaultKind::Placement, format!("generate.{index}.{}", rule.name()), message));
        }
    }
    Ok(())
}

/// The bodies that the scene's rule `index` places at random; none for other rules.
fn order(scene: &Scene, index: usize) -> Option<isotropic::Order> {
    let rule = &scene.generate[index];
    let Generate::Isotropic { volume_fraction, center, .. } = rule else { return None };
    let components = rule.components().map(|(count, shape, _)| (count, shape)).collect();
    let (volume_fraction, center) = (*volume_fraction, DVec3::from(*center));
    Some(isotropic::Order { components, volume_fraction, center, planar: scene.planar, seed: scene.seed, rule: index })
}

/// The largest side, along open axes, of the box in which rule `index` draws its centres; none if the rule draws none,
/// or every axis is periodic.
pub(super) fn open_side(scene: &Scene, index: usize) -> Option<f64> {
    let (order, periods) = (order(scene, index)?, scene.periods());
    let sides = isotropic::sides(&order, periods).to_array();
    let open = (0..if scene.planar { 2 } else { 3 }).find(|axis| periods.lengths()[*axis].is_none())?;
    Some(sides[open])
}

fn place(
    scene: &Scene,
    index: usize,
    walls: &Walls,
    bodies: &mut Bodies,
    groups: &[u32],
    goes_on: GoesOn,
) -> Result<(), SceneError> {
    let group = groups[0];
    match &scene.generate[index] {
        Generate::Isotropic { .. } => {
            order(scene, index).map_or(Ok(()), |order| isotropic::add(&order, walls, bodies, groups, goes_on))
        }
        Generate::Chainmail { columns, rows, major_radius, minor_radius, .. } => {
            chainmail::add(*columns, *rows, *major_radius, *minor_radius, bodies, group);
            Ok(())
        }
        Generate::Founder { diameter, length, position, angle, count, .. } => {
            founder::add([*diameter, *length], DVec3::from(*position), *angle, *count, bodies, group);
            Ok(())
        }
    }
}

/// An orientation that all bodies of one shape of a rule have in a planar scene, up to a turn about z; none if their
/// orientations differ otherwise.
pub(super) fn planar_orientation(rule: &Generate, shape: &Shape) -> Option<DQuat> {
    match (rule, shape) {
        (Generate::Founder { angle, .. }, _) => Some(founder::orientation(*angle)),
        (Generate::Isotropic { .. }, Shape::Sphere { .. }) | (Generate::Chainmail { .. }, _) => None,
        (Generate::Isotropic { .. }, _) => Some(ALONG_X),
    }
}
