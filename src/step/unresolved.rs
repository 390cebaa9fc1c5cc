//! The error of a step that misses its tolerances in every attempt: overlap, bodies, residual.

use std::fmt;

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
    /// The overlap tolerance, which is that of the residual too.
    pub tolerance: f64,
}

impl Unresolved {
    /// Its name in files and tables: what it misses.
    pub fn name(&self) -> &'static str {
        if self.passed {
            "passed"
        } else if self.overlap <= self.tolerance {
            "residual"
        } else {
            "overlap"
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
