// Bretherton's constants about the body's axes in a viscous fluid, as in src/dynamics/drag/fluid. The resistances are
// those of `drag_fluid.wgsl`.
fn bretherton(shape: vec4r) -> vec3r {
    switch u32(shape.w) {
        case SPHERE: { return vec3r(); }
        case SPHEROCYLINDER: {
            let x = shape.x / shape.y;
            if x >= 1.0 { return vec3r(); }
            let s = rod_of(0.5 * shape.x, 0.5 * shape.y).s;
            let far = ROD_TUMBLING_0.x * (1.0 / s - 1.0) + ROD_TUMBLING_0.y * (1.0 - s);
            let near = (1.0 - x) * (ROD_TUMBLING.x + x * (ROD_TUMBLING.y + x * ROD_TUMBLING.z));
            let square = x * x * (1.0 + far + near);
            let constant = (1.0 - square) / (1.0 + square);
            return vec3r(-constant, constant, 0.0);
        }
        case ELLIPSOID: {
            let s = shape.yzx;
            let t = shape.zxy;
            return (s - t) * (s + t) / (s * s + t * t);
        }
        case TORUS: {
            let e = shape.y / shape.x;
            let l = log_of(8.0 / e);
            let square = e * e * (0.75 * l + ring_sum(RING_TUMBLING_0, RING_TUMBLING, e, l));
            let constant = (square - 1.0) / (square + 1.0);
            return vec3r(-constant, constant, 0.0);
        }
        default: { return vec3r(not_a_number()); }
    }
}
