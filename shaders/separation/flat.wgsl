// The climb to the largest f(n) = n . delta - h_a(n) - h_b(n) over unit normals, for bodies that are flat in places, as
// in src/separation/flat.rs: a step tries Newton's normal, and those that the bodies have at the points that Newton's
// step moves to. At the end the points are moved to where they meet along the normal, those of each body by how flat
// it is; where that is not on the surfaces, by the shares of the gap that are.
//
// In 32 bits the rounding of a normal moves the point of a flat place of exponent 10 by a sixth of its size, and hides
// where the points would meet. So a step is shortened while the slope shows that its normals may gain, and if none
// gains while the points are far from each other, normals along the gap between them are tried: without these two of
// 2,000 pairs with faces nearly on each other ended 5e-5 of the size too low.

// The largest number of steps.
const PEAK_ROUNDS: u32 = 400u;
// Longest step across the normal: 45 degrees once projected back.
const LONGEST_STEP: real = 1.0;
// The factor by which a failed step is shortened.
const SHORTEN: real = 0.25;
// How far off the surface a point may be moved to meet the other, as a part of the way to it.
const OFF: real = 1e-4;
// The shares of the gap between the points that the second one's is moved by.
const SHARES: u32 = 5u;
// Points this far from each other across the normal, as a part of the sizes, are far.
const FAR_GAP: real = 1e-4;
// The normals along the gap that are tried.
const PUSHES: u32 = 12u;
// The starts along and between a body's axes, and those at its edges and corners.
const AROUND: u32 = 26u;
const STARTS: u32 = 2u * AROUND;

// A body about the origin with its axes in space, as columns.
struct Posed {
    norm: Norm,
    axes: mat3r,
}

// A normal, f there, and the bodies' points with that outward normal.
struct Peak {
    normal: vec3r,
    value: real,
    point_a: vec3r,
    point_b: vec3r,
}

// A tangent basis and the Hessians in it, as (11, 12, 22).
struct Hessians {
    e1: vec3r,
    e2: vec3r,
    of_a: vec3r,
    of_b: vec3r,
}

fn posed(p: Placed) -> Posed {
    return Posed(norm_of(p.kind, p.sizes), body_axes(p.orientation));
}

// A body without size.
fn at_a_point() -> Posed {
    let zero = vec3r(0.0, 0.0, 0.0);
    return Posed(Norm(zero, vec2r(2.0, 2.0), vec2r(1.0, 1.0), 0.0, 0.0), mat3r(zero, zero, zero));
}

fn has_size(body: Posed) -> bool {
    return body.norm.size > 0.0;
}

// The point of a body with this outward normal, and how far it reaches along it.
fn support_at(body: Posed, normal: vec3r) -> vec4r {
    if !has_size(body) { return vec4r(); }
    let found = support_of_norm(body.norm, normal * body.axes);
    return vec4r(body.axes * found.xyz, found.w);
}

fn peak_at(delta: vec3r, a: Posed, b: Posed, normal: vec3r) -> Peak {
    let of_a = support_at(a, normal);
    let of_b = support_at(b, normal);
    return Peak(normal, dot(normal, delta) - of_a.w - of_b.w, of_a.xyz, of_b.xyz);
}

fn forms(bends: Bends, axes: mat3r, e1: vec3r, e2: vec3r) -> vec3r {
    let u = e1 * axes;
    let v = e2 * axes;
    return vec3r(bend_along(bends, u, u), bend_along(bends, u, v), bend_along(bends, v, v));
}

