// The root of a body's translational mobility where drag depends on the direction: the last two vectors of its motion.
// `motions` is the kernel's array of motions.

// Applies it to a vector.
fn translation_root(body: u32, v: vec3r) -> vec3r {
    let first = MOTION * body + MOTION - 2u;
    let a = motions[first];
    let b = motions[first + 1u];
    let moved = vec3r(
        a.x * v.x + a.y * v.y + a.z * v.z,
        a.y * v.x + a.w * v.y + b.x * v.z,
        a.z * v.x + b.x * v.y + b.y * v.z,
    );
    if PLANAR {
        return vec3r(moved.xy, 0.0);
    }
    return moved;
}
