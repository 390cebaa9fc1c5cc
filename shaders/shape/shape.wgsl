// The encoding of shapes: (first size, second, third, tag), as in src/shape/code.rs.

const PI: real = 3.14159265358979323846;

// Volume and principal moments of inertia per unit density of the solid.
struct Solid { volume: real, inertia: vec3r }

fn solid(shape: vec4r) -> Solid {
    let x = shape.x;
    let y = shape.y;
    switch u32(shape.w) {
        case SPHERE: {
            let volume = 4.0 / 3.0 * PI * x * x * x;
            return Solid(volume, vec3r(0.4 * volume * x * x));
        }
        case SPHEROCYLINDER: {
            // A cylinder and a ball in two halves, each moved outwards by half the cylinder's height.
            let r = 0.5 * x;
            let h = y - x;
            let cylinder = PI * r * r * h;
            let ball = 4.0 / 3.0 * PI * r * r * r;
            let axial = cylinder * 0.5 * r * r + ball * 0.4 * r * r;
            let across = cylinder * (h * h / 12.0 + 0.25 * r * r) + ball * (0.4 * r * r + 0.25 * h * h + 0.375 * h * r);
            return Solid(cylinder + ball, vec3r(across, across, axial));
        }
        case ELLIPSOID: {
            let volume = 4.0 / 3.0 * PI * x * y * shape.z;
            let s = shape.xyz * shape.xyz;
            return Solid(volume, 0.2 * volume * (s.yzx + s.zxy));
        }
        case TORUS: {
            let volume = 2.0 * PI * PI * x * y * y;
            let axial = volume * (x * x + 0.75 * y * y);
            let across = volume * (0.5 * x * x + 0.625 * y * y);
            return Solid(volume, vec3r(across, across, axial));
        }
        default: { return Solid(not_a_number(), vec3r(not_a_number())); }
    }
}

// The largest extent: the length L of the local drag law.
fn major_axis(shape: vec4r) -> real {
    switch u32(shape.w) {
        case SPHERE: { return 2.0 * shape.x; }
        case SPHEROCYLINDER: { return shape.y; }
        case ELLIPSOID: { return 2.0 * max(shape.x, max(shape.y, shape.z)); }
        case TORUS: { return 2.0 * (shape.x + shape.y); }
        default: { return not_a_number(); }
    }
}

// The axis of revolution of a shape, in body axes; zero for a sphere and for a shape without one.
fn axis_of_revolution(shape: vec4r) -> vec3r {
    switch u32(shape.w) {
        case SPHEROCYLINDER, TORUS: { return vec3r(0.0, 0.0, 1.0); }
        case ELLIPSOID: {
            let equal = shape.xyz == shape.yzx;
            if equal.x && !equal.y { return vec3r(0.0, 0.0, 1.0); }
            if equal.y && !equal.z { return vec3r(1.0, 0.0, 0.0); }
            if equal.z && !equal.x { return vec3r(0.0, 1.0, 0.0); }
            return vec3r();
        }
        case SPHERE: { return vec3r(); }
        default: { return vec3r(not_a_number()); }
    }
}

fn grows(shape: vec4r) -> bool {
    return u32(shape.w) == SPHEROCYLINDER;
}

fn with_length(shape: vec4r, length: real) -> vec4r {
    return vec4r(shape.x, length, shape.zw);
}

// The vector from the centre to the centre of the upper daughter of half the length, in body axes.
fn daughter_offset(length: real) -> vec3r {
    return vec3r(0.0, 0.0, 0.25 * length);
}