// The Hessians in the basis of the principal axes of their sum, where the smaller one keeps its digits.
fn hessians_at(a: Posed, b: Posed, normal: vec3r) -> Hessians {
    let tangents = orthonormal_pair(normal);
    let bends_a = bends_of(a.norm, normal * a.axes);
    var bends_b: Bends;
    if has_size(b) { bends_b = bends_of(b.norm, normal * b.axes); }
    var found = Hessians(tangents.first, tangents.second, vec3r(), vec3r());
    var turn = vec2r(1.0, 0.0);
    for (var pass_of = 0u; pass_of < 2u; pass_of += 1u) {
        found.e1 = tangents.first * turn.x + tangents.second * turn.y;
        found.e2 = tangents.second * turn.x - tangents.first * turn.y;
        found.of_a = forms(bends_a, a.axes, found.e1, found.e2);
        if has_size(b) { found.of_b = forms(bends_b, b.axes, found.e1, found.e2); }
        let sum = found.of_a + found.of_b;
        turn = half_turn(2.0 * sum.y, sum.x - sum.z);
    }
    return found;
}

// Newton's step from the gradient and the negated Hessian, which is shifted if it is not positive definite.
fn newton_step(g: vec2r, hessian: vec3r) -> vec2r {
    var h = hessian;
    let spread = length(vec2r(0.5 * (h.x - h.z), h.y));
    let most = 0.5 * (h.x + h.z) + spread;
    let least = select(most - 2.0 * spread, (h.x * h.z - h.y * h.y) / most, most > 0.0);
    if !(least > 0.0) {
        let shift = EPSILON * spread + length(g) - least;
        h += vec3r(shift, 0.0, shift);
    }
    let step = vec2r(h.z * g.x - h.y * g.y, h.x * g.y - h.y * g.x) / (h.x * h.z - h.y * h.y);
    let long = length(step);
    if long <= LONGEST_STEP { return step; }
    return select(g / length(g), step / long, long <= HUGE) * LONGEST_STEP;
}

// How a body's point moves with the normal.
fn moved_by(of_body: vec3r, at: Hessians, step: vec2r) -> vec3r {
    return at.e1 * (of_body.x * step.x + of_body.y * step.y) + at.e2 * (of_body.y * step.x + of_body.z * step.y);
}

// The outward normal of the body where the ray from its centre through a point leaves it. Without one: `otherwise`.
fn normal_through(body: Posed, point: vec3r, otherwise: vec3r) -> vec3r {
    if !has_size(body) { return otherwise; }
    return unit_or(body.axes * gauge_of(body.norm, point * body.axes).normal, otherwise);
}

// How far a point is off a body's surface, as a part of the way to it.
fn off_surface(body: Posed, point: vec3r) -> real {
    if !has_size(body) { return real(0.0); }
    return abs(gauge_of(body.norm, point * body.axes).part - 1.0);
}

// Whether a point is on a body's surface.
fn is_on(body: Posed, point: vec3r) -> bool {
    return off_surface(body, point) <= OFF;
}

fn gap_across(delta: vec3r, peak: Peak) -> vec3r {
    let gap = delta - peak.point_a - peak.point_b;
    return gap - peak.normal * dot(gap, peak.normal);
}

// Ascends from `start` (a unit vector) to a local maximum. Each round tries the three normals of a step, a step that
// gained nothing shortened, or normals along the gap; the first round the start.
fn climb(delta: vec3r, a: Posed, b: Posed, start: vec3r) -> Peak {
    let size = length(delta) + a.norm.size + b.norm.size;
    var peak: Peak;
    peak.value = -HUGE;
    var at: Hessians;
    var step = vec2r(0.0, 0.0);
    var gap = vec3r(0.0, 0.0, 0.0);
    var fraction = real(0.0);
    var pushes = false;
    for (var round = 0u; round < PEAK_ROUNDS; round += 1u) {
        if fraction == 1.0 && !pushes {
            gap = gap_across(delta, peak);
            if length(gap) <= GRADIENT_FLOOR * size { break; }
            at = hessians_at(a, b, peak.normal);
            let g = vec2r(dot(gap, at.e1), dot(gap, at.e2));
            step = newton_step(g, at.of_a + at.of_b + vec3r(peak.value, 0.0, peak.value));
        }
        var best = peak;
        var gain = real(0.0);
        let tries = select(select(3u, PUSHES, pushes), 1u, round == 0u);
        for (var k = 0u; k < tries; k += 1u) {
            var normal = start;
            if pushes {
                normal = normalize(peak.normal + gap * (fraction / length(gap)));
                fraction *= SHORTEN;
            } else if round > 0u {
                normal = normalize(peak.normal + (at.e1 * step.x + at.e2 * step.y) * fraction);
                if k > 0u {
                    normal = normal_moved(a, b, peak, at, step * fraction, k == 2u, normal);
                }
            }
            let tried = peak_at(delta, a, b, normal);
            if tried.value > best.value { best = tried; }
            gain = max(gain, dot(gap, normal - peak.normal));
        }
        if best.value > peak.value + GAIN * size {
            peak = best;
            fraction = 1.0;
            pushes = false;
        } else {
            // By the slope no shorter step can gain more.
            let ends = !(gain > VALUE_FLOOR * size);
            if pushes || ends && !(length(gap) > FAR_GAP * size) { return met(a, b, peak, gap, at); }
            pushes = ends;
            fraction = select(fraction * SHORTEN, 1.0, ends);
        }
    }
    return peak;
}

