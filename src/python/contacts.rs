//! The contacts of a state, as arrays with one row per contact.

use super::arrays::{column, table};
use crate::bodies::Bodies;
use crate::scene::{Method, Scene};
use crate::step::contacts;
use crate::walls::{Walls, surface_of};
use crate::warm::Warm;
use glam::DVec3;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::collections::HashMap;

/// The data of [`Contacts`].
#[derive(Default)]
pub(super) struct Pairs {
    pairs: Vec<[u64; 2]>,
    separation: Vec<f64>,
    normal: Vec<[f64; 3]>,
    point_a: Vec<[f64; 3]>,
    point_b: Vec<[f64; 3]>,
    gamma: Vec<f64>,
    force: Vec<[f64; 3]>,
}

impl Pairs {
    /// The pairs whose separation is at most `cutoff`, from the bodies alone, with the forces of the last step; NaN if
    /// these are not known.
    pub fn of(bodies: &Bodies, warm: Option<&[Warm]>, cutoff: f64) -> Self {
        let mut forces = HashMap::<[usize; 2], (f64, DVec3)>::new();
        let near_bodies = warm.iter().copied().flatten().filter(|warm| surface_of(warm.pair[1]).is_none());
        for Warm { pair, gamma, tangent, .. } in near_bodies {
            // A method with several rows per pair has a force for each.
            let force = forces.entry(pair.map(|body| body as usize)).or_default();
            *force = (force.0 + gamma, force.1 + tangent);
        }
        let none = if warm.is_some() { (0.0, DVec3::ZERO) } else { (f64::NAN, DVec3::NAN) };
        let mut found = Pairs::default();
        for near in contacts(bodies, cutoff) {
            let [a, b] = near.bodies.map(|body| bodies.position[body]);
            found.pairs.push(near.bodies.map(|body| body as u64));
            found.separation.push(near.separation);
            found.normal.push(near.normal.to_array());
            found.point_a.push((a + near.levers[0]).to_array());
            found.point_b.push((b + near.levers[1]).to_array());
            let (gamma, tangent) = forces.get(&near.bodies).copied().unwrap_or(none);
            found.gamma.push(gamma);
            found.force.push((gamma * near.normal + tangent).to_array());
        }
        found
    }
}

/// Pairs of near bodies, one row each, sorted by pair. M is their number.
#[pyclass(frozen, get_all, module = "relcp")]
pub(super) struct Contacts {
    /// (M, 2) uint64: the rows of both bodies, the lower first.
    pairs: Py<PyArray2<u64>>,
    /// (M,): the signed distance of the surfaces, a length; negative if they overlap.
    separation: Py<PyArray1<f64>>,
    /// (M, 3): unit normal from the first body to the second.
    normal: Py<PyArray2<f64>>,
    /// (M, 3): the contact point on the first body's surface, in space.
    point_a: Py<PyArray2<f64>>,
    /// (M, 3): the contact point on the second body's surface, in space.
    point_b: Py<PyArray2<f64>>,
    /// (M,): the contact force of the last step, summed over the rows of the pair; zero without contact.
    gamma: Py<PyArray1<f64>>,
    /// (M, 3): the force of the first body on the second: `gamma` along the normal, and friction.
    force: Py<PyArray2<f64>>,
}

impl Contacts {
    pub(super) fn new(py: Python<'_>, found: Pairs) -> PyResult<Self> {
        Ok(Contacts {
            pairs: table(py, found.pairs)?.unbind(),
            separation: column(py, found.separation).unbind(),
            normal: table(py, found.normal)?.unbind(),
            point_a: table(py, found.point_a)?.unbind(),
            point_b: table(py, found.point_b)?.unbind(),
            gamma: column(py, found.gamma).unbind(),
            force: table(py, found.force)?.unbind(),
        })
    }
}

#[pymethods]
impl Contacts {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.pairs.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Contacts({} pairs)", self.__len__(py)?))
    }
}

/// The data of [`WallContacts`].
#[derive(Default)]
pub(super) struct AtWalls {
    body: Vec<u64>,
    wall: Vec<u64>,
    face: Vec<u64>,
    separation: Vec<f64>,
    normal: Vec<[f64; 3]>,
    point: Vec<[f64; 3]>,
    gamma: Vec<f64>,
    force: Vec<[f64; 3]>,
}

