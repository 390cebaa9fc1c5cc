// Shared by the searches for a normal in the plane: a body's outline in the plane, its contact points, and the order of
// equal maxima.

// A body's outline: support function |reach . n| + |g1 n.x + g2 n.y| + radius.
struct Outline {
    reach: vec2r,
    radius: real,
    g1: vec3r,
    g2: vec3r,
}

fn outline_of(p: Placed) -> Outline {
    let zero = vec3r(0.0, 0.0, 0.0);
    if p.kind == ELLIPSOID {
        let rows = transpose(body_axes(p.orientation));
        return Outline(vec2r(0.0, 0.0), real(0.0), p.sizes * rows[0], p.sizes * rows[1]);
    }
    return Outline(body_z(p.orientation).xy * half_segment(p), tube_radius(p), zero, zero);
}

fn outline_height(o: Outline, n: vec2r) -> real {
    return abs(dot(o.reach, n)) + length(o.g1 * n.x + o.g2 * n.y) + o.radius;
}

// Whether a segment is at right angles to the normal, and touches along its length.
fn is_free(p: Placed, normal: vec3r) -> bool {
    return p.kind == SPHEROCYLINDER && abs(dot(body_z(p.orientation), normal)) < RIGHT_ANGLE;
}

// The point of the body with this outward normal; the middle of a segment at right angles.
fn support_point(p: Placed, normal: vec3r) -> vec3r {
    if p.kind == ELLIPSOID {
        let axes = body_axes(p.orientation);
        let scaled = p.sizes * (normal * axes);
        return axes * (p.sizes * (scaled / length(scaled)));
    }
    let axis = body_z(p.orientation);
    let half = half_segment(p);
    let end = select(select(half, -half, dot(axis, normal) < 0.0), real(0.0), is_free(p, normal));
    return axis * end + normal * tube_radius(p);
}

// The contact point of a segment at right angles is its point nearest to the other's.
fn free_point(p: Placed, normal: vec3r, other: vec3r) -> vec3r {
    let axis = body_z(p.orientation);
    let half = half_segment(p);
    return axis * clamp(dot(other, axis), -half, half) + normal * tube_radius(p);
}

// The separation at a normal in the plane.
fn separation_along(delta: vec3r, a: Placed, b: Placed, n: vec2r, value: real) -> Separation {
    let normal = vec3r(n, 0.0);
    var lever_a = support_point(a, normal);
    var lever_b = support_point(b, -normal);
    if is_free(a, normal) { lever_a = free_point(a, normal, delta + lever_b); }
    if is_free(b, normal) { lever_b = free_point(b, -normal, lever_a - delta); }
    return Separation(value, normal, lever_a, lever_b);
}

// Whether `n` precedes `m` in angle from the x axis.
fn is_earlier(n: vec2r, m: vec2r) -> bool {
    let lower_n = n.y < 0.0 || n.y == 0.0 && n.x < 0.0;
    let lower_m = m.y < 0.0 || m.y == 0.0 && m.x < 0.0;
    if lower_n != lower_m { return lower_m; }
    return n.x * m.y - n.y * m.x > 0.0;
}

// Whether a value at `n` beats the best, at `m`: among equals the first in angle.
fn is_better(value: real, n: vec2r, best: real, m: vec2r, tie: real) -> bool {
    return value > best + tie || value >= best - tie && is_earlier(n, m);
}
