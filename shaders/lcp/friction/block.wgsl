// The small problem of a contact, argmin over y in K of g . (y - x) + 1/2 (y - x) . B (y - x), solved exactly as in
// src/lcp/friction/block.rs, whose head has the equations. It returns y - x. `base` is where a contact's data begin in
// `units`: B and its inverse, six numbers each, the three vectors of its basis, each with its number of the spectrum,
// and its rows of J.

fn unit_base(row: u32) -> u32 { return row * UNIT_WORDS; }

fn times_block(base: u32, x: vec3r) -> vec3r {
    let a = units[base];
    let b = units[base + 1u];
    return vec3r(dot(a.xyz, x), dot(vec3r(a.y, a.w, b.x), x), dot(vec3r(a.z, b.x, b.y), x));
}

fn times_inverse(base: u32, x: vec3r) -> vec3r {
    let b = units[base + 1u];
    let c = units[base + 2u];
    return vec3r(dot(vec3r(b.z, b.w, c.x), x), dot(vec3r(b.w, c.y, c.z), x), dot(c.xzw, x));
}

// The solution where it lies on the boundary and is not zero, with g = c at zero.
fn on_boundary(base: u32, mu: real, c: vec3r) -> vec3r {
    let v = units[base + 3u];
    let v1 = units[base + 4u];
    let v2 = units[base + 5u];
    let p = v.w;
    let a = vec2r(v1.w, v2.w);
    let h = dot(v.xyz, c);
    let across = vec2r(dot(v1.xyz, c), dot(v2.xyz, c));
    let b = a * across * across;
    let top = sqrt(p) * abs(h);
    let first = h < 0.0;
    let limit = select(p, real(1.0), first);
    let slope_of_bound = select(real(1.0), p, first);
    var l = real(0.0);
    for (var round = 0u; round < MOST_ROUNDS; round += 1u) {
        let d = select(vec2r(l) + a, vec2r(1.0) + l * a, first);
        let q = b / (d * d);
        let root = 1.0 / sqrt(max(q.x + q.y, TINY));
        let r = select(vec2r(1.0), a, first) / d;
        let slope = top * root * root * root * dot(q, r) + slope_of_bound;
        let step = (limit - l * slope_of_bound - top * root) / slope;
        l += max(step, real(0.0));
        if !(step > CONVERGED * l) { break; }
    }
    let part = select(vec2r(l) / (vec2r(l) + a), vec2r(1.0) / (vec2r(1.0) + l * a), first);
    let z = -across * part;
    let up = sqrt((a.x * z.x * z.x + a.y * z.y * z.y) / p);
    return friction_project(up * v.xyz + z.x * v1.xyz + z.y * v2.xyz, mu);
}

fn contact_change(base: u32, mu: real, x: vec3r, g: vec3r) -> vec3r {
    let step = times_inverse(base, g);
    if friction_contains(x - step, mu) { return -step; }
    if mu == 0.0 { return vec3r(max(-g.x / units[base].x, -x.x), -x.y, -x.z); }
    let c = g - times_block(base, x);
    if friction_dual_contains(c, mu) { return -x; }
    return on_boundary(base, mu, c) - x;
}
