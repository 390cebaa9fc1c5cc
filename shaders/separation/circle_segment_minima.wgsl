// The minima of the distance of a circle and a segment.
//
// The point of the circle nearest to a given point has a closed form; the unknown is the position t along the segment.
// With z the height over the circle's plane and rho the distance from its axis, the squared distance z^2 + (rho - R)^2
// is convex in t outside the interval about the place t_a nearest to the axis where rho^3 < R k^2 m^2 (m = rho at t_a,
// k the sine between segment and axis), and concave inside, where there is no minimum: there are at most two minima,
// each alone in a convex piece.
//
// Degenerate cases: a point on the axis (the first direction in the plane); a segment that meets the circle
// (`normal_between`).

// The largest number of steps of the refinement; each at least halves the bracket.
const CIRCLE_SEGMENT_STEPS: u32 = 60u;

// Half the first and second derivative of the squared distance, and the square.
struct PlaceSample {
    square: real,
    slope: real,
    bend: real,
}

// The segment's line in the circle's axes: height at position zero and its slope, the position nearest to the axis, the
// distance there, and the sine to the axis.
struct PlaceLine {
    height: real,
    rise: real,
    turn: real,
    miss: real,
    sine: real,
    radius: real,
}

// Written with the position relative to `turn`, so that rho falls before it and rises after it despite rounding; `side`
// selects the side if the position is on the axis up to rounding.
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

// The line, the range of possible minima, and the distance from `turn` within which the squared distance is concave.
struct PlaceSides {
    line: PlaceLine,
    low: real,
    high: real,
    reach: real,
}

// For a segment of positive length; both in the circle's axes.
fn place_sides(centre: vec3r, along: vec3r, half: real, radius: real, size: real) -> PlaceSides {
    // A segment along the axis has a constant distance from it; any position serves as the nearest.
    let foot = -dot(centre, along);
    var line = PlaceLine(centre.z, along.z, foot, length(centre.xy), real(0.0), radius);
    var reach = real(0.0);
    let lean2 = dot(along.xy, along.xy);
    if lean2 > ROUNDING_SINE * ROUNDING_SINE {
        let moment = centre.x * along.y - centre.y * along.x;
        line.sine = sqrt(lean2);
        line.turn = -dot(centre.xy, along.xy) / lean2;
        line.miss = abs(moment) / line.sine;
        let root = size * cube_root(radius / size * (moment / size) * (moment / size));
        reach = sqrt(max(root * root - line.miss * line.miss, 0.0)) / line.sine;
    }
    // An interior minimum is within R of the foot of the centre: the slope of rho is at most 1.
    return PlaceSides(line, clamp(foot - radius, -half, half), clamp(foot + radius, -half, half), reach);
}

// The position of the smallest distance in a piece, this distance, and the piece's borders towards `turn` and away from
// it.
struct PlaceMinimum {
    at: real,
    distance: real,
    inner: real,
    outer: real,
}

// In the piece before (-1) or after (1) the position nearest to the axis.
fn place_minimum(sides: PlaceSides, after: real) -> PlaceMinimum {
    let split = clamp(sides.line.turn + after * sides.reach, sides.low, sides.high);
    var left = select(sides.low, split, after > 0.0);
    var right = select(split, sides.high, after > 0.0);
    // The ends first, then the minimum in between.
    var at = left;
    var here = sample_place(sides.line, at, after);
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
        here = sample_place(sides.line, at, after);
        if i > 0u && step <= EPSILON * (abs(left) + abs(right)) { break; }
    }
    return PlaceMinimum(at, sqrt(here.square), split, select(sides.low, sides.high, after > 0.0));
}

// The point of the ring nearest to a position on the segment.
fn nearest_at_place(delta: vec3r, ring: Ring, axis: vec3r, half: real, at: real, size: real) -> Nearest {
    let to_b = axis * at;
    let toward = ring_toward(ring, delta + to_b);
    let from_a = toward * ring.radius;
    let gap = delta + to_b - from_a;
    let distance = length(gap);
    let of_a = Course(cross(ring.axes[2], toward), true, real(0.0));
    let normal = normal_between(of_a, course_of(axis, half, at), gap, distance, size, gap);
    return Nearest(from_a, to_b, normal, distance);
}
