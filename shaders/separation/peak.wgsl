// The largest of f(n) = n . delta - h_a(n) - h_b(n) over unit normals: Newton on the sphere, safeguarded.
//
// Across n the gradient is delta - y_a - y_b and the Hessian -(H_a + H_b) - f. It is negative definite wherever f is
// above minus the sum of the bodies' least radii of curvature, so at most one maximum is above that. A step that does
// not raise f is shortened.
//
// The tangent basis is rotated to the Hessian's principal axes, and the Hessian is computed again there: its smaller
// eigenvalue, which for slender bodies is 1e-9 of the larger, then keeps its digits. Points are those of the maximum
// itself: a last Newton step, shorter than the rounding of a normal, still moves the points of flat bodies. It does so
// to first order, and only if it is shorter than LAST_CLIMB relative to the angle over which the curvature changes.

// The largest number of tested normals. Over thousands of random poses in deep overlap none took more than 128 steps at
// aspect ratios up to 1000.
const PEAK_ROUNDS: u32 = 400u;
// Longest step across the normal: 45 degrees once projected back.
const LONGEST_STEP: real = 1.0;
// Ratio of the smallest to the largest eigenvalue below which a Hessian counts as singular: below the 1e-9 or more of
// the most slender bodies supported.
const DEFINITE: real = 1e-13;
// The factor by which a failed step is shortened.
const SHORTEN: real = 0.25;

// A normal, f there, and the bodies' points with that outward normal.
struct Peak {
    normal: vec3r,
    value: real,
    point_a: vec3r,
    point_b: vec3r,
    height_a: real,
    height_b: real,
}

fn peak_at(delta: vec3r, a: Support, b: Support, normal: vec3r) -> Peak {
    let scaled_a = a.radii * (normal * a.axes);
    let scaled_b = b.radii * (normal * b.axes);
    let height_a = max(length(scaled_a), TINY);
    let height_b = max(length(scaled_b), TINY);
    return Peak(
        normal,
        dot(normal, delta) - height_a - height_b,
        a.axes * (a.radii * (scaled_a / height_a)),
        b.axes * (b.radii * (scaled_b / height_b)),
        height_a,
        height_b,
    );
}

// Ascends from `start` (a unit vector) to a local maximum.
fn climb(delta: vec3r, a: Support, b: Support, start: vec3r) -> Peak {
    let size = length(delta) + largest(a.radii) + largest(b.radii);
    let aspect = max(aspect_of(a.radii), aspect_of(b.radii));
    var peak: Peak;
    var slope = HUGE;
    var gain = HUGE;
    var fraction = real(1.0);
    var last = false;
    var step = vec2r(0.0, 0.0);
    var e1 = vec3r(1.0, 0.0, 0.0);
    var e2 = vec3r(0.0, 1.0, 0.0);
    var normal = start;
    for (var round = 0u; round < PEAK_ROUNDS; round += 1u) {
        let next = peak_at(delta, a, b, normal);
        let gap = delta - next.point_a - next.point_b;
        let slope_there = length(gap - normal * dot(gap, normal));
        if round > 0u {
            // It raised f or, if the change of f is rounding, lowered the gradient.
            if gain * fraction > VALUE_FLOOR * size {
                if !(next.value > peak.value) {
                    fraction *= SHORTEN;
                    normal = normalize(peak.normal + (e1 * step.x + e2 * step.y) * fraction);
                    continue;
                }
            } else if !(slope_there < slope && next.value >= peak.value - VALUE_FLOOR * size) {
                break;
            }
        }
        peak = next;
        slope = slope_there;
        let tangents = orthonormal_pair(normal);
        var hessian_a: vec3r;
        var hessian_b: vec3r;
        var turn = vec2r(1.0, 0.0);
        for (var pass_of = 0u; pass_of < 2u; pass_of += 1u) {
            e1 = tangents.first * turn.x + tangents.second * turn.y;
            e2 = tangents.second * turn.x - tangents.first * turn.y;
            hessian_a = support_hessian(a, next.height_a, e1, e2);
            hessian_b = support_hessian(b, next.height_b, e1, e2);
            let sum = hessian_a + hessian_b;
            turn = half_turn(2.0 * sum.y, sum.x - sum.z);
        }
        let g = vec2r(dot(gap, e1), dot(gap, e2));
        var h = hessian_a + hessian_b + vec3r(next.value, 0.0, next.value);
        let mean = 0.5 * (h.x + h.z);
        let spread = length(vec2r(0.5 * (h.x - h.z), h.y));
        let most = mean + spread;
        // From the product of both eigenvalues; their difference from the mean would cancel.
        let least = select(mean - spread, (h.x * h.z - h.y * h.y) / most, most > 0.0);
        let definite = least > DEFINITE * spread;
        if !definite {
            let shift = DEFINITE * spread + slope - least;
            h += vec3r(shift, 0.0, shift);
        }
        let determinant = h.x * h.z - h.y * h.y;
        step = vec2r(h.z * g.x - h.y * g.y, h.x * g.y - h.y * g.x) / determinant;
        let long = length(step);
        if last || slope <= GRADIENT_FLOOR * size {
            // Curvatures minus an overlap of their size are rounding, and so is a step divided by them.
            let known = least > 8.0 * EPSILON * max(-next.value, 0.0);
            if definite && known && long * aspect <= LAST_CLIMB {
                peak.point_a += e1 * (hessian_a.x * step.x + hessian_a.y * step.y) + e2 * (hessian_a.y * step.x + hessian_a.z * step.y);
                peak.point_b += e1 * (hessian_b.x * step.x + hessian_b.y * step.y) + e2 * (hessian_b.y * step.x + hessian_b.z * step.y);
                // The points of deep bodies separate by the overlap times the rotation, unless the normal turns too.
                peak.normal = normalize(normal + e1 * step.x + e2 * step.y);
            }
            break;
        }
        if !(long <= LONGEST_STEP) {
            step = select(g / slope, step / long, long <= HUGE);
        }
        gain = dot(g, step);
        // Newton's error is quadratic, with the curvature changing over an angle of one over the aspect ratio.
        last = definite && slope * long * aspect <= GRADIENT_FLOOR * size;
        fraction = 1.0;
        normal = normalize(peak.normal + e1 * step.x + e2 * step.y);
    }
    return peak;
}
