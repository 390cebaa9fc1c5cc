#version 300 es
//DEPTH
// One ray against one body: where it meets the smooth surface, as src/render/intersect.rs has it.
precision highp float;
precision highp int;

flat in vec3 right;
flat in vec3 up;
flat in vec3 toward;
flat in vec4 body;    // the kind, and its numbers in units of the body's size
flat in float height; // of the centre, toward the viewer
flat in float unit;
flat in uvec2 label;  // the body's row; its colour and outline
in vec2 offset;
#ifdef CUT
flat in vec4 cutter;
#endif
#ifdef PERSPECTIVE
in vec2 sight;
#endif
in float front;

uniform float depth;

// The body's row and one more, the height, the normal along right and up, colour and outline.
// Of a shadow depths suffice.
#ifndef DEPTHS
layout(location = 0) out uvec4 met;
#endif
//DEPTH_OUT

// As in body.vert.
#define IS(kind) (KINDS == (1 << int(kind)) || body.x == kind)

const float POINT = 0.0, SEGMENT = 1.0, CIRCLE = 2.0;
// A superellipsoid has its exponents behind the point.
const float SUPERELLIPSOID = 4.0;
const float MISS = 3e38;
// A tangent line halves the error with each step, and a float has 24 bits.
const int NEWTON_STEPS = 40;

float hit_point(float radius, vec3 origin, vec3 direction) {
    float along = dot(origin, direction);
    vec3 across = origin - direction * along;
    float discriminant = radius * radius - dot(across, across);
    return discriminant < 0.0 ? MISS : -along - sqrt(discriminant);
}

float hit_segment(float half_length, float radius, vec3 origin, vec3 direction) {
    float square = dot(direction.xy, direction.xy);
    float moment = origin.x * direction.y - origin.y * direction.x;
    float discriminant = square * radius * radius - moment * moment;
    if (square > 0.0 && discriminant < 0.0) return MISS;
    // Along the axis: the cap that faces the line.
    float end = direction.z > 0.0 ? -half_length : half_length;
    if (square > 0.0) {
        float t = (-dot(origin.xy, direction.xy) - sqrt(discriminant)) / square;
        float z = origin.z + t * direction.z;
        if (abs(z) <= half_length) return t;
        end = z < 0.0 ? -half_length : half_length;
    }
    return hit_point(radius, origin - vec3(0.0, 0.0, end), direction);
}

float hit_ellipsoid(vec3 radii, vec3 origin, vec3 direction) {
    vec3 o = origin / radii;
    vec3 d = direction / radii;
    float square = dot(d, d);
    vec3 moment = cross(o, d);
    float discriminant = square - dot(moment, moment);
    return discriminant < 0.0 ? MISS : (-dot(o, d) - sqrt(discriminant)) / square;
}

// `t^4 + c.x t^2 + c.y t + c.z`.
float quartic(vec3 c, float t) {
    return ((t * t + c.x) * t + c.y) * t + c.z;
}

float quartic_slope(vec3 c, float t) {
    return (4.0 * t * t + 2.0 * c.x) * t + c.y;
}

// The least root in a convex part from `start`, before which there is none, to `end`.
float convex_root(vec3 c, float start, float end) {
    float t = start;
    for (int k = 0; k < NEWTON_STEPS; k++) {
        float value = quartic(c, t);
        float slope = quartic_slope(c, t);
        if (value <= 0.0) return t;
        if (slope >= 0.0) return MISS;
        float next = t - value / slope;
        if (next > end) return MISS;
        if (next == t) break;
        t = next;
    }
    return t;
}

// The root before `start` in a concave part that `start` ends, with a value not above zero there.
float concave_root(vec3 c, float start) {
    float t = start;
    for (int k = 0; k < NEWTON_STEPS; k++) {
        float next = t - quartic(c, t) / quartic_slope(c, t);
        if (!(next < t)) break;
        t = next;
    }
    return t;
}

// The least root, given a `start` at or before it.
float least_root(vec3 c, float start) {
    if (c.x >= 0.0) return convex_root(c, start, MISS);
    float bend = sqrt(-c.x / 6.0);
    if (start < -bend) {
        float root = convex_root(c, start, -bend);
        if (root < MISS) return root;
    }
    if (start < bend && quartic(c, bend) <= 0.0) return concave_root(c, bend);
    return convex_root(c, max(start, bend), MISS);
}

// Where the line `origin + t direction` first meets the tube, at or after `start`, which is outside of it.
float hit_circle(float major, float radius, vec3 origin, vec3 direction, float start) {
    float along = dot(origin, direction);
    vec3 o = origin - direction * along;
    float square = dot(o, o);
    float outer = major + radius;
    if (square > outer * outer) return MISS;
    float major2 = major * major;
    float k = square + major2 - radius * radius;
    vec3 c = vec3(2.0 * (k - 2.0 * major2 * dot(direction.xy, direction.xy)), 8.0 * major2 * o.z * direction.z,
        k * k - 4.0 * major2 * dot(o.xy, o.xy));
    float root = least_root(c, max(start + along, -sqrt(outer * outer - square)));
    return root < MISS ? root - along : MISS;
}

#if (KINDS & 16) != 0
// As in body.vert.
vec2 exponents(float kind) {
    float code = (kind - SUPERELLIPSOID) * 1048576.0;
    return 2.0 + vec2(mod(code, 1024.0), floor(code / 1024.0)) * (8.0 / 1023.0);
}

