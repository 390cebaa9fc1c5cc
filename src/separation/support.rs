//! The support function of an ellipsoid in space and its derivatives, without cancellation.
//!
//! With `M = R diag(radii)`: `h(n) = |M^T n|`, the contact point is `M M^T n / h`, and the Hessian across `n` follows
//! from the cofactors of `M`: for tangents `e_1, e_2` and `K = diag(bc, ca, ab) R^T`, `H_11 = |K e_2|^2 / h^3`, `H_12 =
//! -K e_1 . K e_2 / h^3`, `H_22 = |K e_1|^2 / h^3`. The textbook form `(B - y y^T) / h` loses all digits for flat
//! bodies.

use super::peak::Supporting;
use glam::{DMat3, DQuat, DVec3, Vec3Swizzles};

/// An ellipsoid about the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// Body axes in space, as columns.
    pub axes: DMat3,
    /// Semi-axes.
    pub radii: DVec3,
}

impl Support {
    #[inline]
    pub fn new(radii: DVec3, orientation: DQuat) -> Self {
        Support { axes: DMat3::from_quat(orientation), radii }
    }

    /// `v` in body axes.
    #[inline]
    pub fn to_body(self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes.x_axis.dot(v), self.axes.y_axis.dot(v), self.axes.z_axis.dot(v))
    }

    /// The support function at `n`.
    #[inline]
    pub fn value(self, n: DVec3) -> f64 {
        (self.radii * self.to_body(n)).length()
    }

    /// `M M^T`, whose quadratic form is the squared support function.
    #[inline]
    pub fn square(self) -> DMat3 {
        let [a, b, c] = self.radii.to_array();
        let m = DMat3::from_cols(self.axes.x_axis * a, self.axes.y_axis * b, self.axes.z_axis * c);
        m * m.transpose()
    }

    /// The smallest radius of curvature: a ball of this radius rolls freely inside.
    #[inline]
    pub fn least_curvature_radius(self) -> f64 {
        let least = self.radii.min_element();
        least * least / self.radii.max_element()
    }
}

impl Supporting for Support {
    #[inline]
    fn value_and_point(self, n: DVec3) -> (f64, DVec3) {
        let scaled = self.radii * self.to_body(n);
        let value = scaled.length();
        (value, self.axes * (self.radii * scaled) / value)
    }

    #[inline]
    fn hessian(self, _: DVec3, value: f64, (e1, e2): (DVec3, DVec3)) -> (f64, f64, f64) {
        let cofactors = self.radii.yzx() * self.radii.zxy();
        let (k1, k2) = (cofactors * self.to_body(e1), cofactors * self.to_body(e2));
        let scale = 1.0 / (value * value * value);
        (k2.length_squared() * scale, -k1.dot(k2) * scale, k1.length_squared() * scale)
    }

    #[inline]
    fn size(self) -> f64 {
        self.radii.max_element()
    }

    #[inline]
    fn aspect(self) -> f64 {
        self.radii.max_element() / self.radii.min_element()
    }
}
