// A circle about the origin, with two directions in its plane and its normal.
struct Ring {
    radius: real,
    axes: mat3r,
}

fn ring_of(p: Placed) -> Ring {
    return Ring(p.sizes.x, body_axes(p.orientation));
}

// The unit direction, in the plane, from the centre to the circle's point nearest to `p`; the first direction if `p` is
// on the axis up to rounding.
fn ring_toward(ring: Ring, p: vec3r) -> vec3r {
    let q = ring.axes[0] * dot(ring.axes[0], p) + ring.axes[1] * dot(ring.axes[1], p);
    if !(length(q) > ROUNDING_SINE * length(p)) {
        return ring.axes[0];
    }
    return unit_or(q, ring.axes[0]);
}
