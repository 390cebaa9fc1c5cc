//! What public engines came to on the same scene, measured elsewhere.

use serde::Serialize;

/// An engine's figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Engine {
    /// The engine and its settings.
    pub name: &'static str,
    /// The step.
    pub dt: f64,
    /// Milliseconds of a step, on one core of another machine.
    pub milliseconds: f64,
    /// The largest true overlap, a length.
    pub overlap: f64,
}

/// Of 1,000 rods.
pub const ENGINES: [Engine; 4] = [
    Engine { name: "Rapier, 16 substeps, stiff contacts", dt: 0.02, milliseconds: 24.0, overlap: 6.3e-2 },
    Engine { name: "Rapier, 16 substeps, stiff contacts", dt: 0.005, milliseconds: 23.0, overlap: 1.8e-3 },
    Engine { name: "MuJoCo, CG", dt: 0.005, milliseconds: 20.0, overlap: 5.2e-3 },
    Engine { name: "Bullet", dt: 0.02, milliseconds: 239.0, overlap: 1.9e-2 },
];

/// How many rods they were given.
pub(super) const RODS: usize = 1000;

/// The radius of gyration of so many at the end.
pub(super) const GYRATION: f64 = 3.48;
