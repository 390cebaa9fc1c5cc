//! The error of a step that misses its tolerances in every attempt: overlap, bodies, residual.

use super::Guard;
use std::fmt;

/// Bodies that have no way out, and the walls, by their places in the scene's list, that they are pressed against.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wedge {
    /// The bodies, ascending.
    pub bodies: Vec<usize>,
    /// The walls, ascending.
    pub walls: Vec<usize>,
}

/// Bodies of a wedge that a message names; the others it counts.
const NAMED: usize = 8;

impl fmt::Display for Wedge {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let list = |numbers: &[usize]| numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let named = &self.bodies[..self.bodies.len().min(NAMED)];
        write!(f, "cells {}", list(named))?;
        if self.bodies.len() > NAMED {
            write!(f, " and {} more", self.bodies.len() - NAMED)?;
        }
        match self.walls.as_slice() {
            [] => Ok(()),
            [wall] => write!(f, " and wall {wall}"),
            walls => write!(f, " and walls {}", list(walls)),
        }
    }
}

/// A step that misses a tolerance however it is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// The step that was being taken.
    pub step: u64,
    /// The overlap that its shortest piece would leave, a length.
    pub overlap: f64,
    /// The pair of bodies that overlaps by it, or that went through each other.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap by it, where they do.
    pub wall: Option<[usize; 2]>,
    /// What its velocities times `dt` may be off by, a length.
    pub residual: f64,
    /// Whether it fails only because bodies went through each other.
    pub passed: bool,
    /// The promise about what contact does that is broken.
    pub broken: Option<Guard>,
    /// The body that contact moves farthest from its free motion, and how far.
    pub moved: Option<(usize, f64)>,
    /// The overlap tolerance, which is that of the residual too.
    pub tolerance: f64,
}

impl Unresolved {
    /// Its name in files and tables: what it misses.
    pub fn name(&self) -> &'static str {
        match self.broken {
            _ if self.passed => "passed",
            _ if self.overlap > self.tolerance => "overlap",
            Some(Guard::Energy) => "energy",
            Some(Guard::Spin) => "spin",
            Some(_) => "thrown",
            None => "residual",
        }
    }
}

impl fmt::Display for Unresolved {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Unresolved { step, overlap, residual, tolerance, .. } = self;
        let pair = match (self.pair, self.wall) {
            (_, Some([body, wall])) => format!("body {body} and wall {wall}"),
            (Some([a, b]), None) => format!("bodies {a} and {b}"),
            (None, None) => "bodies".into(),
        };
        write!(f, "step {step}: {pair} ")?;
        match self.name() {
            "passed" => write!(f, "go through each other"),
            "thrown" => {
                let (body, way) = self.moved.unwrap_or_default();
                write!(f, "push each other too far: contact moves body {body} by {way:.2e}")
            }
            "energy" => write!(f, "gain energy by contact"),
            "spin" => write!(f, "are spun by contact about their own axes"),
            "residual" => {
                write!(
                    f,
                    "have no accurate velocities: the contact problem is solved to {residual:.2e}, tolerance {tolerance:.1e}"
                )
            }
            _ => write!(f, "still overlap by {overlap:.2e} of {tolerance:.1e} allowed"),
        }?;
        write!(f, ", even in steps of dt/64")
    }
}
