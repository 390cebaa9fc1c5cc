//! The norm whose unit ball is a superellipsoid, the gauge; its dual, the support function; integrals over the ball.

use glam::DVec3;

/// The least part of a norm that its second derivatives are taken at: Newton's method that starts at zero then goes far
/// enough to see the gain, and the ratio of the derivatives, 1e8 at most, is still definite.
const LEAST_PART: f64 = 1e-9;

/// The dual norm of a superellipsoid, its support function, with the numbers that it is computed from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Norm {
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
    pub fn new(radii: [f64; 3], exponents: [f64; 2]) -> Norm {
        let less = exponents.map(|n| 1.0 / (n - 1.0));
        Norm { radii: DVec3::from_array(radii), exponents, dual: less.map(|x| 1.0 + x), less }
    }

    /// The gauge at a point, 1 on the surface and less inside, and its gradient.
    pub fn gauge(&self, p: DVec3) -> (f64, DVec3) {
        let (v, [n1, n2]) = (p.abs() / self.radii, self.exponents);
        let across = norm(v.x, v.y, n2);
        let whole = norm(across, v.z, n1);
        let part = |x: f64, of: f64, n: f64| if x > 0.0 { (x / of).powf(n - 1.0) } else { 0.0 };
        let out = part(across, whole, n1);
        let gradient = DVec3::new(out * part(v.x, across, n2), out * part(v.y, across, n2), part(v.z, whole, n1));
        (whole, gradient / self.radii * p.signum())
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
