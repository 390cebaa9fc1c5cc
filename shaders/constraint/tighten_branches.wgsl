// Moves the offset of the first row of each staged contact, so that the row is exact at the trial, as tighten.wgsl
// does; marks contacts whose row moved.

struct Parameters { places: u32, bodies: u32, b: u32, c: u32, dt: real, root_dt: real }

@group(0) @binding(0) var<uniform> parameters: Parameters;
@group(0) @binding(1) var<storage, read> staged: array<vec4r>;
@group(0) @binding(2) var<storage, read> row_pairs: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> jacobian: array<vec4r>;
@group(0) @binding(4) var<storage, read> velocities: array<vec4r>;
@group(0) @binding(5) var<storage, read> motions: array<vec4r>;
@group(0) @binding(6) var<storage, read_write> q: array<real>;
@group(0) @binding(7) var<storage, read_write> partners: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let place = invocation(group, groups, local);
    if place >= parameters.places || partners[place] == 0u { return; }
    let row = partners[place] - 1u;
    let contact = staged[3u * place];
    let a = share(row, 0u, row_pairs[row].x, -contact.xyz, staged[3u * place + 1u].xyz);
    // A surface's block is zero. In rows surfaces come after all bodies.
    var b = Share(real(0.0), real(0.0), real(0.0), real(0.0));
    if row_pairs[row].y < parameters.bodies {
        b = share(row, 1u, row_pairs[row].y, contact.xyz, staged[3u * place + 2u].xyz);
    }
    let g = q[row] + (a.g + b.g);
    let aligned = a.both + b.both > LEAST_ALIGNED * sqrt((a.own + b.own) * (a.there + b.there));
    if aligned && contact.w < g {
        q[row] += contact.w - g;
        partners[place] = NONE;
    }
}
