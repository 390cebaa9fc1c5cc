// How far apart two bodies may be where first rows are made to be near: the cutoff, what is left of their free motion
// against each other, and what both surfaces may move by as they turn.

var<storage, read> motions: array<vec4r>;

// What is left of a body's free velocity: of its centre, or of its turn.
fn left_of(body: u32, part: u32) -> vec3r {
    return motions[MOTION * body + part].xyz - motions[MOTION * body + 2u + part].xyz;
}

fn near_limit(a: u32, b: u32, radius_a: real, radius_b: real) -> real {
    let apart = length(left_of(b, 0u) - left_of(a, 0u));
    return CUTOFF + parameters.dt * (apart + length(left_of(a, 1u)) * radius_a + length(left_of(b, 1u)) * radius_b);
}

// What a near pair keeps beside the lever of its first body: the limit, until it is known which of its branches get a
// row.
fn kept(p: u32, limit: real) -> real {
    return limit;
}
