//! The operations of an iteration of conjugate gradients in few passes over the rows. Each pass does all that it can
//! with the numbers of a chunk while they are in the first-level cache. The bits are those of the operations one by
//! one.

use super::cone::{is_outside, project, residual, room, worse};
use super::loops::{PARTS, dots, map, update};
use super::on_rows::{OnRows, regularize, smaller};

/// `out` becomes the step of [`Verbs::descend`](super::verbs::Verbs::descend) at `x` with the gradient `g`. Returns
/// what [`Verbs::descend_beside`](super::verbs::Verbs::descend_beside) does.
pub(super) fn descend(
    rows: &mut impl OnRows,
    [x, g]: [&[f64]; 2],
    [[d, ad], [e, ae]]: [[&[f64]; 2]; 2],
    out: &mut [f64],
) -> [f64; 6] {
    rows.join_blocks(
        [0.0; 6],
        |_, a, b| a + b,
        |rows, blocks, _| {
            let [x, g, d, ad, e, ae] = [x, g, d, ad, e, ae].map(|vector| &vector[rows.clone()]);
            let z = &mut out[rows];
            blocks.minimize(x, Some((1.0, g)), z);
            update(z, [x], |y, [x]| y - x);
            let ([g_d, g_e], [z_ad, g_z], [z_ae, across]) = (two_dots(g, d, e), two_dots(z, ad, g), two_dots(ae, z, d));
            [g_d, z_ad, g_e, z_ae, across, g_z]
        },
    )
}

/// `x . y` and `x . z`.
#[inline(never)]
fn two_dots(x: &[f64], y: &[f64], z: &[f64]) -> [f64; 2] {
    let mut sums = [[0.0; PARTS]; 2];
    let (x, y, z) = (x.as_chunks::<PARTS>(), y[..x.len()].as_chunks::<PARTS>(), z[..x.len()].as_chunks::<PARTS>());
    let [first, second] = &mut sums;
    for ((x, y), z) in x.0.iter().zip(y.0).zip(z.0) {
        for k in 0..PARTS {
            first[k] += x[k] * y[k];
        }
        for k in 0..PARTS {
            second[k] += x[k] * z[k];
        }
    }
    for (k, x) in x.1.iter().enumerate() {
        first[k] += x * y.1[k];
        second[k] += x * z.1[k];
    }
    sums.map(|parts| parts.into_iter().sum())
}

/// `out` becomes the displacement of [`Verbs::displace`](super::verbs::Verbs::displace). Returns `g . out` and the room
/// along it.
pub(super) fn displace(
    rows: &mut impl OnRows,
    [x, g]: [&[f64]; 2],
    [(a, p), (b, q), (c, r)]: [(f64, &[f64]); 3],
    out: &mut [f64],
    scratch: &mut [f64],
) -> [f64; 2] {
    rows.join_blocks(SLOPE_AND_ROOM, join_slope_and_room, |rows, blocks, _| {
        let [x, g, p, q, r] = [x, g, p, q, r].map(|vector| &vector[rows.clone()]);
        // The same part of the scratch space for every chunk.
        let (out, trial) = (&mut out[rows], &mut scratch[..x.len()]);
        map(trial, [x, p, q, r], |[x, p, q, r]| x + a * p + b * q + c * r);
        blocks.minimize(trial, None, out);
        update(out, [x], |y, [x]| y - x);
        slope_and_room([x, g], out)
    })
}

/// The same numbers for a given displacement.
pub(super) fn along(rows: &mut impl OnRows, [x, g]: [&[f64]; 2], d: &[f64]) -> [f64; 2] {
    rows.join_chunks(SLOPE_AND_ROOM, join_slope_and_room, |rows| {
        let [x, g, d] = [x, g, d].map(|vector| &vector[rows.clone()]);
        slope_and_room([x, g], d)
    })
}

const SLOPE_AND_ROOM: [f64; 2] = [0.0, f64::INFINITY];

