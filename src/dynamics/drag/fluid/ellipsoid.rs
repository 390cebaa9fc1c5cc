//! Ellipsoids, exactly: F. Perrin, J. Phys. Radium 5, 497 (1934) for the resistances to motion, `16 pi eta / (chi +
//! alpha_i a_i^2)`, and D. Edwardes, Q. J. Math. 26, 70 (1893), and G. B. Jeffery, Proc. R. Soc. Lond. A 102, 161
//! (1922) for those to turning, `16 pi eta (b^2 + c^2) / (3 (b^2 beta + c^2 gamma))` about the first axis. With `D(s)^2
//! = (a^2 + s)(b^2 + s)(c^2 + s)`:
//!
//! ```text
//! alpha = integral from 0 to infinity of ds / ((a^2 + s) D(s)) = 2/3 R_D(b^2, c^2, a^2), and cyclically
//! chi = integral of ds / D(s) = a^2 alpha + b^2 beta + c^2 gamma
//! ```
//!
//! The integrals are Carlson's, by his duplication (B. C. Carlson, Numer. Algorithms 10, 13 (1995)).

use glam::DVec3;
use std::f64::consts::PI;

/// Carlson's parameters come as near to each other as this, relatively: the error of the series that follows is of the
/// sixth order, which is below rounding.
const NEAR: f64 = 1e-3;

/// Duplications bring them nearer by a factor of 4 each; those of the longest and thinnest bodies have a ratio of 1e6.
const MOST_DUPLICATIONS: u32 = 24;

/// The resistances to motion along and turning about each axis, at a viscosity of 1.
pub fn resistances(radii: DVec3) -> [DVec3; 2] {
    let scale = radii.max_element();
    let squares = (radii / scale) * (radii / scale);
    let [a, b, c] = squares.to_array();
    let alphas = 2.0 / 3.0 * DVec3::new(carlson([b, c], a), carlson([c, a], b), carlson([a, b], c));
    let parts = squares * alphas;
    let across = |v: DVec3| DVec3::new(v.y + v.z, v.z + v.x, v.x + v.y);
    let linear = 16.0 * PI * scale / (parts.element_sum() + parts);
    let turning = 16.0 / 3.0 * PI * scale.powi(3) * across(squares) / across(parts);
    [linear, turning]
}

/// `R_D(x, y, z)`.
fn carlson([mut x, mut y]: [f64; 2], mut z: f64) -> f64 {
    let (mut sum, mut part) = (0.0, 1.0);
    for _ in 0..MOST_DUPLICATIONS {
        let mean = 0.2 * (x + y + 3.0 * z);
        if (x - mean).abs().max((y - mean).abs()).max((z - mean).abs()) <= NEAR * mean {
            break;
        }
        let [s, t, u] = [x, y, z].map(f64::sqrt);
        let lambda = s * t + t * u + u * s;
        sum += part / (u * (z + lambda));
        part *= 0.25;
        [x, y, z] = [x, y, z].map(|value| 0.25 * (value + lambda));
    }
    let mean = 0.2 * (x + y + 3.0 * z);
    let [x, y] = [x, y].map(|value| (mean - value) / mean);
    let z = -(x + y) / 3.0;
    let (xy, zz) = (x * y, z * z);
    let [e2, e3, e4, e5] = [xy - 6.0 * zz, (3.0 * xy - 8.0 * zz) * z, 3.0 * (xy - zz) * zz, xy * zz * z];
    let series = 1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2 - 3.0 / 22.0 * e4 - 9.0 / 52.0 * e2 * e3
        + 3.0 / 26.0 * e5;
    3.0 * sum + part * series / (mean * mean.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The resistances of spheroids in closed form (S. Kim, S. J. Karrila, Microhydrodynamics, 1991, table 3.4).
    #[test]
    fn spheroids_have_the_closed_forms() {
        for aspect in [1.001_f64, 1.5, 2.0, 5.0, 20.0, 300.0, 1000.0] {
            let e = (1.0 - aspect.powi(-2)).sqrt();
            let log = ((1.0 + e) * aspect).ln() * 2.0;
            let [linear, turning] = resistances(DVec3::new(1.0, 1.0, aspect) / aspect);
            let (one, e2, e3) = (aspect.powi(-2), e * e, e * e * e);
            let close = |name: &str, found: f64, closed: f64, unit: f64| {
                // The closed forms cancel near the sphere.
                let off = (found / (unit * PI) / closed - 1.0).abs() * e.powi(5);
                assert!(off < 1e-14, "{name} at {aspect}: {off:e}");
            };
            close("along", linear.z, 8.0 / 3.0 * e3 / (-2.0 * e + (1.0 + e2) * log), 6.0);
            close("across", linear.x, 16.0 / 3.0 * e3 / (2.0 * e + (3.0 * e2 - 1.0) * log), 6.0);
            close("about", turning.z, 4.0 / 3.0 * e3 * one / (2.0 * e - one * log), 8.0);
            close("over", turning.x, 4.0 / 3.0 * e3 * (2.0 - e2) / (-2.0 * e + (1.0 + e2) * log), 8.0);
        }
    }

    /// A thin disc of radius 1: 16, 32/3, and 32/3 about every axis.
    #[test]
    fn the_limits_are_a_sphere_and_a_disc() {
        let [linear, turning] = resistances(DVec3::splat(0.7));
        assert!((linear / (6.0 * PI * 0.7) - 1.0).abs().max_element() < 1e-15);
        assert!((turning / (8.0 * PI * 0.7_f64.powi(3)) - 1.0).abs().max_element() < 1e-15);
        let [linear, turning] = resistances(DVec3::new(1.0, 1.0, 1e-5));
        assert!((linear - DVec3::new(32.0 / 3.0, 32.0 / 3.0, 16.0)).abs().max_element() < 1e-3, "{linear}");
        assert!((turning - 32.0 / 3.0).abs().max_element() < 1e-3, "{turning}");
    }

    /// Three different radii, against the integrals by the trapezoidal rule in `ln s`.
    #[test]
    fn three_radii_have_the_integrals() {
        let radii = DVec3::new(0.3, 1.1, 2.3);
        let squares = radii * radii;
        let (mut alphas, mut chi) = (DVec3::ZERO, 0.0);
        let (steps, width) = (4000, 80.0);
        for k in 0..=steps {
            // s = e^t, and the integrand vanishes at both ends.
            let s = (width * (k as f64 / steps as f64 - 0.5)).exp();
            let over = squares + s;
            let part = s * (width / steps as f64) / (over.x * over.y * over.z).sqrt();
            alphas += part / over;
            chi += part;
        }
        let parts = squares * alphas;
        let sums = DVec3::splat(squares.element_sum()) - squares;
        let [linear, turning] = resistances(radii);
        assert!((linear * (chi + parts) / (16.0 * PI) - 1.0).abs().max_element() < 1e-8);
        let of_turning = 16.0 * PI * sums / (3.0 * (DVec3::splat(parts.element_sum()) - parts));
        assert!((turning / of_turning - 1.0).abs().max_element() < 1e-8);
    }
}
