// The velocity of b's image nearest to a relative to b itself, in a sheared cell.
fn image_velocity(a: u32, b: u32) -> vec3r {
    let apart = vec3r(cells[b].xyz - cells[a].xyz) * PITCH + (remainders[b].xyz - remainders[a].xyz);
    let delta = lattice_difference(cells[a].xyz, remainders[a].xyz, cells[b].xyz, remainders[b].xyz);
    var velocity = vec3r();
    velocity[SHEAR_DIRECTION] = SHEAR_RATE * (delta[SHEAR_GRADIENT] - apart[SHEAR_GRADIENT]);
    return velocity;
}
