// The minima of the distance of two circles in space.
//
// The point of circle a nearest to a given point has a closed form; the unknown is the angle along circle b. In a's
// axes, with z the height of b's point and rho its distance from a's axis, the squared distance is z^2 + (rho - R_a)^2.
// Samples bracket its minima, and a safeguarded Newton method refines them. An interval is halved while it may contain
// two minima, by the derivatives at its ends, or while it is wide compared with its distance from the axis of a, where
// the function is not smooth. It is skipped if, by the length of its arc, it cannot contain a wanted minimum. The
// intervals are visited in order without a stack: an interval is an index at a level of halving, and the next index is
// one more, halved as often as it is even.
//
// Degenerate cases: coaxial circles and others with a constant distance, which have no minimum; a point on the axis
// (the first direction in the plane).

// Initial intervals, eight per quarter turn.
const RING_INTERVALS: u32 = 32u;
const RING_INTERVAL: real = 0.19634954084936207740;
// Ratio of the second derivatives at the ends of an interval below which the first derivative counts as monotone
// between them.
const RING_MONOTONE: real = 2.0;
// The largest number of steps of the refinement; each at least halves the bracket.
const RING_STEPS: u32 = 60u;
// The largest number of distinct minima.
const RING_MINIMA: u32 = 4u;
// The search visits at most this many intervals. It then stops halving them.
const RING_WALK: u32 = 3000u;

// Circle b in the axes of circle a: its centre, and two perpendicular radii.
struct RingPair {
    centre: vec3r,
    first: vec3r,
    second: vec3r,
    radius_a: real,
    radius_b: real,
}

// A position on circle b: quarter turns, and an angle from -pi/4 to pi/4 beyond them.
struct RingPlace {
    quarter: u32,
    angle: real,
}

// Whether positions on circle b are in the order of their angles.
struct RingPlaces {
    count: u32,
    places: array<RingPlace, RING_MINIMA>,
}

// The squared distance at a position, its first and second derivative, and the rounding error of the first.
struct RingSample {
    angle: real,
    square: real,
    slope: real,
    bend: real,
    rounding: real,
    rho: real,
    rho1: real,
}

// Cosine and sine of a position, by their series: the first omitted term is below 1e-16.
fn ring_direction(quarter: u32, x: real) -> vec2r {
    let y = x * x;
    let sine = x * (1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0 * (1.0 - y / 110.0 * (1.0 - y / 156.0 * (1.0 - y / 210.0)))))));
    let cosine = 1.0 - y / 2.0 * (1.0 - y / 12.0 * (1.0 - y / 30.0 * (1.0 - y / 56.0 * (1.0 - y / 90.0 * (1.0 - y / 132.0 * (1.0 - y / 182.0 * (1.0 - y / 240.0)))))));
    let turned = select(vec2r(cosine, sine), vec2r(-sine, cosine), (quarter & 1u) == 1u);
    return select(turned, -turned, (quarter & 2u) == 2u);
}

// The start of an interval at a level of halving; `quarter` is the quarter of the interval that the position precedes.
fn interval_quarter(index: u32, level: u32) -> u32 {
    return ((index >> level) + 4u) / 8u;
}

fn interval_angle(index: u32, level: u32, quarter: u32) -> real {
    let whole = i32(index) - i32((quarter * 8u) << level);
    return real(whole) * (RING_INTERVAL / real(1u << level));
}

fn sample_ring(pair: RingPair, quarter: u32, angle: real) -> RingSample {
    let turn = ring_direction(quarter & 3u, angle);
    let out = pair.first * turn.x + pair.second * turn.y;
    let p1 = pair.second * turn.x - pair.first * turn.y;
    let p = pair.centre + out;
    let rho = length(p.xy);
    let inverse = select(real(0.0), 1.0 / rho, rho > 0.0);
    let rho1 = dot(p.xy, p1.xy) * inverse;
    let spin = (p.x * p1.y - p.y * p1.x) * inverse;
    let rho2 = (spin * spin - dot(p.xy, out.xy)) * inverse;
    let off = rho - pair.radius_a;
    let size = pair.radius_a + pair.radius_b + abs(p.z);
    return RingSample(
        angle,
        p.z * p.z + off * off,
        2.0 * (p.z * p1.z + off * rho1),
        2.0 * (p1.z * p1.z - p.z * out.z + rho1 * rho1 + off * rho2),
        2.0 * EPSILON * (size * (abs(p1.z) + abs(rho1)) + pair.radius_b * (abs(p.z) + abs(off))),
        rho,
        rho1,
    );
}

