// The minima of the distance of a circle's points to an ellipsoid.
//
// The distance of a point to a convex body, negative inside, is a convex function of the point, whose gradient is the
// body's normal n there. So along a circle of radius R its derivative is n . p', and its second derivative is at least
// -R, also inside, where it has kinks. Two parabolas with that bend bound it from below between two samples; an
// interval where they stay above what is wanted is skipped. The others are halved and refined as in
// `circle_minima.wgsl`, whose intervals and positions these are. Everything is in the ellipsoid's axes, where a
// normal's small components keep their digits.
//
// Degenerate cases: a constant distance, which has no minimum; a point with several nearest ones (see
// `point_ellipsoid.wgsl`).

// The largest number of steps of the refinement, and after how many of them every other one halves the bracket: at a
// kink Newton's steps need not.
const AROUND_STEPS: u32 = 100u;
const AROUND_FAST_STEPS: u32 = 10u;

// A circle in the axes of an ellipsoid about the origin: its centre, and two perpendicular radii.
struct Around {
    centre: vec3r,
    first: vec3r,
    second: vec3r,
    radius: real,
    radii: vec3r,
    size: real,
}

// The distance at a position, its first and second derivative, and the rounding error of the first.
struct AroundSample {
    angle: real,
    value: real,
    slope: real,
    bend: real,
    rounding: real,
}

// Positions on the circle in the order of their angles, with their distances.
struct AroundPlaces {
    count: u32,
    places: array<RingPlace, RING_MINIMA>,
    values: array<real, RING_MINIMA>,
}

// The circle is about the origin, and the ellipsoid about `delta`.
fn around_of(delta: vec3r, ring: Ring, egg: Placed) -> Around {
    let axes = body_axes(egg.orientation);
    return Around(
        -delta * axes,
        (ring.axes[0] * axes) * ring.radius,
        (ring.axes[1] * axes) * ring.radius,
        ring.radius,
        egg.sizes,
        length(delta) + ring.radius + largest(egg.sizes),
    );
}

fn sample_around(around: Around, quarter: u32, angle: real) -> AroundSample {
    let turn = ring_direction(quarter & 3u, angle);
    let out = around.first * turn.x + around.second * turn.y;
    let p1 = around.second * turn.x - around.first * turn.y;
    let p = around.centre + out;
    let normal = point_ellipsoid_normal(around.radii, p);
    let height = length(around.radii * normal);
    let value = dot(normal, p) - height;
    // The directions across the normal in which the body is curved most and least.
    let body = Support(mat3r(vec3r(1.0, 0.0, 0.0), vec3r(0.0, 1.0, 0.0), vec3r(0.0, 0.0, 1.0)), around.radii);
    let tangents = orthonormal_pair(normal);
    let h = support_hessian(body, height, tangents.first, tangents.second);
    let bases = half_turn(2.0 * h.y, h.x - h.z);
    let e1 = tangents.first * bases.x + tangents.second * bases.y;
    let e2 = tangents.second * bases.x - tangents.first * bases.y;
    let curved = support_hessian(body, height, e1, e2);
    let least = EPSILON * EPSILON * around.size;
    let along = vec2r(dot(p1, e1), dot(p1, e2));
    let swing = abs(along) / max(curved.xz + vec2r(value), vec2r(least));
    return AroundSample(
        angle,
        value,
        dot(normal, p1),
        dot(abs(along), swing) - dot(normal, out),
        2.0 * EPSILON * (around.radius + around.size * (swing.x + swing.y)),
    );
}

// Whether an interval has at most one root of the slope, judged from its ends.
fn is_one_around(low: AroundSample, high: AroundSample) -> bool {
    let turn = high.angle - low.angle;
    let least = min(abs(low.bend), abs(high.bend));
    let most = max(abs(low.bend), abs(high.bend));
    let monotone = low.bend * high.bend > 0.0 && most < RING_MONOTONE * least;
    let steep = low.slope * high.slope > 0.0 && min(abs(low.slope), abs(high.slope)) > turn * most;
    let flat = abs(low.slope) <= low.rounding && abs(high.slope) <= high.rounding;
    return flat || monotone || steep;
}

// A lower bound of the distance between two samples: the crossing of the parabolas from both, and what their arc
// allows.
fn bound_around(radius: real, low: AroundSample, high: AroundSample) -> real {
    let turn = high.angle - low.angle;
    let least = min(low.value, high.value);
    let by_arc = 0.5 * (low.value + high.value - radius * turn);
    let along = low.slope - high.slope - radius * turn;
    let at = (high.value - low.value - high.slope * turn - 0.5 * radius * turn * turn) / along;
    if !(at > 0.0 && at < turn) { return least; }
    return min(max(by_arc, low.value + low.slope * at - 0.5 * radius * at * at), least);
}

