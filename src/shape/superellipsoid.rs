//! The superellipsoid `(|x / a|^n2 + |y / b|^n2)^(n1 / n2) + |z / c|^n1 <= 1`: a box with rounded edges and corners,
//! rounder for smaller exponents, an ellipsoid for 2.
//!
//! The left side to the power `1 / n1` is a norm, the gauge, so the support function is the dual norm: the same with
//! the exponents `m = n / (n - 1)` of `(a n_x, b n_y, c n_z)`. The surface point is its gradient. Volume and inertia
//! are integrals of sections, which are beta functions.
//!
//! Degenerate cases: exponents over 2 leave no curvature where the surface meets an axis: there the Hessian of the
//! support function has no bound, and is taken at [`LEAST_PART`].

use super::convex::Convex;
use super::{PLANAR_TOLERANCE, ShapeError, check_aspect, check_size, ellipsoid};
use glam::{DQuat, DVec3};
use std::collections::HashMap;
use std::fmt;
use std::sync::{LazyLock, Mutex, PoisonError};

/// The exponents that are supported. Below 1 the body is not convex; below 2 its edges or points have no radius of
/// curvature. At 10 the faces of a cube bend by 1e-4 of its size over their middle halves; at 20 the search of deep
/// overlaps missed the largest of several maxima by 4e-4 of the size in one of 60 degenerate poses, at 10 in none.
pub const EXPONENTS: [f64; 2] = [2.0, 10.0];

/// The least part of a norm that its second derivatives are taken at: Newton's method that starts at zero then goes far
/// enough to see the gain, and the ratio of the derivatives, 1e8 at most, is still definite.
const LEAST_PART: f64 = 1e-9;

/// A superellipsoid's sizes, with what follows from them: made once for the same sizes and kept as long as the program
/// runs, so that it is as small as a reference, and two are equal where their sizes are.
#[derive(Clone, Copy)]
pub struct Superellipsoid(&'static Known);

struct Known {
    sizes: Sizes,
    fault: Option<ShapeError>,
    convex: Convex,
}

/// A superellipsoid as files have it: semi-axes along the body's x, y and z, and the exponents `n1` of the outline
/// through z and `n2` of the section across it, as `block n1 n2` of LAMMPS.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, rename = "Superellipsoid"))]
struct Sizes {
    /// The three semi-axes.
    #[cfg_attr(feature = "files", schemars(extend("items" = {"type": "number", "format": "double", "exclusiveMinimum": 0})))]
    radii: [f64; 3],
    /// The exponents `[n1, n2]` of the outline through z and of the section across it, 2 to 10: 2 for an ellipse.
    #[cfg_attr(feature = "files", schemars(extend("items" = {"type": "number", "format": "double", "minimum": 2, "maximum": 10})))]
    exponents: [f64; 2],
}

static MADE: LazyLock<Mutex<HashMap<[u64; 5], &'static Known>>> = LazyLock::new(Mutex::default);

impl Superellipsoid {
    /// The superellipsoid with these semi-axes and exponents `[n1, n2]`; [`Shape::validate`](super::Shape::validate)
    /// says whether it is one.
    ///
    /// ```
    /// use relcp::shape::{Shape, Superellipsoid};
    /// let die = Shape::Superellipsoid(Superellipsoid::new([0.5; 3], [8.0; 2]));
    /// assert!(die.validate().is_ok() && die.volume() > 0.93);
    /// let star = Shape::Superellipsoid(Superellipsoid::new([0.5; 3], [0.8; 2]));
    /// assert!(star.validate().is_err());
    /// ```
    pub fn new(radii: [f64; 3], exponents: [f64; 2]) -> Superellipsoid {
        let [a, b, c] = radii.map(f64::to_bits);
        let [e, f] = exponents.map(f64::to_bits);
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        Superellipsoid(made.entry([a, b, c, e, f]).or_insert_with(|| {
            let sizes = Sizes { radii, exponents };
            let fault = validate(&sizes).err();
            // Numbers that are no shape's are never asked for.
            let of = if fault.is_some() { Sizes { radii: [1.0; 3], exponents: [2.0; 2] } } else { sizes };
            Box::leak(Box::new(Known { sizes, fault, convex: Convex::of_superellipsoid(Norm::new(&of)) }))
        }))
    }

    /// The semi-axes.
    pub fn radii(&self) -> [f64; 3] {
        self.0.sizes.radii
    }

    /// The exponents `[n1, n2]`.
    pub fn exponents(&self) -> [f64; 2] {
        self.0.sizes.exponents
    }

    #[inline]
    pub(super) fn convex(&self) -> Convex {
        self.0.convex
    }

    pub(super) fn validate(&self) -> Result<(), ShapeError> {
        self.0.fault.map_or(Ok(()), Err)
    }

    /// The axis that it is a body of revolution about.
    pub(super) fn axis_of_revolution(&self) -> Option<DVec3> {
        let ([a, b, _], [_, n2]) = (self.radii(), self.exponents());
        (n2 == 2.0 && a == b && !self.is_ball()).then_some(DVec3::Z)
    }

    fn is_ball(&self) -> bool {
        let [a, b, c] = self.radii();
        self.exponents() == [2.0; 2] && a == b && b == c
    }

    /// Whether the plane through the origin at right angles to the z of space mirrors it.
    pub(super) fn is_planar_symmetric(&self, orientation: DQuat) -> bool {
        let axis = (orientation.inverse() * DVec3::Z).abs();
        // A coordinate plane mirrors it, whatever the exponents; others are looked for.
        let aligned = axis.to_array().iter().filter(|x| **x <= PLANAR_TOLERANCE).count() == 2;
        match self.exponents() {
            [2.0, 2.0] => ellipsoid::is_planar_symmetric(self.radii(), orientation),
            _ => aligned || self.0.convex.is_planar_symmetric(orientation),
        }
    }
}

impl PartialEq for Superellipsoid {
    fn eq(&self, other: &Superellipsoid) -> bool {
        self.0.sizes == other.0.sizes
    }
}

impl fmt::Debug for Superellipsoid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sizes { radii, exponents } = self.0.sizes;
        f.debug_struct("Superellipsoid").field("radii", &radii).field("exponents", &exponents).finish()
    }
}

