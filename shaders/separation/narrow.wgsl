// The separations of candidate pairs within a limit: `near_limit` for first rows, zero at the trial. Far pairs are
// skipped as cheaply as possible.
//
// A pair's contact is three vectors: (normal, separation), (lever of a, what is `kept`), (lever of b, flag). The flag
// is FAR, NEAR (within the limit) or VIOLATING (overlapping by more than `violating`). The normal of a far pair is the
// last computed one. If the pair had no row in the last accepted step, it depends on when the pair was listed: it is
// only the first direction to test, and no search starts from it. It has the separation `ONLY_DIRECTION`.
//
// A far pair at the trial has its separation instead of the lever of b; if this exceeds the part GAP of its thinner
// body's thickness, any number between the two suffices.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read_write> contacts: array<vec4r>;
var<storage, read_write> report: Report;

fn tell_far(p: u32, separation: real) {
    if parameters.at_trial > 0u { contacts[3u * p + 2u] = vec4r(separation, 0.0, 0.0, FAR); }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    // If the list is not complete, this pass is repeated with another list, from the same start.
    if p >= parameters.pairs || atomicLoad(&report.outside) > 0u { return; }
    let a = pairs[p].x;
    let b = pairs[p].y;
    if !is_of_families(u32(shapes[a].w), u32(shapes[b].w)) { return; }
    contacts[3u * p + 2u].w = FAR;
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    let body_a = placed(shapes[a], orientations[2u * a], orientations[2u * a + 1u]);
    let body_b = placed(shapes[b], orientations[2u * b], orientations[2u * b + 1u]);
    let radius_a = bounding_radius(body_a);
    let radius_b = bounding_radius(body_b);
    var limit = real(0.0);
    var look = GAP * min(thickness(body_a), thickness(body_b));
    if parameters.at_trial == 0u {
        limit = near_limit(a, b, radius_a, radius_b);
        look = limit;
    }
    let before = contacts[3u * p];
    let distance2 = dot(delta, delta);
    let reach = radius_a + radius_b + look;
    // Rounding may make the reach slightly too short.
    if distance2 > reach * reach * (1.0 + 16.0 * EPSILON) {
        tell_far(p, sqrt(distance2) - (radius_a + radius_b));
        return;
    }
    var warm = before.xyz;
    var direction = before.xyz;
    let has_direction = dot(before.xyz, before.xyz) > 0.0;
    if before.w == ONLY_DIRECTION { warm = vec3r(0.0); }
    if !has_direction {
        // Concentric bodies have no first direction to test.
        direction = vec3r(0.0, 0.0, 1.0);
        if distance2 > 0.0 {
            direction = delta / sqrt(distance2);
        }
    }
    let least = bound(delta, body_a, body_b, direction);
    if least > look + 16.0 * EPSILON * reach {
        tell_far(p, least);
        return;
    }
    let found = separate(delta, body_a, body_b, warm);
    if !(found.separation <= limit) {
        let known = before.w != ONLY_DIRECTION && has_direction;
        contacts[3u * p] = vec4r(found.normal, select(ONLY_DIRECTION, found.separation, known));
        tell_far(p, found.separation);
        return;
    }
    contacts[3u * p] = vec4r(found.normal, found.separation);
    contacts[3u * p + 1u] = vec4r(found.lever_a, kept(p, limit));
    contacts[3u * p + 2u] = vec4r(found.lever_b, select(NEAR, VIOLATING, found.separation < -real(parameters.violating)));
}
