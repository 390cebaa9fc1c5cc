// The load of the flow of a cell whose lengths change on a body (src/dynamics/strain.rs has the equations): the
// resistance to its velocities at the body.
fn strain_load(position: vec3r, q: vec4r, shape: vec4r) -> Load {
    let rates = parameters.strain;
    let x = rotate_back(q, vec3r(1.0, 0.0, 0.0));
    let y = rotate_back(q, vec3r(0.0, 1.0, 0.0));
    let z = rotate_back(q, vec3r(0.0, 0.0, 1.0));
    let strain = rates.x * x.yzx * x.zxy + rates.y * y.yzx * y.zxy + rates.z * z.yzx * z.zxy;
    let length = major_axis(shape);
    let resistance = DRAG * length;
    var force = resistance * rates * position;
    var torque = resistance * length * length / 12.0 * rotate(q, bretherton(shape) * strain);
    if PLANAR {
        force.z = 0.0;
        torque = vec3r(0.0, 0.0, torque.z);
    }
    return Load(force, torque);
}
