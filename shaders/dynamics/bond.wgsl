// The extension of a bond (src/dynamics/bonds has the equations). Its points are given in body axes, with the stiffness
// after the first and the length after the second.

var<storage, read> cells: array<vec4<i32>>;
var<storage, read> remainders: array<vec4r>;
var<storage, read> orientations: array<vec4r>;
var<storage, read> bonds: array<vec4r>;
var<storage, read> ends: array<vec2<u32>>;

// From a body's centre to its point of a bond, space axes.
fn arm_of(point: vec3r, body: u32) -> vec3r {
    return rotate(unit_quaternion(orientations[2u * body], orientations[2u * body + 1u]), point);
}

// From the first point of a bond to the other.
fn way_of(bond: u32) -> vec3r {
    let a = ends[bond].x;
    let b = ends[bond].y;
    let apart = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    return apart + (arm_of(bonds[2u * bond + 1u].xyz, b) - arm_of(bonds[2u * bond].xyz, a));
}
