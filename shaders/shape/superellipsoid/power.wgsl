// Powers in both precisions, to a few roundings. `pow` has no 64 bits, and in 32 bits adapters may lose digits.

const LOGARITHM_OF_2: real = 0.69314718055994530942;
const PER_LOGARITHM_OF_2: real = 1.44269504088896340736;
// Numbers below the smallest normal 32-bit float count as zero.
const LEAST_BASE: real = 1.1754944e-38;
// Powers of two up to this, and their reciprocals, are normal 32-bit floats.
const MOST_LOGARITHM: real = 87.0;

// Two to a whole power from -126 to 127.
fn power_of_two(k: i32) -> real {
    return real(bitcast<f32>(u32(k + 127) << 23u));
}

// x^m for x from 0 to 2, zero for x = 0.
//
// The logarithm is that of the power of two plus 2 artanh s with s = (z - 1) / (z + 1), |s| < 0.172, whose series ends
// below a rounding of 64 bits, as that of the exponential within half of ln 2.
fn power(x: real, m: real) -> real {
    if m == 1.0 { return x; }
    if !(x >= LEAST_BASE) { return 0.0; }
    var k = i32(bitcast<u32>(f32(x)) >> 23u) - 127;
    var z = x * power_of_two(-k);
    if z > 1.4142135 {
        z *= 0.5;
        k += 1;
    }
    let s = (z - 1.0) / (z + 1.0);
    let t = s * s;
    let odd = 1.0 + t * (1.0 / 3.0 + t * (1.0 / 5.0 + t * (1.0 / 7.0 + t * (1.0 / 9.0 + t * (1.0 / 11.0
        + t * (1.0 / 13.0 + t * (1.0 / 15.0 + t * (1.0 / 17.0 + t * (1.0 / 19.0 + t * (1.0 / 21.0))))))))));
    let y = clamp(m * (real(k) * LOGARITHM_OF_2 + 2.0 * s * odd), -MOST_LOGARITHM, MOST_LOGARITHM);
    let whole = round(y * PER_LOGARITHM_OF_2);
    let r = y - whole * LOGARITHM_OF_2;
    let high = 1.0 / 5040.0 + r * (1.0 / 40320.0 + r * (1.0 / 362880.0 + r * (1.0 / 3628800.0 + r * (1.0 / 39916800.0
        + r * (1.0 / 479001600.0 + r * (1.0 / 6227020800.0))))));
    let rest = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0
        + r * high))))));
    return rest * power_of_two(i32(whole));
}

// (a^m + b^m)^(1/m) of numbers that are not negative.
fn norm_of_two(a: real, b: real, m: real) -> real {
    let large = max(a, b);
    if !(large > 0.0) { return 0.0; }
    return large * power(1.0 + power(min(a, b) / large, m), 1.0 / m);
}
