// The point of a superellipsoid that reaches farthest towards a surface. In a sphere or a cylinder it is the one
// farthest from the centre or the axis: the largest n . d + h(n), with d from there to the body's centre. At a normal n
// with the point y, the normal along d + y is higher, so that this repeated climbs to a maximum; the starts are fixed.

// The largest number of repetitions.
const FARTHEST_ROUNDS: u32 = 400u;
const ROUND: u32 = 32u;
const ROUND_COSINE: real = 0.98078528040323044913;
const ROUND_SINE: real = 0.19509032201612826785;

// The normal, in space, at the point of the body about `d` farthest from the origin, or from the line along `axis` if
// that is not zero.
fn farthest_of(d: vec3r, body: Posed, axis: vec3r) -> vec3r {
    let around_line = dot(axis, axis) > 0.0;
    let size = length(d) + body.norm.size;
    let first = perpendicular(axis);
    let second = cross(axis, first);
    var turn = vec2r(1.0, 0.0);
    var best = vec4r(vec3r(1.0, 0.0, 0.0), -HUGE);
    for (var k = 0u; k < select(STARTS + 1u, ROUND, around_line); k += 1u) {
        var start = unit_or(d, vec3r(1.0, 0.0, 0.0));
        if around_line {
            start = normalize(first * turn.x + second * turn.y);
        } else if k > 0u {
            start = start_of(body, k - 1u);
        }
        turn = vec2r(turn.x * ROUND_COSINE - turn.y * ROUND_SINE, turn.y * ROUND_COSINE + turn.x * ROUND_SINE);
        if dot(start, start) == 0.0 { continue; }
        var normal = start;
        var peak = vec4r(start, -HUGE);
        for (var round = 0u; round < FARTHEST_ROUNDS; round += 1u) {
            let found = support_at(body, normal);
            let value = dot(normal, d) + found.w;
            if !(value > peak.w + GAIN * size) { break; }
            peak = vec4r(normal, value);
            var out = d + found.xyz;
            out -= axis * dot(axis, out);
            normal = unit_or(out, normal);
        }
        if peak.w > best.w + TIE * size { best = peak; }
    }
    return best.xyz;
}

fn arm_of_superellipsoid(surface: Surface, offset: Offset, p: Placed, place: u32) -> Arm {
    let body = posed(p);
    var normal = -surface.first.unit;
    if surface.kind == SURFACE_SPHERE {
        normal = farthest_of(as_vector(offset), body, vec3r());
    } else if surface.kind == SURFACE_CYLINDER {
        normal = farthest_of(as_vector(offset), body, cross(surface.first.unit, surface.second.unit));
    }
    return Arm(support_at(body, normal).xyz, 0.0, place == 0u);
}
