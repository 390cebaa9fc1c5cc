// The largest distance of near bodies where first rows are made: the cutoff, the rest of their relative free motion,
// and the motion of both surfaces by rotation.

var<storage, read> motions: array<vec4r>;

// The rest of a body's free velocity: of its centre, or of its rotation.
fn left_of(body: u32, part: u32) -> vec3r {
    return motions[MOTION * body + part].xyz - motions[MOTION * body + 2u + part].xyz;
}

fn near_limit(a: u32, b: u32, radius_a: real, radius_b: real) -> real {
    let apart = length(left_of(b, 0u) - left_of(a, 0u));
    return CUTOFF + parameters.dt * (apart + length(left_of(a, 1u)) * radius_a + length(left_of(b, 1u)) * radius_b);
}

// The value that a near pair keeps beside the lever of its first body: the limit, until its branches with rows are
// known.
fn kept(p: u32, limit: real) -> real {
    return limit;
}
