// Makes the rows of all staged contacts: the affine inequality of append.wgsl, each with the number of its branch and whether it is a first row.

struct Parameters { pairs: u32, first: u32, bodies: u32, c: u32, dt: real, root_dt: real }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> row_start: array<u32>;
@group(0) @binding(3) var<storage, read> staged: array<vec4r>;
@group(0) @binding(4) var<storage, read> motions: array<vec4r>;
@group(0) @binding(5) var<storage, read_write> row_pairs: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> jacobian: array<vec4r>;
@group(0) @binding(7) var<storage, read_write> q: array<real>;
@group(0) @binding(8) var<storage, read_write> features: array<u32>;

fn append(row: u32, pair: vec2<u32>) {
    let contact = staged[3u * row];
    let a = part(pair.x, -contact.xyz, staged[3u * row + 1u].xyz);
    // A surface does not move: its block is zero. In rows surfaces come after all bodies.
    var second = pair.y;
    var b = Part(vec3r(), vec3r(), real(0.0));
    if is_surface(second) {
        second = parameters.bodies + surface_of(second);
    } else {
        b = part(second, contact.xyz, staged[3u * row + 2u].xyz);
    }
    row_pairs[row] = vec2<u32>(pair.x, second);
    if PLANAR {
        jacobian[2u * row] = vec4r(a.linear.xy, a.angular.z, 0.0);
        jacobian[2u * row + 1u] = vec4r(b.linear.xy, b.angular.z, 0.0);
    } else {
        jacobian[4u * row] = vec4r(a.linear, 0.0);
        jacobian[4u * row + 1u] = vec4r(a.angular, 0.0);
        jacobian[4u * row + 2u] = vec4r(b.linear, 0.0);
        jacobian[4u * row + 3u] = vec4r(b.angular, 0.0);
    }
    q[row] = contact.w + (a.still_to_come + b.still_to_come);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    for (var row = row_start[p]; row < row_start[p + 1u]; row += 1u) {
        let made = u32(staged[3u * row + 2u].w);
        if made == 0u { continue; }
        append(row, pairs[p]);
        features[row] = (made - 1u) | select(0u, FIRST_ROW, parameters.first > 0u);
    }
}
