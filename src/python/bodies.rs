//! Arrays of all bodies, for simulations, their forces and recorded states.

use super::arrays::{NO_GROUP, NO_PARENT, column, named, table, vectors};
use crate::bodies::Bodies;
use crate::dynamics::pressures;
use crate::simulation::CellState;
use crate::warm::Warm;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

pub(super) type Column<'py, T> = PyResult<Bound<'py, PyArray1<T>>>;
pub(super) type Table<'py, T> = PyResult<Bound<'py, PyArray2<T>>>;

pub(super) fn orientations(bodies: &Bodies) -> Vec<[f64; 4]> {
    bodies.orientation.iter().map(|q| [q.w, q.x, q.y, q.z]).collect()
}

pub(super) fn lengths(bodies: &Bodies) -> Vec<f64> {
    bodies.shape.iter().map(|shape| shape.major_axis()).collect()
}

pub(super) fn shapes(bodies: &Bodies) -> Vec<u32> {
    bodies.shape.iter().map(|shape| shape.code().0).collect()
}

pub(super) fn sizes(bodies: &Bodies) -> Vec<[f64; 3]> {
    bodies.shape.iter().map(|shape| shape.code().1).collect()
}

/// The exponents of superellipsoids, zero of other shapes.
pub(super) fn exponents(bodies: &Bodies) -> Vec<[f64; 2]> {
    bodies.shape.iter().map(|shape| shape.exponents().unwrap_or_default()).collect()
}

pub(super) fn axes(bodies: &Bodies) -> Vec<[f64; 3]> {
    bodies.orientation.iter().map(|q| (*q * glam::DVec3::Z).to_array()).collect()
}

pub(super) fn shape_labels(bodies: &Bodies) -> Vec<&'static str> {
    bodies.shape.iter().map(|shape| shape.name()).collect()
}

/// A group as Python has it.
pub(super) fn group(of: u32) -> i32 {
    i32::try_from(of).unwrap_or(NO_GROUP)
}

pub(super) fn groups(bodies: &Bodies) -> Vec<i32> {
    bodies.group.iter().map(|own| group(*own)).collect()
}

pub(super) fn group_labels(bodies: &Bodies, names: &[String]) -> Vec<Option<String>> {
    bodies.group.iter().map(|group| names.get(*group as usize).cloned()).collect()
}

/// An id as Python has it: ids count bodies, so they are far below the largest number.
pub(super) fn id(of: u64) -> i64 {
    i64::try_from(of).unwrap_or(i64::MAX)
}

pub(super) fn ids(bodies: &Bodies) -> Vec<i64> {
    bodies.lineage.iter().map(|line| id(line.id)).collect()
}

pub(super) fn parents(bodies: &Bodies) -> Vec<i64> {
    bodies.lineage.iter().map(|line| line.parent.map_or(NO_PARENT, id)).collect()
}

pub(super) fn births(bodies: &Bodies) -> Vec<f64> {
    bodies.lineage.iter().map(|line| line.birth).collect()
}

pub(super) fn generations(bodies: &Bodies) -> Vec<u32> {
    bodies.lineage.iter().map(|line| line.generation).collect()
}

/// All bodies at the time at which a force or a rule is evaluated: the arrays of a `Simulation`, one row per body, each
/// made when it is read. Every array is a read-only copy.
#[pyclass(frozen, subclass, name = "Bodies", module = "relcp")]
pub(super) struct PyBodies {
    pub(super) bodies: Bodies,
    pub(super) time: f64,
    /// The contact forces of the last step, for rules; empty where they are not known.
    pub(super) warm: Vec<Warm>,
    /// The names of the scene's groups.
    group_names: Arc<[String]>,
}

impl PyBodies {
    /// Bodies at a time, with the contact forces of the last step.
    pub fn new(bodies: Bodies, time: f64, warm: Vec<Warm>, group_names: Arc<[String]>) -> Self {
        PyBodies { bodies, time, warm, group_names }
    }

    /// A copy of the bodies that rules see.
    pub fn of_cells(state: &CellState<'_>, group_names: Arc<[String]>) -> Self {
        PyBodies::new(state.bodies.clone(), state.time, state.warm().to_vec(), group_names)
    }
}

#[pymethods]
impl PyBodies {
    fn __len__(&self) -> usize {
        self.bodies.len()
    }

    /// The time: that at the start of a step, or with midpoint stepping also that in its middle.
    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    /// (N, 3): centres.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, vectors(&self.bodies.position))
    }

    /// (N, 4): unit quaternions [w, x, y, z], body axes to space.
    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, orientations(&self.bodies))
    }

    /// (N, 3): the direction of each body's own z in space, the axis of a rod and of a ring.
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, axes(&self.bodies))
    }

    /// (N, 3): velocities, length / time; under the overdamped law those of the last step.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, vectors(&self.bodies.velocity))
    }

    /// (N, 3): angular velocities in space axes, 1 / time; as `velocities`.
    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, vectors(&self.bodies.angular_velocity))
    }

    /// (N,): length of the major axis, tip to tip for a rod.
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, lengths(&self.bodies)))
    }

    /// (N,) uint32: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, shapes(&self.bodies)))
    }

    /// (N, 3): sizes in a scene's order.
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, sizes(&self.bodies))
    }

    /// (N, 2): exponents `[n1, n2]` of superellipsoids, zero of other shapes.
    #[getter]
    fn exponents<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, exponents(&self.bodies))
    }

    /// The name of each body's shape, a list.
    #[getter]
    fn shape_labels(&self) -> Vec<&'static str> {
        shape_labels(&self.bodies)
    }

    /// (N,) int32: index into the scene's `group_names`; `relcp.NO_GROUP`, -1, for a body without a group.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> Column<'py, i32> {
        Ok(column(py, groups(&self.bodies)))
    }

    /// The name of each body's group, a list; None for a body without one.
    #[getter]
    fn group_labels(&self) -> Vec<Option<String>> {
        group_labels(&self.bodies, &self.group_names)
    }

    /// The columns of your own, (N,) each, by name.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        named(py, self.bodies.columns.named().map(|(name, values)| (name, values.to_vec())))
    }

    /// (N,) int64: identities, unique over a run.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Column<'py, i64> {
        Ok(column(py, ids(&self.bodies)))
    }

    /// (N,) int64: the id that divided into this one; `relcp.NO_PARENT`, -1, for a founder.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Column<'py, i64> {
        Ok(column(py, parents(&self.bodies)))
    }

    /// (N,): times of birth.
    #[getter]
    fn births<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, births(&self.bodies)))
    }

    /// (N,) uint32: divisions since the founder.
    #[getter]
    fn generations<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, generations(&self.bodies)))
    }

    /// (N,): pressures by the contact forces of the last step, where rules see them.
    fn _pressures<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, pressures(&self.bodies, &self.warm, self.bodies.planar)))
    }
}
