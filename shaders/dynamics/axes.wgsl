// What acts on vectors, in space axes, along the axes of a body.

struct Resistance { linear: vec3r, turning: vec3r }

fn along_axes(q: vec4r, factors: vec3r, v: vec3r) -> vec3r {
    return rotate(q, factors * rotate_back(q, v));
}

fn axes_matrix(q: vec4r, values: vec3r) -> mat3r {
    let x = rotate(q, vec3r(1.0, 0.0, 0.0));
    let y = rotate(q, vec3r(0.0, 1.0, 0.0));
    let z = rotate(q, vec3r(0.0, 0.0, 1.0));
    return mat3r(
        values.x * x.x * x + values.y * y.x * y + values.z * z.x * z,
        values.x * x.y * x + values.y * y.y * y + values.z * z.y * z,
        values.x * x.z * x + values.y * y.z * y + values.z * z.z * z,
    );
}