// Whether an interval has at most one root of the slope, judged from its ends: the slope changes in the same direction
// at both and about as fast, or is too steep to return, or is rounding. Never if the interval is as wide as the
// distance of the circle from the axis.
fn is_resolved(low: RingSample, high: RingSample, radius: real) -> bool {
    let turn = high.angle - low.angle;
    let least = min(abs(low.bend), abs(high.bend));
    let most = max(abs(low.bend), abs(high.bend));
    let swing = turn * (max(abs(low.rho1), abs(high.rho1)) + radius * turn);
    let smooth_here = min(low.rho, high.rho) >= swing;
    let monotone = low.bend * high.bend > 0.0 && most < RING_MONOTONE * least;
    let steep = low.slope * high.slope > 0.0 && min(abs(low.slope), abs(high.slope)) > turn * most;
    let flat = abs(low.slope) <= low.rounding && abs(high.slope) <= high.rounding;
    return flat || smooth_here && (monotone || steep);
}

// The first minima with a distance of at most `most`; or, if only the `nearest` is wanted, that one, the first among
// equals, or the nearest sample without a minimum.
fn ring_minima(pair: RingPair, size: real, most: real, nearest: bool) -> RingPlaces {
    let tie = TIE * size;
    var minima: RingPlaces;
    var low: RingSample;
    var least = HUGE;
    var largest = real(0.0);
    for (var i = 0u; i < RING_INTERVALS; i += 1u) {
        let quarter = interval_quarter(i, 0u);
        let angle = interval_angle(i, 0u, quarter);
        let here = sample_ring(pair, quarter, angle);
        if i == 0u { low = here; }
        largest = max(largest, here.square);
        if here.square < least {
            least = here.square;
            minima.places[0] = RingPlace(quarter, angle);
        }
    }
    if sqrt(largest) - sqrt(least) <= tie {
        minima.places[0] = RingPlace(0u, real(0.0));
        minima.count = select(0u, 1u, nearest);
        return minima;
    }
    // The nearest sample bounds the search.
    var reach = select(most, sqrt(least), nearest);
    var found = HUGE;
    var index = 0u;
    var level = 0u;
    for (var walked = 0u; index < RING_INTERVALS << level; walked += 1u) {
        let quarter = interval_quarter(index, level);
        let high = sample_ring(pair, quarter, interval_angle(index + 1u, level, quarter));
        let arc = pair.radius_b * (high.angle - low.angle);
        let may_halve = level < RING_HALVINGS && walked < RING_WALK;
        let bracket = low.slope <= 0.0 && high.slope > 0.0;
        var halve = false;
        if sqrt(min(low.square, high.square)) - 0.5 * arc <= reach + tie {
            halve = may_halve && !is_resolved(low, high, pair.radius_b);
            if !halve && bracket {
                var left = low.angle;
                var right = high.angle;
                var angle = 0.5 * (left + right);
                var here = low;
                for (var i = 0u; i < RING_STEPS; i += 1u) {
                    let step = abs(angle - here.angle);
                    here = sample_ring(pair, quarter, angle);
                    if i == 0u {
                        halve = may_halve && !(is_resolved(low, here, pair.radius_b) && is_resolved(here, high, pair.radius_b));
                        if halve { break; }
                    } else if step <= 4.0 * EPSILON { break; }
                    if abs(here.slope) <= here.rounding { break; }
                    if here.slope <= 0.0 { left = angle; } else { right = angle; }
                    let newton = angle - here.slope / here.bend;
                    angle = select(0.5 * (left + right), newton, here.bend > 0.0 && newton > left && newton < right);
                }
                let distance = sqrt(here.square);
                if !halve && nearest && distance < found - tie {
                    found = distance;
                    reach = min(reach, distance);
                    minima.places[0] = RingPlace(quarter, here.angle);
                }
                if !halve && !nearest && distance <= most && minima.count < RING_MINIMA {
                    minima.places[minima.count] = RingPlace(quarter, here.angle);
                    minima.count += 1u;
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

// Ring b about `delta` in the axes of ring a.
fn ring_pair(delta: vec3r, ring_a: Ring, ring_b: Ring) -> RingPair {
    let first = ring_b.axes[0] * ring_b.radius;
    let second = ring_b.axes[1] * ring_b.radius;
    return RingPair(delta * ring_a.axes, first * ring_a.axes, second * ring_a.axes, ring_a.radius, ring_b.radius);
}

// The nearest points for a position on circle b.
fn nearest_at(delta: vec3r, ring_a: Ring, ring_b: Ring, place: RingPlace, size: real) -> Nearest {
    let turn = ring_direction(place.quarter & 3u, place.angle);
    let to_b = (ring_b.axes[0] * ring_b.radius) * turn.x + (ring_b.axes[1] * ring_b.radius) * turn.y;
    let along = ring_b.axes[1] * turn.x - ring_b.axes[0] * turn.y;
    let toward = ring_toward(ring_a, delta + to_b);
    let from_a = toward * ring_a.radius;
    let gap = delta + to_b - from_a;
    let distance = length(gap);
    let of_a = Course(cross(ring_a.axes[2], toward), true, real(0.0));
    let normal = normal_between(of_a, Course(along, true, real(0.0)), gap, distance, size, gap);
    return Nearest(from_a, to_b, normal, distance);
}
