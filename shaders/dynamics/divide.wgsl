// Divisions: a mother becomes the daughter at its lower end; the one at its upper end has a new index. The host
// determines which cells divide, and their random rotations.

// Three vectors per division: (mother, upper daughter, coarse length, fine length), and the rotations of both
// daughters.
var<storage, read> divisions: array<vec4r>;
var<storage, read> indices: array<vec2<u32>>;
var<storage, read_write> cells: array<vec4<i32>>;
var<storage, read_write> remainders: array<vec4r>;
var<storage, read_write> orientations: array<vec4r>;
var<storage, read_write> shapes: array<vec4r>;
var<storage, read_write> lengths: array<vec2r>;
var<storage, read_write> twists: array<vec4r>;

fn place(body: u32, cell: vec3<i32>, remainder: vec3r, shift: vec3r) {
    let moved = lattice_add(cell, remainder, shift);
    cells[body] = vec4<i32>(moved.cell, 0);
    remainders[body] = vec4r(moved.remainder, 0.0);
}

fn turn(body: u32, q: vec4r, by: vec4r) {
    // In the plane turns are about z of space, else about an axis across the body's own.
    var turned: vec4r;
    if PLANAR {
        turned = quaternion_product(by, q);
    } else {
        turned = quaternion_product(q, by);
    }
    let kept = orientation_add(Orientation(vec4r(), vec4r()), normalize(turned));
    orientations[2u * body] = kept.coarse;
    orientations[2u * body + 1u] = kept.fine;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let i = invocation(group, groups, local);
    if i >= parameters.divisions { return; }
    let mother = indices[i].x;
    let upper = indices[i].y;
    let q = unit_quaternion(orientations[2u * mother], orientations[2u * mother + 1u]);
    let length = lengths[mother].x + lengths[mother].y;
    var offset = rotate(q, daughter_offset(length));
    if PLANAR {
        offset.z = 0.0;
    }
    let cell = cells[mother].xyz;
    let remainder = remainders[mother].xyz;
    place(mother, cell, remainder, -offset);
    place(upper, cell, remainder, offset);
    turn(mother, q, divisions[3u * i + 1u]);
    turn(upper, q, divisions[3u * i + 2u]);
    let half = divisions[3u * i].xy;
    let shape = with_length(shapes[mother], half.x + half.y);
    shapes[mother] = shape;
    shapes[upper] = shape;
    lengths[mother] = half;
    lengths[upper] = half;
    let velocity = twists[2u * mother].xyz;
    let angular = twists[2u * mother + 1u].xyz;
    twists[2u * mother] = vec4r(velocity - cross(angular, offset), 0.0);
    twists[2u * upper] = vec4r(velocity + cross(angular, offset), 0.0);
    twists[2u * upper + 1u] = vec4r(angular, 0.0);
}
