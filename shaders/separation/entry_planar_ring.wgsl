// Where circles cross in the plane no normal in it is defined, and the one along z is kept.
fn separate(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let found = space_separation(delta, a, b, warm);
    if abs(found.normal.z) > OUT_OF_PLANE {
        return found;
    }
    return laid_flat(found);
}
