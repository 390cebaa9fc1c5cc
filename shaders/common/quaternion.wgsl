// Quaternions (x, y, z, w) that take body axes to space.

fn quaternion_product(a: vec4r, b: vec4r) -> vec4r {
    return vec4r(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn rotate(q: vec4r, v: vec3r) -> vec3r {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn rotate_back(q: vec4r, v: vec3r) -> vec3r {
    return rotate(vec4r(-q.xyz, q.w), v);
}
