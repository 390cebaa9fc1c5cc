// The resistances of a body in Stokes flow (src/dynamics/drag/fluid has the equations).

// How near to each other Carlson's parameters come: the error of the series that follows is of the sixth order.
const NEAR_EQUAL: real = 1e-3;
const MOST_DUPLICATIONS: u32 = 24u;

// Carlson's R_D(x, y, z).
fn carlson(first: vec3r) -> real {
    var v = first;
    var sum = real(0.0);
    var part = real(1.0);
    var mean = 0.2 * (v.x + v.y + 3.0 * v.z);
    for (var k = 0u; k < MOST_DUPLICATIONS; k += 1u) {
        let off = abs(v - vec3r(mean));
        if max(off.x, max(off.y, off.z)) <= NEAR_EQUAL * mean { break; }
        let root = sqrt(v);
        let lambda = dot(root, root.yzx);
        sum += part / (root.z * (v.z + lambda));
        part *= 0.25;
        v = 0.25 * (v + vec3r(lambda));
        mean = 0.2 * (v.x + v.y + 3.0 * v.z);
    }
    let x = (mean - v.x) / mean;
    let y = (mean - v.y) / mean;
    let z = -(x + y) / 3.0;
    let xy = x * y;
    let zz = z * z;
    let e2 = xy - 6.0 * zz;
    let e3 = (3.0 * xy - 8.0 * zz) * z;
    let e4 = 3.0 * (xy - zz) * zz;
    let e5 = xy * zz * z;
    let series = 1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2 - 3.0 / 22.0 * e4 - 9.0 / 52.0 * e2 * e3
        + 3.0 / 26.0 * e5;
    return 3.0 * sum + part * series / (mean * sqrt(mean));
}

const LN_2: real = 0.69314718055994530942;

// An ellipsoid of these semi-axes at a viscosity of 1.
fn ellipsoid_resistance(radii: vec3r) -> Resistance {
    let scale = max(radii.x, max(radii.y, radii.z));
    let s = (radii / scale) * (radii / scale);
    let parts = s * vec3r(carlson(s.yzx), carlson(s.zxy), carlson(s)) * 2.0 / 3.0;
    let chi = parts.x + parts.y + parts.z;
    return Resistance(
        16.0 * PI * scale / (vec3r(chi) + parts),
        16.0 / 3.0 * PI * scale * scale * scale * (s.yzx + s.zxy) / (parts.yzx + parts.zxy),
    );
}

fn sphere_resistance(radius: real) -> Resistance {
    return Resistance(vec3r(6.0 * PI * radius), vec3r(8.0 * PI * radius * radius * radius));
}

// ln x for x from 1: by halving, and the series of the area tangent.
fn log_of(first: real) -> real {
    var x = first;
    var halvings = real(0.0);
    for (var k = 0u; k < 64u && x > 1.5; k += 1u) {
        x *= 0.5;
        halvings += 1.0;
    }
    let t = (x - 1.0) / (x + 1.0);
    var sum = real(0.0);
    for (var k = 23; k > 0; k -= 2) {
        sum = sum * t * t + 1.0 / real(k);
    }
    return halvings * LN_2 + 2.0 * t * sum;
}

// A rod along z of this radius and half its length, and s of its spheroid.
struct Rod { s: real, resists: Resistance }

fn rod_of(radius: real, half: real) -> Rod {
    let spheroid = ellipsoid_resistance(vec3r(radius, radius, half));
    let s = spheroid.linear.z / (6.0 * PI * half);
    let x = radius / half;
    let length = 2.0 * half;
    let along = rod_resistance(ROD_ALONG_0, ROD_ALONG, vec2r(s, x), spheroid.linear.z, 2.0 * PI * length);
    let across = rod_resistance(ROD_ACROSS_0, ROD_ACROSS, vec2r(s, x), spheroid.linear.x, 4.0 * PI * length);
    let unit = PI / 3.0 * length * length * length;
    let over = rod_resistance(ROD_OVER_0, ROD_OVER, vec2r(s, x), spheroid.turning.x, unit);
    let spinning = ROD_SPINNING.x + x * (ROD_SPINNING.y + x * ROD_SPINNING.z);
    let about = 4.0 * PI * radius * radius * length * (1.0 + x * (1.0 - x) * spinning);
    return Rod(s, Resistance(vec3r(across, across, along), vec3r(over, over, about)));
}

fn rod_resistance(first: vec2r, c: vec4r, at: vec2r, of_spheroid: real, unit: real) -> real {
    let s = at.x;
    let x = at.y;
    let slower = (1.0 - x) * (first.x + first.y * s + x * (c.x + x * (c.y + x * (c.z + x * c.w))));
    return unit / (unit / of_spheroid + slower);
}

fn ring_sum(first: vec2r, c: vec4r, e: real, l: real) -> real {
    return first.x + e * e * (first.y + e * (c.x + e * c.y) + (c.z + e * c.w) * l);
}

fn ring_resistance(major: real, minor: real) -> Resistance {
    let e = minor / major;
    let l = log_of(8.0 / e);
    let unit = PI * PI * major;
    let cube = 4.0 * unit * major * major;
    let c = RING_ACROSS;
    let flat_part = RING_ACROSS_0.x + (RING_ACROSS_0.y + c.x / l) / l;
    let across = 6.0 * unit / (l + flat_part + e * e * (c.y + c.z * e * e + c.w * l));
    let along = 8.0 * unit / (l + ring_sum(RING_ALONG_0, RING_ALONG, e, l));
    let over = cube / (l + ring_sum(RING_OVER_0, RING_OVER, e, l));
    let about = cube / (l + ring_sum(RING_ABOUT_0, RING_ABOUT, e, l));
    return Resistance(vec3r(across, across, along), vec3r(over, over, about));
}

fn resistance_of(shape: vec4r) -> Resistance {
    var of_one: Resistance;
    switch u32(shape.w) {
        case SPHERE: { of_one = sphere_resistance(shape.x); }
        case SPHEROCYLINDER: {
            if shape.y > shape.x {
                of_one = rod_of(0.5 * shape.x, 0.5 * shape.y).resists;
            } else {
                of_one = sphere_resistance(0.5 * shape.x);
            }
        }
        case ELLIPSOID: { of_one = ellipsoid_resistance(shape.xyz); }
        case TORUS: { of_one = ring_resistance(shape.x, shape.y); }
        default: { of_one = Resistance(vec3r(not_a_number()), vec3r(not_a_number())); }
    }
    return Resistance(VISCOSITY * of_one.linear, VISCOSITY * of_one.turning);
}
