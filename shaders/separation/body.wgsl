// Bodies with their poses, and functions of a single body or direction: boxes, bounding radii, lower bounds of
// separations. `kind` and `sizes` are a shape's code; the quaternion (x, y, z, w) rotates body axes to space.
struct Placed {
    kind: u32,
    sizes: vec3r,
    orientation: vec4r,
}

// The shared-normal signed distance of a pair (a, b): the unit normal from a to b, and the contact points, each from
// its centre.
struct Separation {
    separation: real,
    normal: vec3r,
    lever_a: vec3r,
    lever_b: vec3r,
}

// Body axes in space, as columns. Divided by the squared length, which differs from one by rounding.
fn body_axes(q: vec4r) -> mat3r {
    let twice = q * (2.0 / dot(q, q));
    let xx = q.x * twice.x;
    let yy = q.y * twice.y;
    let zz = q.z * twice.z;
    let xy = q.x * twice.y;
    let xz = q.x * twice.z;
    let yz = q.y * twice.z;
    let wx = q.w * twice.x;
    let wy = q.w * twice.y;
    let wz = q.w * twice.z;
    return mat3r(
        vec3r(1.0 - (yy + zz), xy + wz, xz - wy),
        vec3r(xy - wz, 1.0 - (xx + zz), yz + wx),
        vec3r(xz + wy, yz - wx, 1.0 - (xx + yy)),
    );
}

// The body's z in space: the axis of a rod and of a ring.
fn body_z(q: vec4r) -> vec3r {
    let twice = q * (2.0 / dot(q, q));
    return vec3r(q.x * twice.z + q.w * twice.y, q.y * twice.z - q.w * twice.x, 1.0 - (q.x * twice.x + q.y * twice.y));
}

// Half the length of a rod's segment; zero for a sphere.
fn half_segment(p: Placed) -> real {
    return select(real(0.0), 0.5 * (p.sizes.y - p.sizes.x), p.kind == SPHEROCYLINDER);
}

// The radius around a centreline; an ellipsoid has no centreline.
fn tube_radius(p: Placed) -> real {
    switch p.kind {
        case SPHERE: { return p.sizes.x; }
        case SPHEROCYLINDER: { return 0.5 * p.sizes.x; }
        case TORUS: { return p.sizes.y; }
        case ELLIPSOID, default: { return not_a_number(); }
    }
}

// Radius of the smallest sphere about the centre that contains the body.
fn bounding_radius(p: Placed) -> real {
    switch p.kind {
        case SPHERE: { return p.sizes.x; }
        case SPHEROCYLINDER: { return 0.5 * p.sizes.y; }
        case ELLIPSOID: { return max(p.sizes.x, max(p.sizes.y, p.sizes.z)); }
        case TORUS: { return p.sizes.x + p.sizes.y; }
        default: { return not_a_number(); }
    }
}

// The smallest diameter: of a ring, that of its tube.
fn thickness(p: Placed) -> real {
    if p.kind == ELLIPSOID {
        return 2.0 * min(p.sizes.x, min(p.sizes.y, p.sizes.z));
    }
    return 2.0 * tube_radius(p);
}

// Half the sizes of the smallest box along the axes of space that contains the body.
fn half_extents(p: Placed) -> vec3r {
    switch p.kind {
        case SPHERE, SPHEROCYLINDER: {
            return abs(body_z(p.orientation)) * half_segment(p) + vec3r(tube_radius(p));
        }
        case ELLIPSOID: {
            let m = body_axes(p.orientation);
            let x = m[0] * p.sizes.x;
            let y = m[1] * p.sizes.y;
            let z = m[2] * p.sizes.z;
            return sqrt(x * x + y * y + z * z);
        }
        case TORUS: {
            // From the other two components: this does not cancel if the axis is along one of space.
            let axis = body_z(p.orientation);
            let square = axis * axis;
            return sqrt(square.yzx + square.zxy) * p.sizes.x + vec3r(p.sizes.y);
        }
        default: { return vec3r(not_a_number()); }
    }
}

// Support function of the convex hull, at a unit vector.
fn hull(p: Placed, n: vec3r) -> real {
    switch p.kind {
        case SPHERE, SPHEROCYLINDER: {
            return half_segment(p) * abs(dot(body_z(p.orientation), n)) + tube_radius(p);
        }
        case ELLIPSOID: { return length(p.sizes * (n * body_axes(p.orientation))); }
        case TORUS: { return p.sizes.x * length(cross(body_z(p.orientation), n)) + p.sizes.y; }
        default: { return not_a_number(); }
    }
}

// A lower bound of the separation from one unit normal, of the convex hulls.
fn bound(delta: vec3r, a: Placed, b: Placed, normal: vec3r) -> real {
    return dot(normal, delta) - hull(a, normal) - hull(b, normal);
}
