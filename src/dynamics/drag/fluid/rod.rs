//! Spherocylinders: fits to the flow about them at 19 aspects from 1.02 to 140, by the computation of
//! `tests/physics/stokes.rs` with 48 points on each ring and finer sources, which settles to 1e-5.
//!
//! A rod of length `L` and aspect `p` is compared with the spheroid of that length and thickness, whose resistances are
//! exact. With `s` that to motion along the spheroid's axis over `3 pi L`, which is about `1 / (1.5 ln 2p - 0.75)`, and
//! `x = 1 / p`:
//!
//! ```text
//! U / Z = U / Z_spheroid + (1 - x) (c_0 + c_1 s + c_2 x + c_3 x^2 + c_4 x^3 + c_5 x^4)
//! ```
//!
//! with the units `U` of 2 pi L along, 4 pi L across and pi L^3 / 3 turning across the axis. `c_0` is that of an
//! endless rod (R. G. Cox, J. Fluid Mech. 44, 791 (1970); G. K. Batchelor, J. Fluid Mech. 44, 419 (1970)), and a rod as
//! long as it is thick is the sphere, both exactly. The errors are 7.5e-4, 3.1e-4 and 5.5e-4 at most; turning about the
//! axis, `4 pi r^2 L (1 + x (1 - x) (d_0 + d_1 x + d_2 x^2))`, 7e-5.

use super::ellipsoid;
use glam::DVec3;
use std::f64::consts::{LN_2, PI};

/// `c_0` to `c_5` along, across, and turning across the axis.
pub const SLOWER: [[f64; 6]; 3] = [
    [LN_2 - 1.0, -0.6788, 1.4909, -1.151, 0.5883, -0.0414],
    [LN_2 - 1.0, -0.4817, 0.6974, 0.0506, -0.4909, 0.3324],
    [LN_2 - 4.0 / 3.0, -0.8629, 2.1552, -1.7334, 1.5521, -0.6457],
];

/// `d_0` to `d_2`.
pub const SPINNING: [f64; 3] = [0.1138, -0.0232, 0.0324];

/// In shear a rod turns as a spheroid of aspect `r`: `p^2 / r^2 = 1 + e_0 (1/s - 1) + e_1 (1 - s) + (1 - x) (e_2 + e_3
/// x + e_4 x^2)` within 1.8e-4.
pub const TUMBLING: [f64; 5] = [0.1234, 5.9326, -4.5445, -0.3594, 0.1758];

/// `s` of a rod, and the resistances of its spheroid.
fn spheroid(radius: f64, half: f64) -> (f64, [DVec3; 2]) {
    let of = ellipsoid::resistances(DVec3::new(radius, radius, half));
    (of[0].z / (6.0 * PI * half), of)
}

/// The resistances to motion along and turning about each axis, at a viscosity of 1, of a rod along z of this radius
/// and half its length from tip to tip.
pub fn resistances(radius: f64, half: f64) -> [DVec3; 2] {
    let ((s, [linear, turning]), x, length) = (spheroid(radius, half), radius / half, 2.0 * half);
    let rod = |[a, b, c, d, e, f]: [f64; 6], of_spheroid: f64, unit: f64| {
        let slower = (1.0 - x) * (a + b * s + x * (c + x * (d + x * (e + x * f))));
        unit / (unit / of_spheroid + slower)
    };
    let along = rod(SLOWER[0], linear.z, 2.0 * PI * length);
    let across = rod(SLOWER[1], linear.x, 4.0 * PI * length);
    let over = rod(SLOWER[2], turning.x, PI / 3.0 * length.powi(3));
    let [a, b, c] = SPINNING;
    let about = 4.0 * PI * radius * radius * length * (1.0 + x * (1.0 - x) * (a + x * (b + x * c)));
    [DVec3::new(across, across, along), DVec3::new(over, over, about)]
}

/// Bretherton's constant about y.
pub fn bretherton(radius: f64, half: f64) -> f64 {
    let ((s, _), x) = (spheroid(radius, half), radius / half);
    let [a, b, c, d, e] = TUMBLING;
    // p^2 / r^2, over p^2.
    let square = x * x * (1.0 + a * (1.0 / s - 1.0) + b * (1.0 - s) + (1.0 - x) * (c + x * (d + x * e)));
    (1.0 - square) / (1.0 + square)
}
