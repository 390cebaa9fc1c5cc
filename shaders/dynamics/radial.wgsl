// The paper's radial field x (|x| - sin |x|) / |x|^2.

const TAU: real = 6.28318530717958647692;

// Below this radius the series replaces the difference, which would lose its digits.
const SERIES_RADIUS: real = 0.5;

// The sine by Taylor's series within a quarter turn: no shader language has one of known accuracy in every precision.
fn sine(x: real) -> real {
    let turns = floor(x / TAU + 0.5);
    var r = x - turns * TAU;
    r = select(r, 0.5 * TAU - r, r > 0.25 * TAU);
    r = select(r, -0.5 * TAU - r, r < -0.25 * TAU);
    let s = r * r;
    var sum = real(1.0);
    for (var k = 10; k > 0; k -= 1) {
        sum = 1.0 - s / real((2 * k) * (2 * k + 1)) * sum;
    }
    return r * sum;
}

fn radial(x: vec3r) -> vec3r {
    let r = length(x);
    if r < SERIES_RADIUS {
        let s = r * r;
        return x * r * (1.0 / 6.0 - s / 120.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0 * (1.0 - s / 156.0)))));
    }
    return x * ((r - sine(r)) / (r * r));
}
