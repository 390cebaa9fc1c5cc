// Two rods in the plane: between the normals at right angles to a rod, the function is that of the distance between two
// ends, n . v, largest along v. The maximum is among the four such v and the four normals at right angles.
fn in_plane_normal(delta: vec3r, a: Placed, b: Placed) -> Separation {
    let body_a = outline_of(a);
    let body_b = outline_of(b);
    let tie = TIE * (length(delta) + bounding_radius(a) + bounding_radius(b));
    var best = -HUGE;
    var normal = vec2r(1.0, 0.0);
    for (var i = 0u; i < 8u; i += 1u) {
        let side = select(real(1.0), real(-1.0), (i & 1u) == 1u);
        var reach = body_a.reach;
        if (i & 2u) == 2u { reach = body_b.reach; }
        var v = vec2r(-reach.y, reach.x) * side;
        if i >= 4u {
            v = delta.xy + body_a.reach * side + body_b.reach * select(real(1.0), real(-1.0), (i & 2u) == 2u);
        }
        let size = length(v);
        if !(size > tie) { continue; }
        let n = v / size;
        let value = dot(n, delta.xy) - outline_height(body_a, n) - outline_height(body_b, n);
        if is_better(value, n, best, normal, tie) {
            best = value;
            normal = n;
        }
    }
    // Degenerate case: two concentric rods as long as thick have no such normal; the first normal is used.
    if best == -HUGE { best = dot(normal, delta.xy) - outline_height(body_a, normal) - outline_height(body_b, normal); }
    return separation_along(delta, a, b, normal, best);
}