fn join_slope_and_room(k: usize, a: f64, b: f64) -> f64 {
    if k == 0 { a + b } else { smaller(a, b) }
}

/// A little more than one: what stays admissible so much farther than the least room has no less of it, whatever is
/// rounded.
const BEYOND: f64 = 1.0 + 16.0 * f64::EPSILON;

/// A row's room is divided out only where it may be the least: most rows stay admissible along the least one so far.
#[inline(never)]
fn slope_and_room([x, g]: [&[f64]; 2], d: &[f64]) -> [f64; 2] {
    let (mut slope, mut least, mut reach) = ([0.0; PARTS], f64::INFINITY, f64::INFINITY);
    let (d, x, g) = (d.as_chunks::<PARTS>(), x[..d.len()].as_chunks::<PARTS>(), g[..d.len()].as_chunks::<PARTS>());
    for ((d, x), g) in d.0.iter().zip(x.0).zip(g.0) {
        let mut leaves = false;
        for k in 0..PARTS {
            slope[k] += g[k] * d[k];
            leaves |= is_outside(x[k] + reach * d[k]);
        }
        if leaves {
            least = x.iter().zip(d).fold(least, |least, (x, d)| smaller(least, room(*x, *d)));
            reach = BEYOND * least;
        }
    }
    for (k, d) in d.1.iter().enumerate() {
        slope[k] += g.1[k] * d;
        least = smaller(least, room(x.1[k], *d));
    }
    [slope.into_iter().sum(), least]
}

/// `product = A d`. Returns `d . A d`.
pub(super) fn multiply<R: OnRows>(rows: &mut R, d: &[f64], product: &mut [f64]) -> f64 {
    let [curvature] = rows.multiply_and_join(
        d,
        product,
        [0.0],
        |_, a, b| a + b,
        |rows, numbers, product| {
            let d = &d[rows.clone()];
            regularize(numbers, rows, d, product);
            dots(0..d.len(), [[d, product]])
        },
    );
    curvature
}

/// `x = max(x + part d, 0)` and `g += part A d`. Returns the natural residual there.
pub(super) fn advance(rows: &mut impl OnRows, part: f64, [d, ad]: [&[f64]; 2], x: &mut [f64], g: &mut [f64]) -> f64 {
    let [residual] = rows.join_blocks(
        [0.0],
        |_, a, b| worse(a, b),
        |rows, _, numbers| {
            let [d, ad, s] = [d, ad, numbers.diagonals.plain()].map(|vector| &vector[rows.clone()]);
            [advance_rows(part, [d, ad, s], &mut x[rows.clone()], &mut g[rows])]
        },
    );
    residual
}

