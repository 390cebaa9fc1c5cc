// The first intersection of a line with a body, in body axes and in units of the body's size, as in
// src/render/intersect.rs.

// No hit.
const MISS: f32 = 3e38;

// Newton steps on the quartic of a ring: a tangent line halves the error with each, and a float has 24 bits.
const NEWTON_STEPS: i32 = 40;

fn hit_point(radius: f32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let along = dot(origin, direction);
    let across = origin - direction * along;
    let discriminant = radius * radius - dot(across, across);
    if discriminant < 0.0 {
        return MISS;
    }
    return -along - sqrt(discriminant);
}

fn hit_segment(half: f32, radius: f32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let square = dot(direction.xy, direction.xy);
    let moment = origin.x * direction.y - origin.y * direction.x;
    let discriminant = square * radius * radius - moment * moment;
    if square > 0.0 && discriminant < 0.0 {
        return MISS;
    }
    // Along the axis: the cap that faces the line.
    var end = select(half, -half, direction.z > 0.0);
    if square > 0.0 {
        let t = (-dot(origin.xy, direction.xy) - sqrt(discriminant)) / square;
        let z = origin.z + t * direction.z;
        if abs(z) <= half {
            return t;
        }
        end = select(half, -half, z < 0.0);
    }
    return hit_point(radius, origin - vec3<f32>(0.0, 0.0, end), direction);
}

fn hit_ellipsoid(radii: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let o = origin / radii;
    let d = direction / radii;
    let square = dot(d, d);
    let moment = cross(o, d);
    let discriminant = square - dot(moment, moment);
    if discriminant < 0.0 {
        return MISS;
    }
    return (-dot(o, d) - sqrt(discriminant)) / square;
}

// `t^4 + c.x t^2 + c.y t + c.z`.
fn quartic(c: vec3<f32>, t: f32) -> f32 {
    return ((t * t + c.x) * t + c.y) * t + c.z;
}

fn quartic_slope(c: vec3<f32>, t: f32) -> f32 {
    return (4.0 * t * t + 2.0 * c.x) * t + c.y;
}

// The least root in a convex part from `start` to `end`, with no root before `start`.
fn convex_root(c: vec3<f32>, start: f32, end: f32) -> f32 {
    var t = start;
    for (var k = 0; k < NEWTON_STEPS; k += 1) {
        let value = quartic(c, t);
        let slope = quartic_slope(c, t);
        if value <= 0.0 {
            return t;
        }
        if slope >= 0.0 {
            return MISS;
        }
        let next = t - value / slope;
        if next > end {
            return MISS;
        }
        if next == t {
            break;
        }
        t = next;
    }
    return t;
}

// The root before `start` in a concave part that ends at `start`, with a value of at most zero there.
fn concave_root(c: vec3<f32>, start: f32) -> f32 {
    var t = start;
    for (var k = 0; k < NEWTON_STEPS; k += 1) {
        let next = t - quartic(c, t) / quartic_slope(c, t);
        if !(next < t) {
            break;
        }
        t = next;
    }
    return t;
}

// The least root, given a `start` at or before it.
fn least_root(c: vec3<f32>, start: f32) -> f32 {
    if c.x >= 0.0 {
        return convex_root(c, start, MISS);
    }
    let bend = sqrt(-c.x / 6.0);
    if start < -bend {
        let root = convex_root(c, start, -bend);
        if root < MISS {
            return root;
        }
    }
    if start < bend && quartic(c, bend) <= 0.0 {
        return concave_root(c, bend);
    }
    return convex_root(c, max(start, bend), MISS);
}

fn hit_circle(major: f32, radius: f32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let along = dot(origin, direction);
    let o = origin - direction * along;
    let square = dot(o, o);
    let outer = major + radius;
    if square > outer * outer {
        return MISS;
    }
    let major2 = major * major;
    let flat = dot(direction.xy, direction.xy);
    let k = square + major2 - radius * radius;
    let c = vec3<f32>(
        2.0 * (k - 2.0 * major2 * flat),
        8.0 * major2 * o.z * direction.z,
        k * k - 4.0 * major2 * dot(o.xy, o.xy),
    );
    let root = least_root(c, -sqrt(outer * outer - square));
    return select(MISS, root - along, root < MISS);
}

// `sizes` are half the segment or the circle's radius and the radius, or the semi-axes.
fn first_hit(kind: u32, sizes: vec3<f32>, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    switch kind {
        case SPHERE: { return hit_point(sizes.y, origin, direction); }
        case SPHEROCYLINDER: { return hit_segment(sizes.x, sizes.y, origin, direction); }
        case ELLIPSOID: { return hit_ellipsoid(sizes, origin, direction); }
        case TORUS: { return hit_circle(sizes.x, sizes.y, origin, direction); }
        default: { return not_a_number(); }
    }
}

// The outward unit normal at a point of the surface.
fn normal_at(kind: u32, sizes: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    var foot = vec3<f32>(0.0);
    switch kind {
        case SPHERE: {}
        case SPHEROCYLINDER: { foot.z = clamp(point.z, -sizes.x, sizes.x); }
        case ELLIPSOID: { return normalize(point / (sizes * sizes)); }
        case TORUS: {
            if dot(point.xy, point.xy) > 0.0 {
                foot = vec3<f32>(normalize(point.xy) * sizes.x, 0.0);
            }
        }
        default: { return vec3<f32>(not_a_number()); }
    }
    return normalize(point - foot);
}
