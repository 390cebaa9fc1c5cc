// The point of an ellipsoid that reaches farthest towards a surface.

// Across a cylinder's axis it projects to an ellipse; its axes are the rotated directions whose images are
// perpendicular.
fn normal_in_cylinder(surface: Surface, offset: Offset, axes: mat3r, radii: vec3r) -> vec3r {
    let e1 = surface.first.unit;
    let e2 = surface.second.unit;
    let m1 = radii * (e1 * axes);
    let m2 = radii * (e2 * axes);
    let turn = half_turn(2.0 * dot(m1, m2), dot(m1 - m2, m1 + m2));
    let first = turn.x * e1 + turn.y * e2;
    let second = turn.x * e2 - turn.y * e1;
    let seen = vec3r(length(radii * (first * axes)), length(radii * (second * axes)), 0.0);
    let p = -as_vector(offset);
    let normal = farthest_normal(seen, vec3r(dot(p, first), dot(p, second), 0.0));
    return normalize(normal.x * first + normal.y * second);
}

fn arm_of_ellipsoid(surface: Surface, offset: Offset, body: Placed, place: u32) -> Arm {
    let axes = body_axes(body.orientation);
    var normal = -surface.first.unit;
    if surface.kind == SURFACE_SPHERE {
        normal = axes * farthest_normal(body.sizes, -as_vector(offset) * axes);
    } else if surface.kind == SURFACE_CYLINDER {
        normal = normal_in_cylinder(surface, offset, axes, body.sizes);
    }
    let image = body.sizes * (normal * axes);
    return Arm(axes * (body.sizes * (image / length(image))), 0.0, place == 0u);
}
