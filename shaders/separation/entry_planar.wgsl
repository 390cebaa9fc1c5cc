fn separate(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let found = space_separation(delta, a, b, warm);
    if abs(found.normal.z) > OUT_OF_PLANE {
        return in_plane_normal(delta, a, b);
    }
    return laid_flat(found);
}
