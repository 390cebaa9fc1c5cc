// Directions at right angles, and half an angle, without trigonometry.

struct DirectionPair {
    first: vec3r,
    second: vec3r,
}

// An orthonormal pair at right angles to a unit vector (T. Duff and others, "Building an orthonormal basis, revisited",
// 2017).
fn orthonormal_pair(n: vec3r) -> DirectionPair {
    let side = select(real(1.0), real(-1.0), n.z < 0.0);
    let c = -1.0 / (side + n.z);
    let d = n.x * n.y * c;
    return DirectionPair(
        vec3r(1.0 + side * n.x * n.x * c, side * d, -side * n.x),
        vec3r(d, side + n.y * n.y * c, -n.y),
    );
}

// Cosine and sine of half the angle of the vector (x, y), from -pi/2 to pi/2. The vector is scaled first: squares of
// numbers such as 1e-22 have few digits, or none.
fn half_turn(y: real, x: real) -> vec2r {
    let scale = max(abs(x), abs(y));
    if !(scale > TINY) {
        return vec2r(1.0, 0.0);
    }
    let part = abs(vec2r(x, y)) / scale;
    let size = length(part);
    let large = sqrt(0.5 + 0.5 * part.x / size);
    let small = 0.5 * part.y / (size * large);
    let side = select(real(1.0), real(-1.0), y < 0.0);
    return select(vec2r(small, side * large), vec2r(large, side * small), x >= 0.0);
}
