// Moves the offset of the first row of each staged contact, so that the row is exact at the trial, as tighten.wgsl
// does; marks contacts whose row moved.

var<storage, read> staged: array<vec4r>;
var<storage, read> row_pairs: array<vec2<u32>>;
var<storage, read> jacobian: array<vec4r>;
var<storage, read> velocities: array<vec4r>;
var<storage, read> motions: array<vec4r>;
var<storage, read_write> q: array<real>;
var<storage, read_write> partners: array<u32>;

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
