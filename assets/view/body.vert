#version 300 es
// A body as a rectangle that just covers it.
precision highp float;
precision highp int;
precision highp sampler2D;

// KINDS has a bit for each kind of body that a state has; CUT and PERSPECTIVE are there where they are on. What is left
// out costs nothing: software renderers run both sides of each branch.
#define IS(kind) (KINDS == (1 << int(kind)) || shape.x == kind)

// A texel for each body. Vertices of one draw fetch what they need: software renderers take long for each instance.
uniform sampler2D places; // the centre, from the run's middle
uniform sampler2D turns;  // x, y, z, w: from body axes to space
uniform sampler2D shapes; // the kind, and its three numbers
uniform sampler2D parts;  // the place on the scale of colours; below zero: none; below -1.5: hidden

uniform mat3 axes;       // right, up and toward, as columns
uniform vec3 middle;     // what stands in the middle of the picture
uniform vec2 half_size;  // lengths from the middle of the picture to its right and upper edge
uniform float depth;     // all bodies are nearer to the middle than this, along the line of sight
uniform float pixels;    // pixels to a length of one
uniform int colour;      // 0 by the scale, 1 by the orientation, 2 plain, 3 by a hue of the body's own
uniform float distance_; // of the eye from the middle of the picture; 0: a parallel projection
uniform vec4 cut;        // what is beyond this plane is cut off: its normal, its offset

flat out vec3 right;
flat out vec3 up;
flat out vec3 toward;
flat out vec4 body;
flat out float height;
flat out float unit;
flat out uvec2 label;
#ifdef CUT
flat out vec4 cutter; // the plane in body axes from the centre, in units of the body's size
#endif
out vec2 offset; // where the ray passes the centre's height, from the centre along right and up
#ifdef PERSPECTIVE
out vec2 sight; // how far the ray goes right and up for each length away from the viewer
#endif
out float front;

vec3 place;
vec4 turn;
vec4 shape;
float part;

const float POINT = 0.0, SEGMENT = 1.0, CIRCLE = 2.0;
// A superellipsoid has its exponents behind the point.
const float SUPERELLIPSOID = 4.0;
const vec3 PLAIN = vec3(0.76, -0.035, -0.06);
const vec3 RAMP[5] = vec3[5](
    vec3(0.52, 0.0, -0.14), vec3(0.62, -0.08, -0.07), vec3(0.72, -0.13, 0.04), vec3(0.82, -0.07, 0.15),
    vec3(0.91, 0.01, 0.16));
// The hue of an axis to the right is 0.45 radians.
const vec2 HUE_START = vec2(0.9004471, 0.4349655);

