// The axis of a body of revolution where forces act, at the start of a step or in its middle, about which contact
// cannot turn it, in two numbers of its motion: the axis intersects an octahedron twice, and these are x and y of the
// upper point. `motions` is the kernel's array of motions.

// The first number of a body without such an axis.
const NO_AXIS: real = 2.0;

fn axis_numbers(axis: vec3r) -> vec2r {
    let size = abs(axis.x) + abs(axis.y) + abs(axis.z);
    if size == 0.0 { return vec2r(NO_AXIS, 0.0); }
    let on = axis / size;
    return select(on.xy, -on.xy, on.z < 0.0);
}

// The axis of a body. It is zero for a body without an axis of revolution.
fn axis_of(body: u32) -> vec3r {
    let x = motions[MOTION * body + 2u].w;
    let y = motions[MOTION * body + 3u].w;
    if x == NO_AXIS { return vec3r(); }
    return normalize(vec3r(x, y, 1.0 - abs(x) - abs(y)));
}
