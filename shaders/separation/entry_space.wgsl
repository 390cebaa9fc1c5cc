fn separate(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    return space_separation(delta, a, b, warm);
}
