// Orientations have a coarse part, a multiple of TURN_PITCH that is exact in a float, and a fine part below half of it,
// so that rotations far smaller than the rounding of a quaternion accumulate over steps. Their sum is a quaternion of
// length one to a few roundings.

const TURN_PITCH: real = 9.5367431640625e-7; // 2^-20
const TURNS: real = 1048576.0;

fn unit_quaternion(coarse: vec4r, fine: vec4r) -> vec4r {
    return normalize(coarse + fine);
}

struct Orientation { coarse: vec4r, fine: vec4r }

// Adds a change to the fine part and moves whole pitches over to the coarse one. Every operation on the coarse part is
// exact.
fn orientation_add(q: Orientation, change: vec4r) -> Orientation {
    let fine = q.fine + change;
    let whole = floor(fine * TURNS + vec4r(0.5));
    return Orientation(q.coarse + whole * TURN_PITCH, fine - whole * TURN_PITCH);
}

// normalize(q + dt/2 (0, w) (x) q) for the half turn h = dt w / 2, as a change of q that is small where h is.
fn orientation_advance(q: Orientation, h: vec3r) -> Orientation {
    let unit = q.coarse + q.fine;
    let turn = quaternion_product(vec4r(h, 0.0), unit);
    let h2 = dot(h, h);
    let root = sqrt(1.0 + h2);
    var change = turn / root - unit * (h2 / (root * (1.0 + root)));
    let drift = dot(unit, unit) - 1.0;
    // Some roundings of a quaternion's length.
    if abs(drift) > 8.0 * EPSILON {
        change -= 0.5 * drift * unit;
    }
    return orientation_add(q, change);
}
