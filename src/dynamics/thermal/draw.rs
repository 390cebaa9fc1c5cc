//! Normal deviates from counters: Philox 4x32-10 (J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random
//! numbers: as easy as 1, 2, 3", SC '11) and Box and Muller's transformation.
//!
//! Logarithm, sine and cosine are sums of series here and in `shaders/dynamics/draw.wgsl`: no shader language has them
//! in 64 bits, and so the numbers are the same on every machine.

use std::f64::consts::{LN_2, TAU};

/// Rounds of Philox: the paper's number, with which it passes all tests of TestU01.
const ROUNDS: u32 = 10;

/// Its multipliers, and what its keys grow by each round.
pub const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// See [`MULTIPLIERS`].
pub const KEY_STEPS: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// Where in the counter's last word the number of the block is: above the steps, which are under 2^53.
pub const BLOCK_SHIFT: u32 = 24;

/// Terms of the series of the logarithm: its argument is at most `1/5`, and `0.2^24 / 25` is under a rounding.
const LOGARITHM_TERMS: u32 = 12;

/// Terms of those of sine and cosine: their argument is at most an eighth of a turn, and `0.79^18 / 18!` is under a
/// rounding.
const SINE_TERMS: u32 = 9;

/// Philox' block of this counter under this key.
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let wide = |a: u32, b: u32| {
        let product = u64::from(a) * u64::from(b);
        ((product >> 32) as u32, product as u32)
    };
    let (mut c, mut k) = (counter, key);
    for _ in 0..ROUNDS {
        let ((high_0, low_0), (high_1, low_1)) = (wide(MULTIPLIERS[0], c[0]), wide(MULTIPLIERS[1], c[2]));
        c = [high_1 ^ c[1] ^ k[0], low_1, high_0 ^ c[3] ^ k[1], low_0];
        k = [k[0].wrapping_add(KEY_STEPS[0]), k[1].wrapping_add(KEY_STEPS[1])];
    }
    c
}

/// Six independent standard normal numbers, which belong to a body and a step.
pub fn normals(seed: u64, id: u64, step: u64) -> [f64; 6] {
    let [id_low, id_high] = halves(id);
    let [step_low, step_high] = halves(step);
    let block = |number: u32| philox([id_low, id_high, step_low, step_high ^ (number << BLOCK_SHIFT)], halves(seed));
    let (a, b) = (block(0), block(1));
    let ([x, y], [z, u], [v, w]) = (pair(a[0], a[1]), pair(a[2], a[3]), pair(b[0], b[1]));
    [x, y, z, u, v, w]
}

/// The lower and the upper 32 bits.
pub fn halves(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}

/// Two normal numbers of two words: a radius and an angle.
fn pair(radius: u32, angle: u32) -> [f64; 2] {
    let length = (-2.0 * logarithm(radius)).sqrt();
    // The nearest quarter turn, and what is left: from -1/8 to 1/8 of a turn.
    let quarter = (angle >> 30).wrapping_add((angle >> 29) & 1);
    let left = f64::from(angle.wrapping_sub(quarter << 30) as i32) * (TAU / 4_294_967_296.0);
    let [sine, cosine] = sine_and_cosine(left);
    let [x, y] = match quarter & 3 {
        0 => [cosine, sine],
        1 => [-sine, cosine],
        2 => [-cosine, -sine],
        _ => [sine, -cosine],
    };
    [length * x, length * y]
}

/// The logarithm of `(word + 1/2) / 2^32`, by that of a number from 3/4 to 3/2 and its power of two.
fn logarithm(word: u32) -> f64 {
    let power = 31 - (word | 1).leading_zeros() as i32;
    let mut part = (f64::from(word) + 0.5) / f64::from(1_u32 << power);
    let mut power = f64::from(power - 32);
    if part > 1.5 {
        part *= 0.5;
        power += 1.0;
    } else if part < 0.75 {
        part *= 2.0;
        power -= 1.0;
    }
    let s = (part - 1.0) / (part + 1.0);
    let square = s * s;
    let mut sum = 0.0;
    for k in (0..LOGARITHM_TERMS).rev() {
        sum = 1.0 / f64::from(2 * k + 1) + square * sum;
    }
    power * LN_2 + 2.0 * s * sum
}

fn sine_and_cosine(x: f64) -> [f64; 2] {
    let square = x * x;
    let (mut sine, mut cosine) = (1.0, 1.0);
    for k in (1..SINE_TERMS).rev() {
        let n = f64::from(2 * k);
        sine = 1.0 - square / (n * (n + 1.0)) * sine;
        cosine = 1.0 - square / ((n - 1.0) * n) * cosine;
    }
    [x * sine, cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_is_the_published_one() {
        let published = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, block) in published {
            assert_eq!(philox(counter, key), block);
        }
    }

    #[test]
    fn series_are_the_functions_to_rounding() {
        for k in 0..2000_u32 {
            let word = k.wrapping_mul(2_654_435_769) >> (k % 32);
            let exact = ((f64::from(word) + 0.5) / 4_294_967_296.0).ln();
            assert!((logarithm(word) - exact).abs() <= 4e-16 * exact.abs().max(1.0), "{word}: {exact}");
            let x = (f64::from(word) / 4_294_967_296.0 - 0.5) * 0.25 * TAU;
            let [sine, cosine] = sine_and_cosine(x);
            assert!((sine - x.sin()).abs() < 2e-16 && (cosine - x.cos()).abs() < 3e-16, "{x}");
        }
    }

    /// Means, variances, kurtosis and correlations of 600,000 numbers within four standard errors.
    #[test]
    fn numbers_are_normal_and_independent() {
        let n = 100_000_u64;
        let (mut sums, mut products) = ([[0.0; 4]; 6], [0.0; 3]);
        let mut before = [0.0; 6];
        for k in 0..n {
            let drawn = normals(7, k / 100, k % 100);
            for (sum, x) in sums.iter_mut().zip(drawn) {
                let powers = [x, x * x, x * x * x, x * x * x * x];
                sum.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
            }
            products[0] += drawn[0] * drawn[1];
            products[1] += drawn[0] * before[0];
            products[2] += drawn[2] * drawn[5];
            before = drawn;
        }
        let root = (n as f64).sqrt();
        for sum in sums {
            // Of the moments 0, 1, 0, 3 with the variances 1, 2, 15 and 96.
            for ((sum, mean), variance) in sum.iter().zip([0.0, 1.0, 0.0, 3.0]).zip([1.0_f64, 2.0, 15.0, 96.0]) {
                let errors = (sum / n as f64 - mean) * root / variance.sqrt();
                assert!(errors.abs() < 4.0, "{errors}");
            }
        }
        assert!(products.iter().all(|product| product.abs() < 4.0 * root), "{products:?}");
    }
}
