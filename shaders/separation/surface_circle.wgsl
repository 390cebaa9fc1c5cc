// A ring touches a plane or a sphere in three places: the farthest point, and those a third of the circle to either
// side; a cylinder only in the first.

const THIRD_COSINE: real = -0.5;
const THIRD_SINE: real = 0.86602540378443864676;

// The direction of a circle's farthest point towards a cylinder: across the axis the circle projects to an ellipse, as
// wide as the circle, and as high as its tilt towards the axis.
fn across_cylinder(surface: Surface, offset: Offset, ring: Ring) -> vec3r {
    let axis = cross(surface.first.unit, surface.second.unit);
    let lean = abs(dot(ring.axes[2], axis));
    // A ring coaxial with the cylinder up to rounding projects to a circle, equally wide in all directions.
    let wide = unit_or(normal_to(axis, ring.axes[2]), surface.first.unit);
    let high = cross(axis, wide);
    let p = as_vector(offset) / -ring.radius;
    let normal = farthest_normal(vec3r(1.0, lean, 0.0), vec3r(dot(p, wide), dot(p, high), 0.0));
    return normal.x * wide + normal.y * high;
}

fn arm_of_circle(surface: Surface, offset: Offset, body: Placed, place: u32) -> Arm {
    let ring = ring_of(body);
    var toward = -surface.first.unit;
    if surface.kind == SURFACE_SPHERE {
        toward = as_vector(offset);
    } else if surface.kind == SURFACE_CYLINDER {
        toward = across_cylinder(surface, offset, ring);
    }
    // In the plane of the ring, so that the point is on it even if a flat ring determines the direction badly.
    let seen = vec2r(dot(toward, ring.axes[0]), dot(toward, ring.axes[1]));
    let size = length(seen);
    var at = vec2r(1.0, 0.0);
    if size > ROUNDING_SINE * length(toward) {
        at = seen / size;
    }
    if place > 0u {
        let sine = select(THIRD_SINE, -THIRD_SINE, place == 2u);
        at = vec2r(THIRD_COSINE * at.x - sine * at.y, sine * at.x + THIRD_COSINE * at.y);
    }
    let arm = ring.radius * (at.x * ring.axes[0] + at.y * ring.axes[1]);
    return Arm(arm, tube_radius(body), place == 0u || (place < 3u && surface.kind != SURFACE_CYLINDER));
}