// The normal of one of the bodies at the point that a step moves to.
fn normal_moved(a: Posed, b: Posed, peak: Peak, at: Hessians, step: vec2r, second: bool, otherwise: vec3r) -> vec3r {
    var body = a;
    var point = peak.point_a + moved_by(at.of_a, at, step);
    if second {
        body = b;
        point = peak.point_b + moved_by(at.of_b, at, step);
    }
    return normal_through(body, point, otherwise);
}

// The peak with its points moved across the normal by the gap to where they meet, if that is on the surfaces.
fn met(a: Posed, b: Posed, peak: Peak, gap: vec3r, at: Hessians) -> Peak {
    let g = vec2r(dot(gap, at.e1), dot(gap, at.e2));
    let h = at.of_a + at.of_b;
    let step = vec2r(h.z * g.x - h.y * g.y, h.x * g.y - h.y * g.x) / (h.x * h.z - h.y * h.y);
    let move_b = moved_by(at.of_b, at, step);
    // What rounding leaves is the first one's.
    let point_a = peak.point_a + (gap - move_b);
    let point_b = peak.point_b + move_b;
    if is_on(a, point_a) && is_on(b, point_b) { return Peak(peak.normal, peak.value, point_a, point_b); }
    return met_by_shares(a, b, peak, gap);
}

// The peak with its points moved by the shares of the gap that leave them nearest to the surfaces, if on them.
fn met_by_shares(a: Posed, b: Posed, peak: Peak, gap: vec3r) -> Peak {
    var best = peak;
    var least = OFF;
    for (var k = 0u; k < select(1u, SHARES, has_size(b)); k += 1u) {
        // Half first, then a quarter to each side, then all.
        let share = vec3r(0.5, 0.25, 0.0)[(k + 1u) / 2u];
        let of_b = select(real(0.0), select(share, 1.0 - share, k % 2u == 0u), has_size(b));
        let moved = Peak(peak.normal, peak.value, peak.point_a + gap * (1.0 - of_b), peak.point_b + gap * of_b);
        let off = max(off_surface(a, moved.point_a), off_surface(b, moved.point_b));
        if off < least {
            least = off;
            best = moved;
        }
    }
    return best;
}

// A fixed start of a body: towards a side, an edge or a corner of a cube along its axes; then the normals at its own
// edges and corners. Zero for none.
fn start_of(body: Posed, k: u32) -> vec3r {
    let middle = AROUND / 2u;
    let number = k % AROUND + select(0u, 1u, k % AROUND >= middle);
    let digits = vec3<u32>(number % 3u, number / 3u % 3u, number / 9u);
    let u = vec3r(digits) - vec3r(1.0, 1.0, 1.0);
    if k < AROUND { return body.axes * normalize(u); }
    let radii = body.norm.radii;
    if most_of(radii) == least_of(radii) { return vec3r(); }
    return body.axes * normalize(u * (least_of(radii) / radii));
}
