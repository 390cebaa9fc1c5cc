// A circle and a point or segment: the nearest points of both.
//
// The point of the circle nearest to a given point is in closed form, which leaves the place t along the segment. With
// z the height over the circle's plane and rho the distance from its axis, the squared distance z^2 + (rho - R)^2 is
// convex in t outside the interval about the place t_a nearest to the axis where rho^3 < R k^2 m^2 (m = rho at t_a, k
// the sine between segment and axis), and concave inside, where no minimum can be: there are two minima at most, each
// alone in a convex piece.
//
// Degenerate cases: a point on the axis (the first direction in the plane); a segment that meets the circle
// (`normal_between`); two equal minima (the first along the segment).

// Steps at most of the refinement; each at least halves the bracket.
const CIRCLE_SEGMENT_STEPS: u32 = 60u;

// Half the first and second derivative of the squared distance, and the square.
struct PlaceSample {
    square: real,
    slope: real,
    bend: real,
}

// The segment's line in the circle's axes: height at place zero and its slope, the place nearest to the axis, how near
// it comes there, and the sine to the axis.
struct PlaceLine {
    height: real,
    rise: real,
    turn: real,
    miss: real,
    sine: real,
    radius: real,
}

// Written with the place from `turn`, so that rho falls before it and rises after it whatever the rounding; `side` says
// which where the place is on the axis but for rounding.
fn sample_place(line: PlaceLine, at: real, side: real) -> PlaceSample {
    let z = line.height + line.rise * at;
    let across = line.sine * (at - line.turn);
    let rho = length(vec2r(line.miss, across));
    var cosine = side;
    var sine = real(0.0);
    var inverse = real(0.0);
    if rho > EPSILON * line.radius {
        inverse = 1.0 / rho;
        cosine = across * inverse;
        sine = line.miss * inverse;
    }
    let rho1 = line.sine * cosine;
    let turning = line.sine * sine;
    let off = rho - line.radius;
    return PlaceSample(
        z * z + off * off,
        z * line.rise + off * rho1,
        line.rise * line.rise + rho1 * rho1 + off * turning * turning * inverse,
    );
}

// The cube root of a number from 0 to about 1: x^(1/4 + 1/16 + 1/64 + 1/256) to start, which is within a tenth, and
// Newton's method.
fn cube_root(x: real) -> real {
    if x <= 0.0 {
        return real(0.0);
    }
    var power = x;
    var root = real(1.0);
    for (var i = 0u; i < 4u; i += 1u) {
        power = sqrt(sqrt(power));
        root *= power;
    }
    for (var i = 0u; i < 4u; i += 1u) {
        root = (2.0 * root + x / (root * root)) / 3.0;
    }
    return root;
}

// The place along the segment nearest to the circle; both in the circle's axes.
fn nearest_place(centre: vec3r, along: vec3r, half: real, radius: real, size: real) -> real {
    // A segment along the axis keeps one distance from it; any place will do for the one nearest to the axis.
    let foot = -dot(centre, along);
    var line = PlaceLine(centre.z, along.z, foot, length(centre.xy), real(0.0), radius);
    var reach = real(0.0);
    let lean2 = dot(along.xy, along.xy);
    if lean2 > 4.0 * EPSILON * EPSILON {
        let moment = centre.x * along.y - centre.y * along.x;
        line.sine = sqrt(lean2);
        line.turn = -dot(centre.xy, along.xy) / lean2;
        line.miss = abs(moment) / line.sine;
        let root = size * cube_root(radius / size * (moment / size) * (moment / size));
        reach = sqrt(max(root * root - line.miss * line.miss, 0.0)) / line.sine;
    }
    // An interior minimum is within R of the foot of the centre: the slope of rho is at most 1.
    let low = clamp(foot - radius, -half, half);
    let high = clamp(foot + radius, -half, half);
    var best = real(0.0);
    var least = real(0.0);
    for (var side = 0u; side < 2u; side += 1u) {
        let after = select(real(-1.0), real(1.0), side == 1u);
        let split = clamp(line.turn + after * reach, low, high);
        var left = select(low, split, side == 1u);
        var right = select(split, high, side == 1u);
        // The ends first, then the least in between.
        var at = left;
        var here = sample_place(line, at, after);
        for (var i = 0u; i < CIRCLE_SEGMENT_STEPS; i += 1u) {
            var next = right;
            if i == 0u {
                if here.slope >= 0.0 { break; }
            } else {
                if i == 1u && here.slope <= 0.0 { break; }
                if here.slope <= 0.0 { left = at; } else { right = at; }
                next = at - here.slope / here.bend;
                if i == 1u || !(here.bend > 0.0 && next > left && next < right) {
                    next = 0.5 * (left + right);
                }
            }
            let step = abs(next - at);
            at = next;
            here = sample_place(line, at, after);
            if i > 0u && step <= EPSILON * (abs(left) + abs(right)) { break; }
        }
        let distance = sqrt(here.square);
        if side == 0u || distance < least - TIE * size {
            least = distance;
            best = at;
        }
    }
    return best;
}

fn is_swapped(delta: vec3r, a: Placed, b: Placed) -> bool {
    return a.kind != TORUS;
}

// The ring is a.
fn ordered_separation(delta: vec3r, a: Placed, b: Placed, warm: vec3r) -> Separation {
    let ring = ring_of(a);
    let axis = body_z(b.orientation) * select(real(0.0), real(1.0), b.kind == SPHEROCYLINDER);
    let half = half_segment(b);
    let size = length(delta) + ring.radius + half;
    var at = real(0.0);
    if half > 0.0 {
        at = nearest_place(delta * ring.axes, axis * ring.axes, half, ring.radius, size);
    }
    let to_b = axis * at;
    let toward = ring_toward(ring, delta + to_b);
    let from_a = toward * ring.radius;
    let gap = delta + to_b - from_a;
    let distance = length(gap);
    let tangent = cross(ring.axes[2], toward);
    let normal = normal_between(tangent, axis, gap, distance, size, gap, abs(at) < half);
    return thickened(Nearest(from_a, to_b, normal, distance), tube_radius(a), tube_radius(b));
}