#[cfg(feature = "files")]
impl serde::Serialize for Superellipsoid {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.sizes.serialize(serializer)
    }
}

#[cfg(feature = "files")]
impl<'de> serde::Deserialize<'de> for Superellipsoid {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Sizes { radii, exponents } = Sizes::deserialize(deserializer)?;
        Ok(Superellipsoid::new(radii, exponents))
    }
}

#[cfg(feature = "files")]
impl schemars::JsonSchema for Superellipsoid {
    fn inline_schema() -> bool {
        Sizes::inline_schema()
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        Sizes::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        Sizes::json_schema(generator)
    }
}

fn validate(sizes: &Sizes) -> Result<(), ShapeError> {
    ellipsoid::validate(sizes.radii)?;
    for (name, value) in ["exponents.0", "exponents.1"].into_iter().zip(sizes.exponents) {
        check_size(name, value)?;
        if !(EXPONENTS[0]..=EXPONENTS[1]).contains(&value) {
            return Err(ShapeError::Exponent { name, value });
        }
    }
    let norm = Norm::new(sizes);
    check_aspect("radii", norm.bounding_radius(), norm.radii.min_element())
}

/// The dual norm of a superellipsoid, its support function, with the numbers that it is computed from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Norm {
    radii: DVec3,
    exponents: [f64; 2],
    /// `m = n / (n - 1)` of each exponent, and `m - 1`.
    dual: [f64; 2],
    less: [f64; 2],
}

/// The parts of the norm of one vector: `q` of x and y in that of both, `r` of both and of z in the whole.
struct Parts {
    height: f64,
    q: [f64; 2],
    r: [f64; 2],
}

impl Norm {
    fn new(sizes: &Sizes) -> Norm {
        let less = sizes.exponents.map(|n| 1.0 / (n - 1.0));
        Norm { radii: DVec3::from_array(sizes.radii), exponents: sizes.exponents, dual: less.map(|x| 1.0 + x), less }
    }

    #[inline]
    fn parts(&self, n: DVec3) -> Parts {
        let v = self.radii * n.abs();
        let [m1, m2] = self.dual;
        let across = norm(v.x, v.y, m2);
        let height = norm(across, v.z, m1);
        let q = if across > 0.0 { [v.x / across, v.y / across] } else { [1.0, 0.0] };
        Parts { height, q, r: [across / height, v.z / height] }
    }

    /// The surface point whose outward normal is `n`.
    #[inline]
    pub fn point(&self, n: DVec3) -> DVec3 {
        let Parts { q: [qx, qy], r: [across, along], .. } = self.parts(n);
        let [e1, e2] = self.less;
        let out = across.powf(e1);
        let outward = DVec3::new(out * qx.powf(e2), out * qy.powf(e2), along.powf(e1));
        self.radii * outward * n.signum()
    }

