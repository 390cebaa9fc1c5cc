//! Volume, moments of inertia and reach, by closed forms.

use super::superellipsoid;
use glam::DVec3;
use relcp::shape::Shape;

/// The gamma function by Stirling's series, far from the origin, and its recursion.
fn gamma(x: f64) -> f64 {
    const FAR: f64 = 20.0;
    if x < FAR {
        return gamma(x + 1.0) / x;
    }
    let series = 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3)) + 1.0 / (1260.0 * x.powi(5)) - 1.0 / (1680.0 * x.powi(7));
    (std::f64::consts::TAU / x).sqrt() * (x * (x.ln() - 1.0) + series).exp()
}

/// Of equal exponents `n` the integral of `x^p y^q z^r` over an octant is Dirichlet's:
/// `G((p + 1) / n) G((q + 1) / n) G((r + 1) / n) / (n^3 G(1 + (p + q + r + 3) / n))` for semi-axes of one.
fn octant(powers: [f64; 3], n: f64) -> f64 {
    let parts = powers.map(|p| (p + 1.0) / n);
    parts.iter().map(|x| gamma(*x)).product::<f64>() / (n.powi(3) * gamma(1.0 + parts.iter().sum::<f64>()))
}

#[test]
fn volume_and_inertia_are_dirichlets_integrals() {
    assert!((gamma(5.0) - 24.0).abs() < 1e-12 && (gamma(0.5).powi(2) - std::f64::consts::PI).abs() < 1e-13);
    for (n, [a, b, c]) in [(2.0, [1.0; 3]), (2.5, [0.5, 1.0, 2.0]), (4.0, [3.0, 0.1, 1.0]), (10.0, [1.0, 2.0, 1.5])] {
        let shape = superellipsoid([a, b, c], [n, n]);
        let scale = 8.0 * a * b * c;
        let volume = scale * octant([0.0; 3], n);
        assert!((shape.volume() / volume - 1.0).abs() < 1e-13, "{n}: {} {volume}", shape.volume());
        // The squares along all axes are alike but for the semi-axes.
        let square = scale * octant([2.0, 0.0, 0.0], n);
        let [xx, yy, zz] = [a, b, c].map(|r| r * r * square);
        let expected = DVec3::new(yy + zz, zz + xx, xx + yy);
        let part = (shape.unit_inertia() / expected - 1.0).abs().max_element();
        assert!(part < 1e-13, "{n}: {} {expected}", shape.unit_inertia());
    }
}

/// The integral from 0 to 1 of a function of `z` and its logarithm, which may have roots at the ends: the trapezoidal
/// rule in `t` with `z = 1 / (1 + exp(-pi sinh t))`.
fn integral(f: impl Fn(f64, f64) -> f64) -> f64 {
    const STEP: f64 = 0.01;
    let at = |i: i32| {
        let t = STEP * f64::from(i);
        let s = std::f64::consts::PI * t.sinh();
        let (log, rest) = (-(-s).exp().ln_1p(), 1.0 / (1.0 + s.exp()));
        f(log.exp(), log) * log.exp() * rest * std::f64::consts::PI * t.cosh()
    };
    STEP * (-400..=400).map(at).sum::<f64>()
}

/// Of two exponents: the section at height z is the superellipse of `n2`, smaller by `(1 - z^n1)^(1 / n1)`.
#[test]
fn of_two_exponents_they_are_integrals_of_sections() {
    for ([n1, n2], [a, b, c]) in [([4.0, 2.0], [1.0, 2.0, 0.5]), ([2.5, 8.0], [1.0; 3]), ([10.0, 3.0], [0.2, 1.0, 3.0])]
    {
        let shape = superellipsoid([a, b, c], [n1, n2]);
        // In the plane: `4 G(1 + 1/n)^2 / G(1 + 2/n)`, and of x^2 over it as in space.
        let area = 4.0 * gamma(1.0 + 1.0 / n2).powi(2) / gamma(1.0 + 2.0 / n2);
        let square = 4.0 * gamma(3.0 / n2) * gamma(1.0 / n2) / (n2.powi(2) * gamma(1.0 + 4.0 / n2));
        let along = |power: f64, z_power: f64| {
            2.0 * integral(|z, log| z.powf(z_power) * (-(n1 * log).exp_m1()).powf(power / n1))
        };
        let volume = a * b * c * area * along(2.0, 0.0);
        let [xx, yy] = [a, b].map(|r| r * r * a * b * c * square * along(4.0, 0.0));
        let zz = a * b * c.powi(3) * area * along(2.0, 2.0);
        assert!((shape.volume() / volume - 1.0).abs() < 1e-12, "{} {volume}", shape.volume());
        let expected = DVec3::new(yy + zz, zz + xx, xx + yy);
        let part = (shape.unit_inertia() / expected - 1.0).abs().max_element();
        assert!(part < 1e-12, "{n1} {n2}: {} {expected}", shape.unit_inertia());
    }
}

/// The corner of a cube's relative is its farthest point, the boxes along the axes are the semi-axes.
#[test]
fn corners_are_farthest_and_boxes_are_the_semi_axes() {
    for n in [2.5_f64, 4.0, 8.0, 10.0] {
        let shape = superellipsoid([0.5; 3], [n, n]);
        let corner = 0.5 * 3f64.powf(0.5 - 1.0 / n);
        assert!((shape.bounding_radius() - corner).abs() < 1e-14, "{n}: {} {corner}", shape.bounding_radius());
        assert!((shape.major_axis() - 2.0 * corner).abs() < 1e-14 && (shape.thickness() - 1.0).abs() < 1e-14);
        let shape = superellipsoid([0.5, 0.7, 0.2], [n, 3.0]);
        let half = shape.half_extents(glam::DQuat::IDENTITY);
        assert!((half - DVec3::new(0.5, 0.7, 0.2)).abs().max_element() < 1e-15, "{half}");
    }
    let tablet = superellipsoid([0.6, 0.6, 0.3], [2.5, 2.0]);
    assert_eq!(tablet.axis_of_revolution(), Some(DVec3::Z));
    assert_eq!(superellipsoid([0.6, 0.6, 0.3], [2.5, 2.5]).axis_of_revolution(), None);
    assert!(matches!(tablet, Shape::Superellipsoid(_)));
}
