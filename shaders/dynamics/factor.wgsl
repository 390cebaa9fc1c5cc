// The root of a body's rotational mobility, applied to a vector. `motions` is the kernel's array of motions.
fn rotation_root(body: u32, v: vec3r) -> vec3r {
    let first = MOTION * body;
    if MOTION <= 4u {
        return motions[first + 1u].w * v;
    }
    let a = motions[first + 4u];
    let b = motions[first + 5u];
    return vec3r(
        a.x * v.x + a.y * v.y + a.z * v.z,
        a.y * v.x + a.w * v.y + b.x * v.z,
        a.z * v.x + b.x * v.y + b.y * v.z,
    );
}
