// The load of a background shear flow on a body (src/dynamics/flow.rs has the equations): the resistance to its
// velocities at the body.
fn flow_load(position: vec3r, q: vec4r, shape: vec4r) -> Load {
    let d = rotate_back(q, FLOW_DIRECTION);
    let e = rotate_back(q, FLOW_GRADIENT);
    let strain = 0.5 * FLOW_RATE * (d.yzx * e.zxy + e.yzx * d.zxy);
    let turning = FLOW_TURNING + rotate(q, bretherton(shape) * strain);
    let length = major_axis(shape);
    let resistance = DRAG * length;
    var force = resistance * FLOW_RATE * dot(position, FLOW_GRADIENT) * FLOW_DIRECTION;
    var torque = resistance * length * length / 12.0 * turning;
    if PLANAR {
        force.z = 0.0;
        torque = vec3r(0.0, 0.0, torque.z);
    }
    return Load(force, torque);
}