vec3 to_space(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

#if (KINDS & 16) != 0
// Of ten bits each, from 2 to 10.
vec2 exponents(float kind) {
    float code = (kind - SUPERELLIPSOID) * 1048576.0;
    return 2.0 + vec2(mod(code, 1024.0), floor(code / 1024.0)) * (8.0 / 1023.0);
}

float norm_of(float a, float b, float n) {
    float larger = max(a, b);
    return larger > 0.0 ? larger * pow(1.0 + pow(min(a, b) / larger, n), 1.0 / n) : 0.0;
}
#endif

// How far the body reaches along a unit vector in its own axes.
float reach(vec3 e) {
#if (KINDS & 1) != 0
    if (IS(POINT)) return shape.z;
#endif
#if (KINDS & 2) != 0
    if (IS(SEGMENT)) return shape.z + shape.y * abs(e.z);
#endif
#if (KINDS & 4) != 0
    if (IS(CIRCLE)) return shape.z + shape.y * length(e.xy);
#endif
#if (KINDS & 16) != 0
    if (shape.x >= SUPERELLIPSOID) {
        vec2 n = exponents(shape.x);
        vec2 dual = n / (n - 1.0);
        vec3 v = shape.yzw * abs(e);
        return norm_of(norm_of(v.x, v.y, dual.y), v.z, dual.x);
    }
#endif
    return length(shape.yzw * e);
}

// The axis of orientation in body axes; zero where there is none.
vec3 own_axis() {
    if (shape.x == POINT) return vec3(0.0);
    if (shape.x <= CIRCLE) return vec3(0.0, 0.0, 1.0);
    float longest = max(shape.y, max(shape.z, shape.w));
    if (min(shape.y, min(shape.z, shape.w)) == longest) return vec3(0.0);
    if (shape.w == longest) return vec3(0.0, 0.0, 1.0);
    return shape.z == longest ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
}

vec3 oklab() {
    if (colour == 0 && part >= 0.0) {
        float way = clamp(part, 0.0, 1.0) * 4.0;
        int below = min(int(way), 3);
        return mix(RAMP[below], RAMP[below + 1], way - float(below));
    }
    if (colour == 3 && part >= 0.0) return vec3(0.74, 0.125 * cos(6.2831853 * part), 0.125 * sin(6.2831853 * part));
    vec3 axis = own_axis();
    if (colour != 1 || axis == vec3(0.0)) return PLAIN;
    axis = to_space(turn, axis);
    vec2 twice = vec2(axis.x * axis.x - axis.y * axis.y, 2.0 * axis.x * axis.y);
    float pale = axis.z * axis.z;
    return vec3(0.74 + 0.16 * pale, 0.125 * (twice.x * HUE_START.x - twice.y * HUE_START.y),
        0.125 * (twice.x * HUE_START.y + twice.y * HUE_START.x) + 0.02 * pale);
}

vec3 linear(vec3 c) {
    float l = c.x + 0.39633778 * c.y + 0.21580376 * c.z;
    float m = c.x - 0.105561346 * c.y - 0.06385417 * c.z;
    float s = c.x - 0.08948418 * c.y - 1.2914855 * c.z;
    vec3 v = vec3(l * l * l, m * m * m, s * s * s);
    return clamp(vec3(dot(v, vec3(4.0767417, -3.3077116, 0.23096994)),
        dot(v, vec3(-1.268438, 2.6097574, -0.34131938)),
        dot(v, vec3(-0.0041960863, -0.7034186, 1.7076147))), 0.0, 1.0);
}

// Roots of linear light keep dark colours apart in a byte.
uint packed_colour(vec3 light) {
    uvec3 bytes = uvec3(sqrt(light) * 255.0 + 0.5);
    return bytes.x | bytes.y << 8 | bytes.z << 16;
}

// How strong the outline is, in 64ths, and above that how many samples wide less one.
uint outline(float thickness) {
    uint strength = uint(clamp((thickness - 3.0) / 6.0, 0.0, 1.0) * 63.0 + 0.5);
    uint wider = (thickness >= 7.0 ? 1u : 0u) + (thickness >= 60.0 ? 1u : 0u);
    return strength | wider << 6;
}

float thickness() {
    return 2.0 * (shape.x <= CIRCLE ? shape.z : min(shape.y, min(shape.z, shape.w)));
}

void main() {
    int row = gl_VertexID >> 2;
    int wide = textureSize(places, 0).x;
    ivec2 texel = ivec2(row % wide, row / wide);
    part = texelFetch(parts, texel, 0).x;
    place = texelFetch(places, texel, 0).xyz;
    turn = texelFetch(turns, texel, 0);
    shape = texelFetch(shapes, texel, 0);
    vec4 back = vec4(-turn.xyz, turn.w);
    right = to_space(back, axes[0]);
    up = to_space(back, axes[1]);
    toward = to_space(back, axes[2]);
    vec3 seen = (place - middle) * axes;
    bool hidden = part < -1.5;
#ifdef CUT
    vec3 cut_normal = to_space(back, cut.xyz);
    float cut_offset = cut.w - dot(cut.xyz, place);
    hidden = hidden || cut_offset < -reach(cut_normal);
#endif
    float larger = 1.0;
#ifdef PERSPECTIVE
    hidden = hidden || seen.z > 0.9 * distance_;
    larger = distance_ / (distance_ - seen.z);
#endif
    if (hidden) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1 & 1) * 2.0 - 1.0;
    float before = reach(toward);
    height = seen.z;
    // Half a rectangle, and its axes. That of a segment lies along the axis as it is seen: one across would be mostly
    // empty.
    vec2 sides = vec2(reach(right), reach(up));
    mat2 frame = mat2(1.0);
#if (KINDS & 2) != 0
    if (IS(SEGMENT)) {
        vec2 along = vec2(right.z, up.z);
        float seen_length = length(along);
        along = seen_length > 1e-6 ? along / seen_length : vec2(1.0, 0.0);
        sides = vec2(shape.y * seen_length + shape.z, shape.z);
        frame = mat2(along, vec2(-along.y, along.x));
    }
#endif
    // Half a pixel more, so that no ray at the edge is lost to rounding. In perspective what is before the centre's
    // height is larger, and farther out.
    float margin = 0.5 / (pixels * larger);
#ifdef PERSPECTIVE
    margin += (length(seen.xy) + length(sides)) * before / max(distance_ - height - before, 0.05 * distance_);
#endif
    offset = frame * (corner * (sides + margin));
#ifdef PERSPECTIVE
    sight = (seen.xy + offset) * larger / distance_;
#endif
    // In units of the body's size sums and products keep their digits.
    unit = shape.x == SEGMENT || shape.x == CIRCLE ? shape.y + shape.z : max(shape.y, max(shape.z, shape.w));
    body = vec4(shape.x, shape.yzw / unit);
#ifdef CUT
    cutter = vec4(cut_normal, cut_offset / unit);
#endif
    label = uvec2(uint(row), packed_colour(linear(oklab())) | outline(thickness() * pixels * larger) << 24);
    front = 0.5 - (height + before) / (2.0 * depth);
    gl_Position = vec4((seen.xy + offset) * larger / half_size, 2.0 * front - 1.0, 1.0);
}
