// The separations of bodies from surfaces, place by place, after those of pairs: the same three vectors, and flags at
// the same limits, with the cutoff plus the motion of the body at the step's start. The normal is always the present
// one.

var<storage, read> pairs: array<vec2<u32>>;
var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> shapes: array<vec4r>;
var<storage, read> boxes: array<vec4r>;
var<storage, read> surfaces: array<vec4r>;
var<storage, read_write> contacts: array<vec4r>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = parameters.first + invocation(group, groups, local);
    if p >= parameters.pairs { return; }
    let i = pairs[p].x;
    let body = placed(shapes[i], orientations[2u * i], orientations[2u * i + 1u]);
    let surface = surface_at(surface_of(pairs[p].y));
    let offset = offset_from(surface, cells[i].xyz, remainders[i].xyz);
    let found = separate_place(surface, offset, body, place_of(pairs[p].y));
    var limit = real(0.0);
    if parameters.at_trial == 0u {
        limit = max(boxes[i].w - bounding_radius(body), 0.0) + 0.5 * CUTOFF;
    }
    var flag = FAR;
    if found.separation <= limit {
        flag = select(NEAR, VIOLATING, found.separation < -real(parameters.violating));
    }
    contacts[3u * p] = vec4r(found.normal, found.separation);
    contacts[3u * p + 1u] = vec4r(found.lever_a, contacts[3u * p + 1u].w);
    contacts[3u * p + 2u] = vec4r(found.lever_b, flag);
}
