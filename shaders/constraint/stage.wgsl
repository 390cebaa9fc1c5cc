// The contacts of the branches in each pair's mask, at the last positions of the pair's range of rows: (normal,
// separation), (lever of a, 0), (lever of b, one and the branch's number). The last number is zero at the other
// positions of the range.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> contacts: array<vec4r>;
var<storage, read> row_start: array<u32>;
var<storage, read_write> staged: array<vec4r>;

fn body_at(i: u32) -> Placed {
    return placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
}

fn stage(row: u32, k: u32, found: Separation) {
    staged[3u * row] = vec4r(found.normal, found.separation);
    staged[3u * row + 1u] = vec4r(found.lever_a, 0.0);
    staged[3u * row + 2u] = vec4r(found.lever_b, real(k + 1u));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let mask = u32(contacts[3u * p + 1u].w);
    let first = row_start[p + 1u] - countOneBits(mask);
    for (var old = row_start[p]; old < first; old += 1u) {
        staged[3u * old + 2u] = vec4r();
    }
    if mask == 0u { return; }
    var row = first;
    let contact = contacts[3u * p];
    if (mask & WHOLE) > 0u {
        stage(row, 0u, Separation(contact.w, contact.xyz, contacts[3u * p + 1u].xyz, contacts[3u * p + 2u].xyz));
        row += 1u;
    }
    if !BRANCHED || mask == WHOLE { return; }
    let a = pairs[p].x;
    let b = pairs[p].y;
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    let body_a = body_at(a);
    let body_b = body_at(b);
    for (var k = 1u; k < BRANCHES; k += 1u) {
        if (mask & (1u << k)) == 0u { continue; }
        stage(row, k, branch_separation(delta, body_a, body_b, contact.w, k));
        row += 1u;
    }
}
