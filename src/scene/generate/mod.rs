//! Bodies placed by rule.

mod chain;
mod chainmail;
mod copied;
mod fence;
mod founder;
mod isotropic;
mod lattice;
mod lengths;
mod occupied;
mod patterns;
mod room;
mod settings;
mod walk;

pub(super) use chain::{bonds as bonds_of_chain, reach as reach_of_link};
pub(super) use chainmail::MAX_RING_RATIO;
pub(super) use copied::{copies, farthest as farthest_copy};
pub(super) use isotropic::{reachable_by_all, volume_of_all as isotropic_volume};
pub(super) use lattice::orientation as orientation_of_lattice;
pub use lengths::Lengths;
pub(super) use lengths::spread;
pub use patterns::{Chain, ChainPath, Fence, Lattice, LatticeKind, Repeat};
pub use settings::{Component, Generate};

use super::error::{FaultKind, SceneError};
use super::orientation::ALONG_X;
use super::{Scene, Wall};
use crate::bodies::Bodies;
use crate::digits::{few, short};
use crate::shape::Shape;
use crate::step::max_overlap;
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
    check_apart(scene, index, bodies, first)?;
    if scene.generate[index].is_fixed() {
        return Ok(());
    }
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
    let (what, end) = match rule {
        Generate::Chainmail { .. } => ("sheet", bodies.len()),
        // The first row: copies of it may go on through a period.
        Generate::Founder { count, .. } => ("row", first + *count as usize),
        _ => return Ok(()),
    };
    if bodies.periods.is_none() {
        return Ok(());
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for i in first..end {
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

/// Refuses a lattice or a chain whose bodies overlap each other, or their own images.
fn check_apart(scene: &Scene, index: usize, bodies: &Bodies, first: usize) -> Result<(), SceneError> {
    let (key, remedy) = match &scene.generate[index] {
        Generate::Lattice(_) => ("lattice.spacing", "choose a wider spacing"),
        Generate::Chain(_) => ("chain.gap", "choose a wider gap, a smoother path, or copies farther apart"),
        _ => return Ok(()),
    };
    let mut own = Bodies { periods: bodies.periods, planar: bodies.planar, ..Bodies::default() };
    for i in first..bodies.len() {
        own.push(bodies.placed(i), bodies.group[i]);
    }
    let overlap = max_overlap(&own, &Walls::default());
    if overlap <= scene.contact.overlap_tolerance {
        return Ok(());
    }
    let message = format!("the bodies overlap each other by up to {}; {remedy}", few(overlap));
    Err(SceneError::new(FaultKind::Placement, format!("generate.{index}.{key}"), message))
}

/// The walls of the scene and, after them, the region of its rule `index`.
fn surroundings(scene: &Scene, region: Option<&Wall>) -> Walls {
    let all: Vec<Wall> = scene.walls.iter().chain(region).copied().collect();
    Walls::new(&all, scene.planar).at(scene.time.start)
}

/// Whether an `isotropic` rule places its bodies inside a region or the walls: it has no volume fraction, and the scene
/// no whole cell to fill.
pub(super) fn is_inside(scene: &Scene, rule: &Generate) -> bool {
    let Generate::Isotropic { volume_fraction, region, .. } = rule else { return false };
    region.is_some() || volume_fraction.is_none() && scene.periods().volume(scene.planar).is_none()
}

/// The box about the region and the walls in which a rule draws its centres; none where they leave nothing, or a way
/// out.
fn box_inside(scene: &Scene, region: Option<&Wall>) -> Option<[DVec3; 2]> {
    surroundings(scene, region).extent(&scene.periods(), scene.planar.then_some(0.0))
}

/// Whether walls, periods and this region leave no way out.
pub(super) fn is_enclosed(scene: &Scene, region: Option<&Wall>) -> bool {
    surroundings(scene, region).are_closed(&scene.periods(), scene.planar)
}

/// The bodies that the scene's rule `index` places at random; none for other rules, and where there is no space.
fn order(scene: &Scene, index: usize) -> Option<isotropic::Order> {
    let rule = &scene.generate[index];
    let Generate::Isotropic { volume_fraction, region, center, .. } = rule else { return None };
    let components = rule.components().map(|(count, shape, _)| (count, shape)).collect();
    let (volume_fraction, mut center, mut inside) = (*volume_fraction, DVec3::from(*center), None);
    if is_inside(scene, rule) {
        let [low, high] = box_inside(scene, region.as_ref())?;
        center = 0.5 * (low + high);
        inside = Some(isotropic::Inside { sides: high - low, is_own: region.is_some() });
    }
    let (planar, seed) = (scene.planar, scene.seed);
    Some(isotropic::Order { components, volume_fraction, center, inside, planar, seed, rule: index })
}

/// The largest side, along open axes, of the box in which rule `index` draws its centres by a volume fraction; none if
/// the rule draws none so, or every axis is periodic.
pub(super) fn open_side(scene: &Scene, index: usize) -> Option<f64> {
    if is_inside(scene, &scene.generate[index]) {
        return None;
    }
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
        Generate::Isotropic { region, .. } => {
            let Some(order) = order(scene, index) else { return Err(no_space(index, region.is_some())) };
            isotropic::add(&order, &surroundings(scene, region.as_ref()), bodies, groups, goes_on)?;
        }
        Generate::Chainmail { columns, rows, major_radius, minor_radius, .. } => {
            chainmail::add(*columns, *rows, *major_radius, *minor_radius, bodies, group);
        }
        Generate::Founder { diameter, length, position, angle, count, repeat, .. } => {
            for offset in copied::offsets(repeat) {
                let position = if repeat.is_empty() { DVec3::from(*position) } else { DVec3::from(*position) + offset };
                founder::add([*diameter, *length], position, *angle, *count, bodies, group);
            }
        }
        Generate::Lattice(lattice) => {
            lattice::add(lattice, scene.planar, &mut isotropic::stream(scene.seed, index), bodies, group);
        }
        Generate::Fence(fence) => fence::add(fence, bodies, groups),
        Generate::Chain(chain) => {
            chain::add(chain, &chain::Place { scene, walls, rule: index, group }, bodies, goes_on)?
        }
    }
    Ok(())
}

fn no_space(index: usize, has_region: bool) -> SceneError {
    let (name, what) = if has_region { ("region", "it and the walls") } else { ("count", "the walls") };
    let key = format!("generate.{index}.isotropic.{name}");
    SceneError::new(FaultKind::Placement, key, format!("{what} have no inside in common"))
}

/// An orientation that all bodies of one shape of a rule have in a planar scene, up to a turn about z; none if their
/// orientations differ otherwise.
pub(super) fn planar_orientation(rule: &Generate, shape: &Shape) -> Option<DQuat> {
    match (rule, shape) {
        (Generate::Founder { angle, .. }, _) => Some(founder::orientation(*angle)),
        (Generate::Lattice(lattice), Shape::Sphere { .. }) if lattice.random => None,
        (Generate::Lattice(lattice), _) => Some(lattice::orientation(lattice)),
        (Generate::Isotropic { .. }, Shape::Sphere { .. }) | (Generate::Chainmail { .. }, _) => None,
        (Generate::Isotropic { .. } | Generate::Fence(_) | Generate::Chain(_), _) => Some(ALONG_X),
    }
}
