//! Forces that are Python functions of the arrays of all bodies.
//!
//! The function is called with the interpreter's lock on the thread that takes the step. Its exception is stored, and
//! raised by the call that took the step.

use super::bodies::PyBodies;
use crate::bodies::Bodies;
use crate::dynamics::{ForceField, Load};
use glam::DVec3;
use numpy::PyArrayMethods;
use numpy::{PyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

thread_local! {
    /// The simulations whose forces or rules are being evaluated on this thread.
    static EVALUATING: RefCell<Vec<u64>> = const { RefCell::new(Vec::new()) };
}

static SIMULATIONS: AtomicU64 = AtomicU64::new(0);

/// Shared by a simulation, its forces and its rules: its identity, and the exception of a function.
#[derive(Clone)]
pub(super) struct ForceCalls {
    number: u64,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl ForceCalls {
    /// For a new simulation.
    pub fn new() -> Self {
        ForceCalls { number: SIMULATIONS.fetch_add(1, Ordering::Relaxed), raised: Arc::default() }
    }

    /// Whether this thread is evaluating a force or a rule of the simulation.
    pub fn is_evaluating(&self) -> bool {
        EVALUATING.with_borrow(|numbers| numbers.contains(&self.number))
    }

    /// Calls Python code of the user on the thread that takes a step. Its exception is kept, and its message returned.
    pub fn ask<T>(&self, code: impl FnOnce(Python<'_>) -> PyResult<T>) -> Result<T, String> {
        EVALUATING.with_borrow_mut(|numbers| numbers.push(self.number));
        let asked = Python::try_attach(code);
        EVALUATING.with_borrow_mut(|numbers| numbers.pop());
        match asked {
            Some(Ok(answer)) => Ok(answer),
            Some(Err(raised)) => {
                let said = raised.to_string();
                *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(raised);
                Err(said)
            }
            None => Err("the interpreter is shutting down".into()),
        }
    }

    /// The exception of a function since the last call.
    pub fn take(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A Python function as a force.
pub(super) struct PyForce {
    function: Py<PyAny>,
    force_calls: ForceCalls,
    group_names: Arc<[String]>,
    /// The loads of its last evaluation.
    loads: RwLock<Vec<Load>>,
}

impl PyForce {
    /// The force of a function, in a scene with these groups.
    pub fn new(function: Bound<'_, PyAny>, force_calls: ForceCalls, group_names: Vec<String>) -> PyResult<Self> {
        if !function.is_callable() {
            return Err(PyTypeError::new_err("force: expected a function of a relcp.Bodies"));
        }
        let (function, group_names) = (function.unbind(), group_names.into());
        Ok(PyForce { function, force_calls, group_names, loads: RwLock::default() })
    }

    fn evaluate(&self, py: Python<'_>, bodies: &Bodies, time: f64) -> PyResult<Vec<Load>> {
        let seen = Bound::new(py, PyBodies::new(bodies.clone(), time, Vec::new(), self.group_names.clone()))?;
        let given = self.function.bind(py).call1((seen,))?;
        let (forces, torques) = match given.cast::<PyTuple>() {
            Ok(pair) if pair.len() == 2 => (pair.get_item(0)?, Some(pair.get_item(1)?).filter(|t| !t.is_none())),
            Ok(other) => {
                let message = format!("a force returned a tuple of {}: expected (forces, torques)", other.len());
                return Err(PyValueError::new_err(message));
            }
            Err(_) => (given, None),
        };
        let forces = rows(&forces, "forces", bodies.len())?;
        let torques = torques.map(|torques| rows(&torques, "torques", bodies.len())).transpose()?;
        let torque = |i: usize| torques.as_ref().map_or(DVec3::ZERO, |torques| torques[i]);
        Ok(forces.iter().enumerate().map(|(i, force)| Load { force: *force, torque: torque(i) }).collect())
    }
}

/// An array with one finite vector per body.
fn rows(given: &Bound<'_, PyAny>, what: &str, bodies: usize) -> PyResult<Vec<DVec3>> {
    let py = given.py();
    let as_floats = || {
        let arguments = PyDict::new(py);
        arguments.set_item("order", "C")?;
        // Neither strings nor complex numbers are converted to floats.
        arguments.set_item("casting", "same_kind")?;
        py.import("numpy")?.call_method1("asarray", (given,))?.call_method("astype", ("float64",), Some(&arguments))
    };
    let array = as_floats().map_err(|no| {
        let message = format!("a force returned {what} that are not an array of numbers: {}", no.value(py));
        let error = PyTypeError::new_err(message);
        error.set_cause(py, Some(no));
        error
    })?;
    let shape = array.cast::<PyUntypedArray>()?.shape().to_vec();
    if shape != [bodies, 3] {
        let message = format!("a force returned {what} of shape {shape:?}: expected one row per body, ({bodies}, 3)");
        return Err(PyValueError::new_err(message));
    }
    let numbers = array.cast::<PyArray2<f64>>()?.to_vec().map_err(|no| PyRuntimeError::new_err(no.to_string()))?;
    if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
        let message = format!("a force returned {what} that are not finite: {} for body {}", numbers[at], at / 3);
        return Err(PyValueError::new_err(message));
    }
    Ok(numbers.chunks_exact(3).map(DVec3::from_slice).collect())
}

impl ForceField for PyForce {
    fn prepare(&self, bodies: &Bodies, time: f64) -> Result<(), String> {
        let loads = self.force_calls.ask(|py| self.evaluate(py, bodies, time))?;
        *self.loads.write().unwrap_or_else(PoisonError::into_inner) = loads;
        Ok(())
    }

    fn load(&self, _bodies: &Bodies, i: usize, _time: f64) -> Load {
        self.loads.read().unwrap_or_else(PoisonError::into_inner).get(i).copied().unwrap_or_default()
    }
}