/// What bears on a surface of a wall.
#[derive(Clone, Copy, Default)]
struct Bearing {
    gamma: f64,
    force: DVec3,
    tangent: DVec3,
}

impl AtWalls {
    /// The bodies and surfaces of walls whose separation is at most `cutoff`, with the forces of the last step; NaN if
    /// these are not known. Those of `smooth` bodies have the normals of all places where a body touches, those of
    /// sub-spheres the one of the nearest.
    pub fn of(walls: &Walls, bodies: &Bodies, warm: Option<&[Warm]>, smooth: bool, cutoff: f64) -> Self {
        let mut bearing = HashMap::<[usize; 2], Bearing>::new();
        for warm in warm.unwrap_or_default() {
            let Some(surface) = surface_of(warm.pair[1]) else { continue };
            let of = bearing.entry([warm.pair[0] as usize, surface]).or_default();
            (of.gamma, of.tangent) = (of.gamma + warm.gamma, of.tangent + warm.tangent);
        }
        for push in walls.pushes(bodies, warm.unwrap_or_default()) {
            bearing.entry([push.body, push.surface]).or_default().force += push.force;
        }
        let unknown = Bearing { gamma: f64::NAN, force: DVec3::NAN, tangent: DVec3::NAN };
        let none = if warm.is_some() { Bearing::default() } else { unknown };
        let mut found = AtWalls::default();
        for near in walls.contacts(bodies, cutoff) {
            let of = bearing.get(&[near.body, near.surface]).copied().unwrap_or(none);
            found.body.push(near.body as u64);
            found.wall.push(near.wall as u64);
            found.face.push(walls.face_of(near.surface) as u64);
            found.separation.push(near.separation);
            found.normal.push(near.normal.to_array());
            found.point.push(near.point(bodies).to_array());
            found.gamma.push(of.gamma);
            let force = if smooth { of.force } else { of.gamma * near.normal + of.tangent };
            found.force.push(force.to_array());
        }
        found
    }
}

/// Bodies near a wall's surface, one row each, sorted by body. M is their number.
#[pyclass(frozen, get_all, module = "relcp")]
pub(super) struct WallContacts {
    /// (M,) uint64: the body's row.
    body: Py<PyArray1<u64>>,
    /// (M,) uint64: the index of the wall in the scene.
    wall: Py<PyArray1<u64>>,
    /// (M,) uint64: which of the wall's surfaces: of a channel the side that its normal points away from, then the
    /// other; of a box the low and the high side along x, y and z; of a cylinder the tube, then the ends.
    face: Py<PyArray1<u64>>,
    /// (M,): the body's signed distance from the surface, a length.
    separation: Py<PyArray1<f64>>,
    /// (M, 3): unit normal towards the wall.
    normal: Py<PyArray2<f64>>,
    /// (M, 3): the contact point on the body's surface, in space.
    point: Py<PyArray2<f64>>,
    /// (M,): the normal force of the last step, summed over the places where the body touches; zero without contact.
    gamma: Py<PyArray1<f64>>,
    /// (M, 3): the force of the body on the wall: along the normal, and friction.
    force: Py<PyArray2<f64>>,
}

impl WallContacts {
    pub(super) fn new(py: Python<'_>, found: AtWalls) -> PyResult<Self> {
        Ok(WallContacts {
            body: column(py, found.body).unbind(),
            wall: column(py, found.wall).unbind(),
            face: column(py, found.face).unbind(),
            separation: column(py, found.separation).unbind(),
            normal: table(py, found.normal)?.unbind(),
            point: table(py, found.point)?.unbind(),
            gamma: column(py, found.gamma).unbind(),
            force: table(py, found.force)?.unbind(),
        })
    }
}

#[pymethods]
impl WallContacts {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.body.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("WallContacts({})", self.__len__(py)?))
    }
}

/// Whether the contact forces of a scene's runs are those of smooth bodies.
pub(super) fn is_smooth(scene: &Scene) -> bool {
    !matches!(scene.contact.method, Method::Multisphere { .. })
}
