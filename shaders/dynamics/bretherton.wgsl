// Bretherton's constants about the body's axes, as in src/shape.
fn bretherton(shape: vec4r) -> vec3r {
    switch u32(shape.w) {
        case SPHERE: { return vec3r(); }
        case SPHEROCYLINDER: {
            if shape.x == shape.y { return vec3r(); }
            return vec3r(-1.0, 1.0, 0.0);
        }
        case ELLIPSOID: {
            let s = shape.yzx;
            let t = shape.zxy;
            return (s - t) * (s + t) / (s * s + t * t);
        }
        case TORUS: { return vec3r(1.0, -1.0, 0.0); }
        default: { return vec3r(not_a_number()); }
    }
}
