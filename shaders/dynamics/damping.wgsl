// The part of a body's motion that remains after a time under drag, with inertia (src/dynamics/damping.rs has the
// equations).

struct Damping { kept: real, share: real, turn_kept: vec3r, turn_share: vec3r }

// From here on e^-a is zero in every precision.
const MOST_DAMPED: real = 1000.0;

// 1 - e^-a: by its series up to a half, and by doubling.
fn lost(a: real) -> real {
    var x = min(a, MOST_DAMPED);
    var halvings = 0u;
    while x > 0.5 {
        x *= 0.5;
        halvings += 1u;
    }
    var sum = real(1.0);
    for (var k = 15; k > 1; k -= 1) {
        sum = 1.0 - x / real(k) * sum;
    }
    var part = x * sum;
    for (var k = 0u; k < halvings; k += 1u) {
        part *= 2.0 - part;
    }
    return part;
}

fn share_of(a: real) -> real {
    if a > 0.0 { return lost(a) / a; }
    return 1.0;
}

fn damping(shape: vec4r, time: real) -> Damping {
    let body = solid(shape);
    let length = major_axis(shape);
    let a = time * DRAG * length / (DENSITY * body.volume);
    let b = time * DRAG * length * length * length / 12.0 / (DENSITY * body.inertia);
    return Damping(
        1.0 - lost(a),
        share_of(a),
        vec3r(1.0 - lost(b.x), 1.0 - lost(b.y), 1.0 - lost(b.z)),
        vec3r(share_of(b.x), share_of(b.y), share_of(b.z)),
    );
}

// Scales an angular vector, in space axes, by these factors about the body's axes.
fn parts_of(q: vec4r, parts: vec3r, v: vec3r) -> vec3r {
    return rotate(q, parts * rotate_back(q, v));
}