    /// The Hessian of the support function across the unit vector `n` in a tangent basis, as (11, 12, 22).
    ///
    /// With `s` the norm of x and y, `N(s, w)` has the second derivatives `(m - 1) / N` times `r_s^(m - 2) r_w^m`,
    /// `-(r_s r_w)^(m - 1)` and `r_w^(m - 2) r_s^m`; that of `s` in x and y likewise, times the derivative
    /// `r_s^(m - 1)` of `N`.
    #[inline]
    pub fn hessian(&self, n: DVec3, (e1, e2): (DVec3, DVec3)) -> (f64, f64, f64) {
        let Parts { height, q: [qx, qy], r: [across, along] } = self.parts(n);
        let ([m1, m2], [l1, l2]) = (self.dual, self.less);
        let steep = |x: f64, m: f64| x.max(LEAST_PART).powf(m - 2.0);
        let scale = self.radii * n.signum();
        let [u, v] = [scale * e1, scale * e2];
        let [gx, gy] = [qx.powf(l2), qy.powf(l2)];
        // The derivatives of `s` along both directions, and the second one of N in it and in z.
        let s = |d: DVec3| gx * d.x + gy * d.y;
        let of_both =
            [steep(across, m1) * along.powf(m1), (across * along).powf(l1), steep(along, m1) * across.powf(m1)];
        let own = [steep(qx, m2) * qy.powf(m2), gx * gy, steep(qy, m2) * qx.powf(m2)];
        // r_s^(m1 - 1) / s is r_s^(m1 - 2) / N.
        let weight = steep(across, m1) * l2;
        let form = |a: DVec3, b: DVec3| {
            let whole = of_both[0] * s(a) * s(b) - of_both[1] * (s(a) * b.z + s(b) * a.z) + of_both[2] * a.z * b.z;
            let flat = own[0] * a.x * b.x - own[1] * (a.x * b.y + b.x * a.y) + own[2] * a.y * b.y;
            (l1 * whole + weight * flat) / height
        };
        (form(u, u), form(u, v), form(v, v))
    }

    /// The distance of the farthest point: by Hoelder's inequality `(x^q + y^q)^(1 / q)` of the largest extents with
    /// `1 / q = 1 / 2 - 1 / n`.
    pub fn bounding_radius(&self) -> f64 {
        let of = |a: f64, b: f64, n: f64| if n > 2.0 { norm(a, b, 2.0 * n / (n - 2.0)) } else { a.max(b) };
        let [n1, n2] = self.exponents;
        of(of(self.radii.x, self.radii.y, n2), self.radii.z, n1)
    }

    /// The smallest width: it contains the ellipsoid with its radii, and touches it on the axes.
    pub fn thickness(&self) -> f64 {
        2.0 * self.radii.min_element()
    }

    pub fn half_widths(&self) -> DVec3 {
        self.radii
    }

    /// The area of the section across z, and its moments `x^2` and `y^2`, with the integrals of the powers of sections
    /// along z.
    pub fn volume(&self) -> f64 {
        let [n1, _] = self.exponents;
        self.section() * 2.0 * self.radii.z * beta_part(0.0, 2.0, n1)
    }

    fn section(&self) -> f64 {
        4.0 * self.radii.x * self.radii.y * beta_part(0.0, 1.0, self.exponents[1])
    }

    /// The moments of inertia about the axes per unit density.
    pub fn unit_inertia(&self) -> DVec3 {
        let ([n1, n2], DVec3 { x: a, y: b, z: c }) = (self.exponents, self.radii);
        let across = 4.0 * a * b * beta_part(2.0, 1.0, n2) * 2.0 * c * beta_part(0.0, 4.0, n1);
        let along = self.section() * 2.0 * c.powi(3) * beta_part(2.0, 2.0, n1);
        let [xx, yy] = [across * a * a, across * b * b];
        DVec3::new(yy + along, along + xx, xx + yy)
    }
}

/// `(a^m + b^m)^(1/m)` of numbers that are not negative.
#[inline]
fn norm(a: f64, b: f64, m: f64) -> f64 {
    let (large, small) = if a > b { (a, b) } else { (b, a) };
    if small == 0.0 { large } else { large * (1.0 + (small / large).powf(m)).powf(1.0 / m) }
}

/// The integral of `t^k (1 - t^n)^(p / n)` from 0 to 1, a beta function over `n`.
fn beta_part(k: f64, p: f64, n: f64) -> f64 {
    let (x, y) = ((k + 1.0) / n, p / n + 1.0);
    (ln_gamma(x) + ln_gamma(y) - ln_gamma(x + y)).exp() / n
}

/// The logarithm of the gamma function of a positive number, to 1e-15: Lanczos' approximation with nine terms.
fn ln_gamma(x: f64) -> f64 {
    const TERMS: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    // For numbers under 1 the next one's, as the approximation is for those.
    if x < 1.0 {
        return ln_gamma(x + 1.0) - x.ln();
    }
    let x = x - 1.0;
    let sum = (1..9).fold(TERMS[0], |sum, k| sum + TERMS[k] / (x + k as f64));
    let t = x + 7.5;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}
