// Functions of a single body of any shape, with superellipsoids; the others' are in body.wgsl.

fn bounding_radius(p: Placed) -> real {
    if !is_superellipsoid(p.kind) { return bounding_radius_of_others(p); }
    return radius_about(p.sizes, exponents_of(p.kind).exponents);
}

fn thickness(p: Placed) -> real {
    if !is_superellipsoid(p.kind) { return thickness_of_others(p); }
    return 2.0 * least_of(p.sizes);
}

fn half_extents(p: Placed) -> vec3r {
    if !is_superellipsoid(p.kind) { return half_extents_of_others(p); }
    let norm = norm_of(p.kind, p.sizes);
    // The axes of space in the body's.
    let to_body = transpose(body_axes(p.orientation));
    return vec3r(
        parts_of_norm(norm, to_body[0]).height,
        parts_of_norm(norm, to_body[1]).height,
        parts_of_norm(norm, to_body[2]).height,
    );
}

fn hull(p: Placed, n: vec3r) -> real {
    if !is_superellipsoid(p.kind) { return hull_of_others(p, n); }
    return parts_of_norm(norm_of(p.kind, p.sizes), n * body_axes(p.orientation)).height;
}
