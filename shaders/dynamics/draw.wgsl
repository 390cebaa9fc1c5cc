// Normal deviates from counters, as in src/dynamics/thermal/draw.rs: Philox 4x32-10 and Box and Muller's
// transformation.

const ROUNDS: u32 = 10u;
const TURN: real = 6.28318530717958647692;
const LOGARITHM_OF_TWO: real = 0.693147180559945309417;

// The upper word of a product.
fn upper(a: u32, b: u32) -> u32 {
    let a_low = a & 0xffffu;
    let a_high = a >> 16u;
    let b_low = b & 0xffffu;
    let b_high = b >> 16u;
    let low = a_low * b_low;
    let mid = a_high * b_low + (low >> 16u);
    let other = a_low * b_high + (mid & 0xffffu);
    return a_high * b_high + (mid >> 16u) + (other >> 16u);
}

fn philox(counter: vec4<u32>, key: vec2<u32>) -> vec4<u32> {
    var c = counter;
    var k = key;
    for (var round = 0u; round < ROUNDS; round += 1u) {
        c = vec4<u32>(
            upper(MULTIPLIER_1, c.z) ^ c.y ^ k.x,
            MULTIPLIER_1 * c.z,
            upper(MULTIPLIER_0, c.x) ^ c.w ^ k.y,
            MULTIPLIER_0 * c.x,
        );
        k += vec2<u32>(KEY_STEP_0, KEY_STEP_1);
    }
    return c;
}

// The logarithm of (word + 1/2) / 2^32.
fn logarithm(word: u32) -> real {
    let bits = firstLeadingBit(word | 1u);
    var part = (real(word) + 0.5) / real(1u << bits);
    var power = real(bits) - 32.0;
    if part > 1.5 {
        part *= 0.5;
        power += 1.0;
    } else if part < 0.75 {
        part *= 2.0;
        power -= 1.0;
    }
    let s = (part - 1.0) / (part + 1.0);
    var sum = real(0.0);
    for (var k = 11; k >= 0; k -= 1) {
        sum = 1.0 / real(2 * k + 1) + s * s * sum;
    }
    return power * LOGARITHM_OF_TWO + 2.0 * s * sum;
}

fn normal_pair(radius: u32, angle: u32) -> vec2r {
    // Rounding may make the logarithm of the largest words positive.
    let length = sqrt(max(-2.0 * logarithm(radius), real(0.0)));
    let quarter = (angle >> 30u) + ((angle >> 29u) & 1u);
    let x = real(bitcast<i32>(angle - (quarter << 30u))) * (TURN / 4294967296.0);
    var sine = real(1.0);
    var cosine = real(1.0);
    for (var k = 8; k > 0; k -= 1) {
        let n = real(2 * k);
        sine = 1.0 - x * x / (n * (n + 1.0)) * sine;
        cosine = 1.0 - x * x / ((n - 1.0) * n) * cosine;
    }
    sine *= x;
    switch quarter & 3u {
        case 0u: { return length * vec2r(cosine, sine); }
        case 1u: { return length * vec2r(-sine, cosine); }
        case 2u: { return length * vec2r(-cosine, -sine); }
        default: { return length * vec2r(sine, -cosine); }
    }
}
