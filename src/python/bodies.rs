//! Arrays of all bodies, for simulations and their forces.

use super::arrays::{NO_PARENT, column, table, vectors};
use crate::bodies::Bodies;
use crate::dynamics::pressures;
use crate::simulation::CellState;
use crate::warm::Warm;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

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

pub(super) fn ids(bodies: &Bodies) -> Vec<u64> {
    bodies.lineage.iter().map(|line| line.id).collect()
}

pub(super) fn parents(bodies: &Bodies) -> Vec<u64> {
    bodies.lineage.iter().map(|line| line.parent.unwrap_or(NO_PARENT)).collect()
}

pub(super) fn births(bodies: &Bodies) -> Vec<f64> {
    bodies.lineage.iter().map(|line| line.birth).collect()
}

pub(super) fn generations(bodies: &Bodies) -> Vec<u32> {
    bodies.lineage.iter().map(|line| line.generation).collect()
}

/// All bodies at the time at which a force or a rule is evaluated: the arrays of a `Simulation`, one row per body, each
/// made when it is read. Every array is a read-only copy.
#[pyclass(frozen, name = "Bodies", module = "relcp")]
pub(super) struct PyBodies {
    bodies: Bodies,
    time: f64,
    /// The contact forces of the last step, for rules.
    warm: Vec<Warm>,
}

impl PyBodies {
    /// A copy of the bodies at a time.
    pub fn new(bodies: &Bodies, time: f64) -> Self {
        PyBodies { bodies: bodies.clone(), time, warm: Vec::new() }
    }

    /// A copy of the bodies that rules see.
    pub fn of_cells(state: &CellState<'_>) -> Self {
        PyBodies { warm: state.warm().to_vec(), ..PyBodies::new(state.bodies, state.time) }
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
        table(py, self.bodies.orientation.iter().map(|q| (*q * glam::DVec3::Z).to_array()).collect())
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

    /// (N,) uint32: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, shapes(&self.bodies)))
    }

    /// (N, 3): sizes in a scene's order.
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, sizes(&self.bodies))
    }

    /// (N,) uint32: index into the scene's `group_names`; `relcp.NO_GROUP` for a body without a group.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies.group.clone()))
    }

    /// (N,) uint64: identities, unique over a run.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Column<'py, u64> {
        Ok(column(py, ids(&self.bodies)))
    }
    /// (N,) uint64: the id that divided into this one; `relcp.NO_PARENT` for a founder.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Column<'py, u64> {
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