float norm_of(float a, float b, float n) {
    float larger = max(a, b);
    return larger > 0.0 ? larger * pow(1.0 + pow(min(a, b) / larger, n), 1.0 / n) : 0.0;
}

// The gauge, 1 on the surface, as src/shape/superellipsoid/norm.rs has it, and its gradient.
vec4 gauge(vec3 radii, vec2 n, vec3 p) {
    vec3 v = abs(p) / radii;
    float across = norm_of(v.x, v.y, n.y);
    float whole = norm_of(across, v.z, n.x);
    if (whole == 0.0) return vec4(0.0);
    vec2 of_both = pow(vec2(across, v.z) / whole, vec2(n.x - 1.0));
    vec2 of_flat = across > 0.0 ? pow(v.xy / across, vec2(n.y - 1.0)) : vec2(0.0);
    return vec4(vec3(of_both.x * of_flat, of_both.y) / radii * sign(p), whole);
}

// Newton's iteration from where the line enters the box around it: the gauge is convex along the line.
float hit_superellipsoid(vec3 radii, vec2 n, vec3 origin, vec3 direction) {
    // A line along a side of the box would divide by zero.
    vec3 d = mix(direction, vec3(1e-9), lessThan(abs(direction), vec3(1e-9)));
    vec3 near = (-radii * sign(d) - origin) / d;
    vec3 far = (radii * sign(d) - origin) / d;
    float t = max(near.x, max(near.y, near.z));
    float end = min(far.x, min(far.y, far.z));
    if (t > end) return MISS;
    for (int k = 0; k < NEWTON_STEPS; k++) {
        vec4 found = gauge(radii, n, origin + direction * t);
        float slope = dot(found.xyz, direction);
        if (found.w <= 1.0 + 2e-7) return t;
        if (slope >= 0.0) return MISS;
        float next = t - (found.w - 1.0) / slope;
        if (next > end) return MISS;
        if (!(next > t)) return t;
        t = next;
    }
    return t;
}
#endif

float first_hit(vec3 origin, vec3 direction) {
#if (KINDS & 1) != 0
    if (IS(POINT)) return hit_point(body.z, origin, direction);
#endif
#if (KINDS & 2) != 0
    if (IS(SEGMENT)) return hit_segment(body.y, body.z, origin, direction);
#endif
#if (KINDS & 4) != 0
    if (IS(CIRCLE)) return hit_circle(body.y, body.z, origin, direction, -MISS);
#endif
#if (KINDS & 16) != 0
    if (body.x >= SUPERELLIPSOID) return hit_superellipsoid(body.yzw, exponents(body.x), origin, direction);
#endif
    return hit_ellipsoid(body.yzw, origin, direction);
}

#ifdef CUT
// Where a ray that first meets the body in what is cut off meets what is left: the cut itself, or the tube again.
float hit_behind_cut(vec3 origin, vec3 direction, out bool on_cut) {
    on_cut = false;
    float against = dot(cutter.xyz, direction);
    if (against >= 0.0) return MISS;
    float t = (cutter.w - dot(cutter.xyz, origin)) / against;
    float last = -first_hit(origin, -direction);
    if (t >= last) return MISS;
#if (KINDS & 4) != 0
    if (IS(CIRCLE)) {
        vec3 point = origin + direction * t;
        float across = length(point.xy) - body.y;
        if (across * across + point.z * point.z > body.z * body.z) return hit_circle(body.y, body.z, origin, direction, t);
    }
#endif
    on_cut = true;
    return t;
}
#endif

#ifndef DEPTHS
vec3 normal_at(vec3 point) {
#if (KINDS & 16) != 0
    if (body.x >= SUPERELLIPSOID) return normalize(gauge(body.yzw, exponents(body.x), point).xyz);
#endif
    if (body.x > CIRCLE) return normalize(point / (body.yzw * body.yzw));
    vec3 foot = vec3(0.0);
    if (body.x == SEGMENT) foot.z = clamp(point.z, -body.y, body.y);
    if (body.x == CIRCLE && dot(point.xy, point.xy) > 0.0) foot = vec3(normalize(point.xy) * body.y, 0.0);
    return normalize(point - foot);
}
#endif

void main() {
    vec3 origin = (right * offset.x + up * offset.y) / unit;
    vec3 ray = -toward;
    float slope = 1.0;
#ifdef PERSPECTIVE
    slope = inversesqrt(1.0 + dot(sight, sight));
    ray = (right * sight.x + up * sight.y - toward) * slope;
#endif
    float t = first_hit(origin, ray);
    bool on_cut = false;
#ifdef CUT
    if (t < MISS && dot(cutter.xyz, origin + ray * t) > cutter.w) t = hit_behind_cut(origin, ray, on_cut);
#endif
    if (t >= MISS) discard;
    float seen = height - t * unit * slope;
#ifndef DEPTHS
    vec3 normal = normal_at(origin + ray * t);
#ifdef CUT
    if (on_cut) normal = normalize(cutter.xyz);
#endif
    met = uvec4(label.x + 1u, floatBitsToUint(seen), packSnorm2x16(vec2(dot(normal, right), dot(normal, up))), label.y);
#endif
    gl_FragDepth = max(0.5 - seen / (2.0 * depth), front);
}
