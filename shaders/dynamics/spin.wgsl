// The rotation of a body without torque in a step: the midpoint rule that conserves its angular momentum and its energy
// (src/dynamics/spin.rs has the equation and its source). Moments of inertia are over the first one, and so are angular
// momenta: a ball's is its angular velocity. In the plane bodies turn steadily about one axis: their moments are
// relative to that about it.

// The largest number of Newton iterations.
const MOST_ITERATIONS: u32 = 10u;

fn moments_of(shape: vec4r) -> vec3r {
    if PLANAR { return vec3r(1.0); }
    let m = solid(shape).inertia;
    // A quotient of equal numbers need not be one on every device.
    if m.x == m.y && m.x == m.z { return vec3r(1.0); }
    return vec3r(1.0, m.y / m.x, m.z / m.x);
}

// Whether all moments are equal, so that the body turns steadily.
fn is_even(moments: vec3r) -> bool {
    return all(moments == vec3r(1.0));
}

fn momentum_of(moments: vec3r, q: vec4r, velocity: vec3r) -> vec3r {
    if is_even(moments) { return velocity; }
    return rotate(q, moments * rotate_back(q, velocity));
}

fn velocity_of(moments: vec3r, q: vec4r, momentum: vec3r) -> vec3r {
    if is_even(moments) { return momentum; }
    return rotate(q, rotate_back(q, momentum) / moments);
}

// The angular momentum of a state, and its stored form: the momentum itself, so that it is never rounded, or the
// angular velocity.
fn momentum_kept(moments: vec3r, q: vec4r, kept: vec3r) -> vec3r {
    if KEEPS_MOMENTUM { return kept; }
    return momentum_of(moments, q, kept);
}

fn kept_of(moments: vec3r, q: vec4r, momentum: vec3r) -> vec3r {
    if KEEPS_MOMENTUM { return momentum; }
    let velocity = velocity_of(moments, q, momentum);
    // Rounding errors have a bias: the stored velocity is the one from which the next step computes this momentum.
    return velocity + velocity_of(moments, q, momentum - momentum_of(moments, q, velocity));
}

// The constant angular velocity that turns the body through a step of `dt` without torque.
fn turning_of(moments: vec3r, q: vec4r, momentum: vec3r, dt: real) -> vec3r {
    if is_even(moments) { return momentum; }
    let start = rotate_back(q, momentum) / moments;
    let k = 0.5 * dt * (moments.zxy - moments.yzx) / moments;
    var w = start;
    for (var n = 0u; n < MOST_ITERATIONS; n += 1u) {
        let off = w - start + k * w.yzx * w.zxy;
        let x = vec3r(1.0, k.y * w.z, k.z * w.y);
        let y = vec3r(k.x * w.z, 1.0, k.z * w.x);
        let z = vec3r(k.x * w.y, k.y * w.x, 1.0);
        let across = cross(y, z);
        let step = vec3r(dot(off, across), dot(x, cross(off, z)), dot(x, cross(y, off))) / dot(x, across);
        w -= step;
        let size = max(abs(w.x), max(abs(w.y), abs(w.z)));
        if max(abs(step.x), max(abs(step.y), abs(step.z))) <= LAST_STEP * size {
            return rotate(q, w);
        }
    }
    return rotate(q, start);
}