// Adds a minimum; beyond the largest number it replaces the farthest.
fn keep_around(kept: AroundPlaces, place: RingPlace, value: real, tie: real) -> AroundPlaces {
    var all = kept;
    if all.count == RING_MINIMA {
        var farthest = 0u;
        for (var k = 1u; k < RING_MINIMA; k += 1u) {
            if all.values[k] > all.values[farthest] { farthest = k; }
        }
        if !(value < all.values[farthest] - tie) { return all; }
        for (var k = farthest; k + 1u < RING_MINIMA; k += 1u) {
            all.places[k] = all.places[k + 1u];
            all.values[k] = all.values[k + 1u];
        }
        all.count -= 1u;
    }
    all.places[all.count] = place;
    all.values[all.count] = value;
    all.count += 1u;
    return all;
}

// The nearest minima with a distance of at most `most`; or, if only the `nearest` is wanted, that one, the first among
// equals, or the nearest sample without a minimum.
fn minima_around(around: Around, most: real, nearest: bool) -> AroundPlaces {
    let tie = TIE * around.size;
    var minima: AroundPlaces;
    var low: AroundSample;
    var least = HUGE;
    var largest_value = -HUGE;
    for (var i = 0u; i < RING_INTERVALS; i += 1u) {
        let quarter = interval_quarter(i, 0u);
        let angle = interval_angle(i, 0u, quarter);
        let here = sample_around(around, quarter, angle);
        if i == 0u { low = here; }
        largest_value = max(largest_value, here.value);
        if here.value < least {
            least = here.value;
            minima.places[0] = RingPlace(quarter, angle);
            minima.values[0] = least;
        }
    }
    if largest_value - least <= tie {
        minima.places[0] = RingPlace(0u, real(0.0));
        minima.count = select(0u, 1u, nearest);
        return minima;
    }
    // The nearest sample bounds the search.
    var reach = select(most, least, nearest);
    var found = HUGE;
    var index = 0u;
    var level = 0u;
    for (var walked = 0u; index < RING_INTERVALS << level; walked += 1u) {
        let quarter = interval_quarter(index, level);
        let high = sample_around(around, quarter, interval_angle(index + 1u, level, quarter));
        let may_halve = level < RING_HALVINGS && walked < RING_WALK;
        let bracket = low.slope <= 0.0 && high.slope > 0.0;
        var halve = false;
        if bound_around(around.radius, low, high) <= reach + tie {
            halve = may_halve && !is_one_around(low, high);
            if !halve && bracket {
                var left = low.angle;
                var right = high.angle;
                var angle = 0.5 * (left + right);
                var here = low;
                for (var i = 0u; i < AROUND_STEPS; i += 1u) {
                    let step = abs(angle - here.angle);
                    if i > 0u && step <= 4.0 * EPSILON { break; }
                    here = sample_around(around, quarter, angle);
                    if i == 0u {
                        halve = may_halve && !(is_one_around(low, here) && is_one_around(here, high));
                        if halve { break; }
                    }
                    if abs(here.slope) <= here.rounding { break; }
                    if here.slope <= 0.0 { left = angle; } else { right = angle; }
                    let newton = angle - here.slope / here.bend;
                    let fast = i < AROUND_FAST_STEPS || (i & 1u) == 0u;
                    angle = select(0.5 * (left + right), newton, fast && here.bend > 0.0 && newton > left && newton < right);
                }
                if !halve && nearest && here.value < found - tie {
                    found = here.value;
                    reach = min(reach, found);
                    minima.places[0] = RingPlace(quarter, here.angle);
                    minima.values[0] = found;
                }
                if !halve && !nearest && here.value <= most {
                    minima = keep_around(minima, RingPlace(quarter, here.angle), here.value, tie);
                }
            }
        }
        if halve {
            level += 1u;
            index *= 2u;
        } else {
            low = high;
            index += 1u;
            let up = min(level, countTrailingZeros(index));
            level -= up;
            index = index >> up;
            low.angle = interval_angle(index, level, interval_quarter(index, level));
        }
    }
    if nearest { minima.count = 1u; }
    return minima;
}

// The separation of the circle thickened by `radius`, and the ellipsoid about `delta`, at a position on the circle.
fn separation_around(around: Around, axes: mat3r, place: RingPlace, radius: real) -> Separation {
    let turn = ring_direction(place.quarter & 3u, place.angle);
    let out = around.first * turn.x + around.second * turn.y;
    let p = around.centre + out;
    let normal = point_ellipsoid_normal(around.radii, p);
    let scaled = around.radii * normal;
    let height = length(scaled);
    return Separation(
        dot(normal, p) - height - radius,
        axes * -normal,
        axes * (out - normal * radius),
        axes * (around.radii * (scaled / height)),
    );
}