#[inline(never)]
fn advance_rows(part: f64, [d, ad, s]: [&[f64]; 3], x: &mut [f64], g: &mut [f64]) -> f64 {
    const WIDTH: usize = 4;
    let rows = x.len();
    let (d, ad, s) = (d[..rows].as_chunks::<WIDTH>(), ad[..rows].as_chunks::<WIDTH>(), s[..rows].as_chunks::<WIDTH>());
    let ((x, x_rest), (g, g_rest)) = (x.as_chunks_mut::<WIDTH>(), g[..rows].as_chunks_mut::<WIDTH>());
    let mut most = [0.0; WIDTH];
    // Zero, or NaN if a residual is not finite, which a comparison would hide.
    let mut fault = [0.0; WIDTH];
    let inputs = d.0.iter().zip(ad.0).zip(s.0);
    for ((x, g), ((d, ad), s)) in x.iter_mut().zip(g).zip(inputs) {
        for k in 0..WIDTH {
            x[k] = project(x[k] + part * d[k]);
            g[k] += part * ad[k];
            let here = residual(g[k], s[k], x[k]);
            most[k] = if here > most[k] { here } else { most[k] };
            fault[k] += 0.0 * here;
        }
    }
    let mut worst = most.into_iter().zip(fault).fold(0.0, |worst, (most, fault)| worse(worst, most + fault));
    for (k, (x, g)) in x_rest.iter_mut().zip(g_rest).enumerate() {
        *x = project(*x + part * d.1[k]);
        *g += part * ad.1[k];
        worst = worse(worst, residual(*g, s.1[k], *x));
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::super::Problem;
    use super::super::cpu::Cpu;
    use super::super::verbs::{Verbs, composed};
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// A chain of bodies, each connected to the next two by one to ten rows.
    fn chain(uniform: &mut impl FnMut() -> f64) -> Problem<3> {
        let mut problem = Problem { bodies: 202, ..Problem::default() };
        for (a, b) in (0..200).flat_map(|a| [(a, a + 1), (a, a + 2)]) {
            for _ in 0..1 + (3 * a + b) % 10 {
                problem.pair.push([a, b]);
                problem.jacobian.push(std::array::from_fn(|_| std::array::from_fn(|_| uniform())));
                problem.q.push(uniform());
            }
        }
        problem
    }

    #[test]
    fn passes_do_what_their_operations_do_one_by_one() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut uniform = || rng.random::<f64>() - 0.5;
        let mut cpu = Cpu::<3>::default();
        cpu.rebuild(&chain(&mut uniform));
        cpu.set_compliance(1e-3);
        assert!(cpu.has_small_chunks());
        let rows = cpu.all_rows();
        let mut vector = || -> Vec<f64> { (0..rows).map(|_| uniform()).collect() };
        let mut x: Vec<f64> = vector().into_iter().map(project).collect();
        let [mut g, e, mut ad, mut ae] = std::array::from_fn(|_| vector());
        let mut d: Vec<f64> = vector().iter().zip(&x).map(|(d, x)| d.max(-x)).collect();
        cpu.gradient(&x, &mut g);
        cpu.product(&d, &mut ad);
        cpu.product(&e, &mut ae);
        let (mut x_too, mut g_too) = (x.clone(), g.clone());
        let residual = cpu.advance_along(0.3, [&d, &ad], [&mut x, &mut g], &mut Vec::new());
        let none = composed::advance_along(&mut cpu, 0.3, [&d, &ad], [&mut x_too, &mut g_too], &mut Vec::new());
        assert!(none.is_none() && x == x_too && g == g_too);
        assert_eq!(residual, Some(cpu.residual(&x, &g)));

        let past = [[&d, &ad], [&e, &ae]];
        let (mut z, mut z_too) = (vec![0.0; rows], vec![0.0; rows]);
        // Blocks remember their free rows, and compute the next step otherwise.
        cpu.descend(&x, &g, &mut z_too);
        let expected = composed::descend_beside(&mut cpu, [&x, &g], past, &mut z_too);
        let sums = cpu.descend_beside([&x, &g], past, &mut z);
        assert!(z == z_too && sums == expected, "{sums:?} {expected:?}");

        // With and without the other displacement in place of a flat one.
        let terms = [(1.1, &z), (0.2, &d), (-0.1, &e)];
        for most in [f64::INFINITY, f64::NEG_INFINITY] {
            let mut room = vec![0.0; rows];
            let [mut made, mut product, mut made_too, mut product_too] = std::array::from_fn(|_| vec![0.0; rows]);
            let at = [&x, &g];
            let safe = (most, &z);
            let (sums, least) = cpu.displace_and_multiply(at, terms, safe, [&mut made, &mut product], &mut room);
            let made_apart = [&mut made_too, &mut product_too];
            let (sums_too, least_too) =
                composed::displace_and_multiply(&mut cpu, at, terms, safe, made_apart, &mut room);
            assert!(made == made_too && product == product_too && (most > 0.0 || made == z));
            assert!(sums == sums_too && least.is_finite() && least == least_too);
        }

        d.fill(0.0);
        g[rows / 2] = f64::NAN;
        let residual = cpu.advance_along(0.0, [&d, &ad], [&mut x, &mut g], &mut Vec::new());
        assert!(residual.is_some_and(f64::is_nan), "a NaN is not hidden");
    }
}
