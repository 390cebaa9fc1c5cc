// The friction cone K = { |t| <= mu n } of a contact, and its dual: the functions of src/lcp/friction/cone.rs. A
// contact's numbers are its normal one and its two tangential ones, of which the second is zero in the plane.

// The length of the tangential part. Squares of small numbers are zero.
fn tangential(x: vec3r) -> real {
    let size = max(abs(x.y), abs(x.z));
    if !(size > 0.0) { return size; }
    let part = x.yz / size;
    return size * sqrt(part.x * part.x + part.y * part.y);
}

fn friction_contains(x: vec3r, mu: real) -> bool { return x.x >= 0.0 && tangential(x) <= mu * x.x; }
fn friction_dual_contains(g: vec3r, mu: real) -> bool { return mu * tangential(g) <= g.x; }

// The nearest point of K.
fn friction_project(x: vec3r, mu: real) -> vec3r {
    let t = tangential(x);
    if x.x >= 0.0 && t <= mu * x.x { return x; }
    if mu * t <= -x.x { return vec3r(); }
    let n = (x.x + mu * t) / (1.0 + mu * mu);
    let part = mu * n / t;
    return vec3r(n, part * x.y, part * x.z);
}

// Numbers from elsewhere as multipliers: zeros where one is not finite, else the nearest ones.
fn friction_admit(x: vec3r, mu: real) -> vec3r {
    if is_finite(x.x) && is_finite(x.y) && is_finite(x.z) { return friction_project(x, mu); }
    return vec3r();
}

fn is_on_boundary(x: vec3r, t: real, mu: real) -> bool { return t > 0.0 && mu * x.x - t <= ON_BOUNDARY * t; }

// The displacement d from x to x + d, both in K. Along the boundary its normal number is made from the tangential ones:
// it would have little but their rounding.
fn friction_displacement(x: vec3r, d: vec3r, mu: real) -> vec3r {
    let y = x + d;
    let start = tangential(x);
    let end = tangential(y);
    if mu > 0.0 && is_on_boundary(x, start, mu) && is_on_boundary(y, end, mu) {
        let rise = (2.0 * x.y + d.y) * d.y + (2.0 * x.z + d.z) * d.z;
        return vec3r(rise / ((start + end) * mu), d.y, d.z);
    }
    return d;
}

// How far x is from a solution of K contains x _|_ g in K*, a length, with s a mean diagonal entry of A.
fn friction_residual(x: vec3r, g: vec3r, mu: real, s: real) -> real {
    // Comparisons may lose what is not finite.
    if !is_finite(x.x + x.y + x.z + g.x + g.y + g.z) { return not_a_number(); }
    let scaled = s * x;
    let moved = scaled - friction_project(scaled - g, mu);
    let size = max(abs(moved.x), max(abs(moved.y), abs(moved.z)));
    if !(size > 0.0) { return size; }
    let part = moved / size;
    return size * sqrt(dot(part, part));
}

fn friction_form(x: vec3r, y: vec3r, mu: real) -> real { return mu * mu * x.x * y.x - (x.y * y.y + x.z * y.z); }

// The first t >= 0 at which x + t d leaves K, for x in it up to rounding.
fn first_root(x: vec3r, d: vec3r, mu: real) -> real {
    // With c + 2 b t + a t^2, which is not negative inside.
    let c = max(friction_form(x, x, mu), real(0.0));
    let b = friction_form(x, d, mu);
    let a = friction_form(d, d, mu);
    let discriminant = b * b - a * c;
    var root = HUGE;
    if a < 0.0 {
        let sum = sqrt(max(discriminant, real(0.0))) + abs(b);
        if b >= 0.0 { root = sum / -a; } else { root = c / sum; }
    } else if b < 0.0 && discriminant >= 0.0 {
        root = c / (sqrt(discriminant) - b);
    }
    if d.x < 0.0 { root = min(root, max(x.x / -d.x, real(0.0))); }
    return root;
}

// The largest t with x + t d in K, for x in it. For a displacement to a point of K at least 1.
fn friction_room(x: vec3r, d: vec3r, mu: real) -> real {
    let sizes = max(abs(x), abs(d));
    let size = max(sizes.x, max(sizes.y, sizes.z));
    if !(size > 0.0) { return HUGE; }
    let start = x / size;
    let step = d / size;
    let end = start + step;
    let n = abs(start.x) + abs(step.x);
    let t = tangential(start) + tangential(step);
    let within = end.x >= -ROUNDING * n && tangential(end) - mu * end.x <= ROUNDING * (mu * n + t);
    if within { return 1.0 + first_root(end, step, mu); }
    return first_root(start, step, mu);
}
