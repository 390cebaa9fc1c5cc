//! Tori: fits to the flow about them at 24 ratios of the radii from 0.001 to 0.999, by the computation of
//! `tests/physics/stokes.rs` with up to 40 rings of sources, which settles to 1e-6.
//!
//! With `e` the tube's radius over that of its circle, `R`, and `l = ln(8 / e)`, a resistance is `U / (l + c_0 + e^2
//! (c_1 + c_2 e + c_3 e^2 + (c_4 + c_5 e) l))`, with the units `U` of 8 pi^2 R along, 6 pi^2 R across, and 4 pi^2 R^3
//! turning across and about the axis. The constants `c_0` are those of thin rings (R. E. Johnson, T. Y. Wu, J. Fluid
//! Mech. 95, 263 (1979)). Across the axis a thin ring's is no constant, as its drag is shared between two ways of flow:
//! a fit in `1 / l`. The errors are 6.5e-5, 5.1e-4, 5.3e-4 and 6.8e-4 at most.

use glam::DVec3;
use std::f64::consts::PI;

/// `c_0` to `c_5` along, turning across and about the axis.
pub const TERMS: [[f64; 6]; 3] = [
    [0.5, 7.4251, 1.8574, -0.5442, -2.1224, -2.2435],
    [-1.5, 72.6668, 18.754, -4.827, -17.8046, -23.9717],
    [-2.0, 66.8772, 26.9148, -6.5829, -15.2344, -26.6241],
];

/// Across the axis: `d_0 + d_1 / l + d_2 / l^2 + e^2 (d_3 + d_4 e^2 + d_5 l)` in place of what follows `l`.
pub const ACROSS: [f64; 6] = [0.1897, 2.021, -7.6551, 2.201, -0.243, -0.7535];

/// In shear a ring turns as a spheroid of aspect `r`: `r^2 / e^2` is 0.75 l and the same sum with these, within 1.6e-4.
pub const TUMBLING: [f64; 6] = [-1.2507, 30.9283, 8.5726, -2.1604, -7.3939, -10.5461];

fn sum([a, b, c, d, f, g]: [f64; 6], e: f64, l: f64) -> f64 {
    a + e * e * (b + e * (c + e * d) + (f + e * g) * l)
}

/// The resistances to motion along and turning about each axis, at a viscosity of 1.
pub fn resistances(major: f64, minor: f64) -> [DVec3; 2] {
    let e = minor / major;
    let l = (8.0 / e).ln();
    let [a, b, c, d, f, g] = ACROSS;
    let across = 6.0 * PI * PI * major / (l + a + (b + c / l) / l + e * e * (d + f * e * e + g * l));
    let along = 8.0 * PI * PI * major / (l + sum(TERMS[0], e, l));
    let [over, about] = [1, 2].map(|k| 4.0 * PI * PI * major.powi(3) / (l + sum(TERMS[k], e, l)));
    [DVec3::new(across, across, along), DVec3::new(over, over, about)]
}

/// Bretherton's constant about y.
pub fn bretherton(major: f64, minor: f64) -> f64 {
    let e = minor / major;
    let l = (8.0 / e).ln();
    let square = e * e * (0.75 * l + sum(TUMBLING, e, l));
    (square - 1.0) / (square + 1.0)
}
