// The dual norm of a superellipsoid, its support function, and its gauge, as in src/shape/superellipsoid/norm.rs. An
// ellipsoid is one of exponents 2. Everything is in the body's axes.

// The least part of a norm that its second derivatives are taken at.
const LEAST_PART: real = 1e-9;

// Semi-axes, all zero for a point; the exponents n and 1 / (n - 1); what is under every radius of curvature; and the
// radius of the smallest sphere about it.
struct Norm {
    radii: vec3r,
    exponents: vec2r,
    less: vec2r,
    roundness: real,
    size: real,
}

// The parts of the norm of one vector: `q` of x and y in that of both, `r` of both and of z in the whole.
struct Parts {
    height: real,
    q: vec2r,
    r: vec2r,
}

fn is_superellipsoid(kind: u32) -> bool {
    return (kind & TAG_BITS) == SUPERELLIPSOID;
}

// By Hoelder's inequality (x^q + y^q)^(1/q) of the largest extents with 1/q = 1/2 - 1/n.
fn farther_of(a: real, b: real, n: real) -> real {
    if !(n > 2.0) { return max(a, b); }
    return norm_of_two(a, b, 2.0 * n / (n - 2.0));
}

fn radius_about(radii: vec3r, exponents: vec2r) -> real {
    return farther_of(farther_of(radii.x, radii.y, exponents.y), radii.z, exponents.x);
}

fn least_of(v: vec3r) -> real {
    return min(v.x, min(v.y, v.z));
}

fn most_of(v: vec3r) -> real {
    return max(v.x, max(v.y, v.z));
}

// Stretched from the body of equal semi-axes, the least radius of curvature is at least that times the one of the
// ellipsoid with its semi-axes: a ball inside becomes that ellipsoid.
fn norm_of(kind: u32, radii: vec3r) -> Norm {
    let known = exponents_of(kind);
    let least = least_of(radii);
    let roundness = known.roundness * least * least / most_of(radii);
    return Norm(radii, known.exponents, known.less, roundness, radius_about(radii, known.exponents));
}

fn parts_of_norm(norm: Norm, n: vec3r) -> Parts {
    let v = norm.radii * abs(n);
    let across = norm_of_two(v.x, v.y, 1.0 + norm.less.y);
    let height = max(norm_of_two(across, v.z, 1.0 + norm.less.x), TINY);
    var q = vec2r(1.0, 0.0);
    if across > 0.0 { q = v.xy / across; }
    return Parts(height, q, vec2r(across, v.z) / height);
}

fn with_signs(v: vec3r, n: vec3r) -> vec3r {
    return select(v, -v, n < vec3r(0.0, 0.0, 0.0));
}

// The surface point whose outward normal is `n`, and how far the body reaches along it.
fn support_of_norm(norm: Norm, n: vec3r) -> vec4r {
    let parts = parts_of_norm(norm, n);
    let sides = vec2r(power(parts.q.x, norm.less.y), power(parts.q.y, norm.less.y));
    let outward = vec3r(power(parts.r.x, norm.less.x) * sides, power(parts.r.y, norm.less.x));
    return vec4r(with_signs(norm.radii * outward, n), parts.height);
}

// The second derivatives of the support function at a normal, from which each of its forms follows: of the whole in the
// norm across and z, of that norm in x and y, and its first ones.
struct Bends {
    scale: vec3r,
    of_both: vec3r,
    own: vec3r,
    slope: vec2r,
    weight: real,
    less: real,
    height: real,
}

fn steep(x: real, less: real) -> real {
    return power(max(x, LEAST_PART), less - 1.0);
}

fn bends_of(norm: Norm, n: vec3r) -> Bends {
    let parts = parts_of_norm(norm, n);
    let q = parts.q;
    let r = parts.r;
    let l1 = norm.less.x;
    let l2 = norm.less.y;
    let slope = vec2r(power(q.x, l2), power(q.y, l2));
    let steep_r = vec2r(steep(r.x, l1), steep(r.y, l1));
    let of_both = vec3r(steep_r.x * power(r.y, 1.0 + l1), power(r.x * r.y, l1), steep_r.y * power(r.x, 1.0 + l1));
    let own = vec3r(steep(q.x, l2) * power(q.y, 1.0 + l2), slope.x * slope.y, steep(q.y, l2) * power(q.x, 1.0 + l2));
    return Bends(with_signs(norm.radii, n), of_both, own, slope, steep_r.x * l2, l1, parts.height);
}

// The second derivative along `u` and `v`.
fn bend_along(bends: Bends, u: vec3r, v: vec3r) -> real {
    let a = bends.scale * u;
    let b = bends.scale * v;
    let sa = dot(bends.slope, a.xy);
    let sb = dot(bends.slope, b.xy);
    let whole = bends.of_both.x * sa * sb - bends.of_both.y * (sa * b.z + sb * a.z) + bends.of_both.z * a.z * b.z;
    let flat_part = bends.own.x * a.x * b.x - bends.own.y * (a.x * b.y + b.x * a.y) + bends.own.z * a.y * b.y;
    return (bends.less * whole + bends.weight * flat_part) / bends.height;
}

// The part of the way from the centre to the surface at which a point is, and the outward normal where the ray through
// it leaves the body; a normal of zero at the centre.
struct Gauge {
    part: real,
    normal: vec3r,
}

fn gauge_of(norm: Norm, p: vec3r) -> Gauge {
    let v = abs(p) / norm.radii;
    let across = norm_of_two(v.x, v.y, norm.exponents.y);
    let whole = norm_of_two(across, v.z, norm.exponents.x);
    if !(whole > 0.0) { return Gauge(0.0, vec3r()); }
    let out = power(across / whole, norm.exponents.x - 1.0);
    let inner = max(across, TINY);
    let sides = vec2r(power(v.x / inner, norm.exponents.y - 1.0), power(v.y / inner, norm.exponents.y - 1.0));
    let gradient = vec3r(out * sides, power(v.z / whole, norm.exponents.x - 1.0)) / norm.radii;
    return Gauge(whole, with_signs(gradient / most_of(gradient), p));
}
