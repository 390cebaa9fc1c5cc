// Fixed directions for normals that geometry leaves open, and the separation of two curves from their nearest points.

struct Nearest {
    from_a: vec3r,
    to_b: vec3r,
    normal: vec3r,
    distance: real,
}

// The separation of two curves thickened by these radii.
fn thickened(n: Nearest, radius_a: real, radius_b: real) -> Separation {
    return Separation(n.distance - (radius_a + radius_b), n.normal, n.from_a + n.normal * radius_a, n.to_b - n.normal * radius_b);
}

// `v` at unit length, or `other` where `v` is too short to have a direction.
fn unit_or(v: vec3r, other: vec3r) -> vec3r {
    let size = length(v);
    if size * size > 16.0 * TINY {
        return v / size;
    }
    return other;
}

// A unit vector at right angles to `v`: `v` crossed with the axis of space that it leans on least, the first of equals.
// The x axis where `v` is zero.
fn perpendicular(v: vec3r) -> vec3r {
    let size = abs(v);
    var least = vec3r(0.0, 0.0, 1.0);
    if size.x <= size.y && size.x <= size.z {
        least = vec3r(1.0, 0.0, 0.0);
    } else if size.y <= size.z {
        least = vec3r(0.0, 1.0, 0.0);
    }
    return unit_or(cross(v, least), vec3r(1.0, 0.0, 0.0));
}

// A unit vector at right angles to both; where they are parallel, one at right angles to the longer.
fn common_perpendicular(u: vec3r, v: vec3r) -> vec3r {
    let across = cross(u, v);
    let sine = length(across);
    // Ten roundings: below, the cross product of unit vectors holds no digit.
    if sine > 10.0 * EPSILON {
        return across / sine;
    }
    if dot(u, u) >= dot(v, v) {
        return perpendicular(u);
    }
    return perpendicular(v);
}

// The unit vector from one curve to the other, given the gap between their nearest points and their directions there.
// Where curves cross (`inside`: away from their ends) it is their common perpendicular, turned with `toward`; where
// they meet otherwise, a fixed one.
fn normal_between(u: vec3r, v: vec3r, gap: vec3r, distance: real, size: real, toward: vec3r, inside: bool) -> vec3r {
    let across = cross(u, v);
    let sine = length(across);
    if inside && distance < MEETING * size * sine {
        let unit = across / sine;
        return select(unit, -unit, dot(toward, unit) < 0.0);
    }
    if distance > EPSILON * size {
        return gap / distance;
    }
    return common_perpendicular(u, v);
}
