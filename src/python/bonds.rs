//! The bonds and joints of a state that hold, as arrays with one row each.

use super::arrays::{column, table};
use crate::bodies::Bodies;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// The data of [`Bonds`].
pub(super) struct Held {
    number: Vec<u32>,
    bodies: Vec<[u64; 2]>,
    point_a: Vec<[f64; 3]>,
    point_b: Vec<[f64; 3]>,
    length: Vec<f64>,
    rest_length: Vec<f64>,
    tension: Vec<f64>,
    force: Vec<[f64; 3]>,
    torque: Vec<[f64; 3]>,
    bending_energy: Vec<f64>,
    contact: Vec<bool>,
}

impl Held {
    /// The bonds of `bodies`. Second ends are those at the image that is nearest to the first body.
    pub fn of(bodies: &Bodies) -> Self {
        let bonds = &bodies.bonds;
        let ways: Vec<_> = bonds.iter().map(|bond| bond.way(bodies)).collect();
        Held {
            number: bonds.iter().map(|bond| bond.number).collect(),
            bodies: bonds.iter().map(|bond| bond.bodies.map(u64::from)).collect(),
            point_a: ways.iter().map(|(_, from)| from.to_array()).collect(),
            point_b: ways.iter().map(|(way, from)| (*from + *way).to_array()).collect(),
            length: ways.iter().map(|(way, _)| way.length()).collect(),
            rest_length: bonds.iter().map(|bond| bond.length).collect(),
            tension: bonds.iter().map(|bond| bond.tension(bodies)).collect(),
            force: bonds.iter().map(|bond| bond.force.to_array()).collect(),
            torque: bonds.iter().map(|bond| bond.torque.to_array()).collect(),
            bending_energy: bonds.iter().map(|bond| bond.bending_energy).collect(),
            contact: bonds.iter().map(|bond| bond.contact).collect(),
        }
    }
}

/// Bonds and joints that hold, one row each, sorted by number. M is their number. Broken ones are not among them.
#[pyclass(frozen, get_all, module = "relcp")]
pub(super) struct Bonds {
    /// (M,) uint32: the number of each: the scene's `bonds` first, then those of chains, `joints`, and bonds of
    /// daughters.
    number: Py<PyArray1<u32>>,
    /// (M, 2) uint64: the rows of both bodies.
    bodies: Py<PyArray2<u64>>,
    /// (M, 3): the end on the first body, in space.
    point_a: Py<PyArray2<f64>>,
    /// (M, 3): the end on the second body, in space; in a periodic cell at the image nearest to the first body.
    point_b: Py<PyArray2<f64>>,
    /// (M,): the distance of the ends.
    length: Py<PyArray1<f64>>,
    /// (M,): the length at rest.
    rest_length: Py<PyArray1<f64>>,
    /// (M,): the force along the bond, positive where it pulls its ends together; of one of length 0 all of its force.
    tension: Py<PyArray1<f64>>,
    /// (M, 3): the force on the second body at its end, that of the last step; NaN where it is not known.
    force: Py<PyArray2<f64>>,
    /// (M, 3): the torque on the second body about its end, as `force`.
    torque: Py<PyArray2<f64>>,
    /// (M,): the energy of bends and turns that it resists.
    bending_energy: Py<PyArray1<f64>>,
    /// (M,) bool: whether its bodies collide.
    contact: Py<PyArray1<bool>>,
}

impl Bonds {
    pub(super) fn new(py: Python<'_>, held: Held) -> PyResult<Self> {
        Ok(Bonds {
            number: column(py, held.number).unbind(),
            bodies: table(py, held.bodies)?.unbind(),
            point_a: table(py, held.point_a)?.unbind(),
            point_b: table(py, held.point_b)?.unbind(),
            length: column(py, held.length).unbind(),
            rest_length: column(py, held.rest_length).unbind(),
            tension: column(py, held.tension).unbind(),
            force: table(py, held.force)?.unbind(),
            torque: table(py, held.torque)?.unbind(),
            bending_energy: column(py, held.bending_energy).unbind(),
            contact: column(py, held.contact).unbind(),
        })
    }
}

#[pymethods]
impl Bonds {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.number.bind(py).len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Bonds({})", self.__len__(py)?))
    }
}
