#version 300 es
// A body as a rectangle that just covers it, seen by a parallel projection.
precision highp float;
precision highp int;

layout(location = 0) in vec3 place;  // the centre, from the run's middle
layout(location = 1) in vec4 turn;   // x, y, z, w: from body axes to space
layout(location = 2) in vec4 shape;  // the kind, and its three numbers
layout(location = 3) in float part;  // the place on the scale of colours; below zero: none; below -1.5: hidden

uniform mat3 axes;       // right, up and toward, as columns
uniform vec3 middle;     // what stands in the middle of the picture
uniform vec2 half_size;  // lengths from the middle of the picture to its right and upper edge
uniform float depth;     // all bodies are nearer to the middle than this, along the line of sight
uniform float pixels;    // pixels to a length of one
uniform int colour;      // 0 by the scale, 1 by the orientation, 2 plain, 3 by a hue of the body's own
uniform float distance_; // of the eye from the middle of the picture; 0: a parallel projection
uniform vec4 cut;        // bodies whose centres are beyond this plane are hidden: its normal, its offset

flat out vec3 right;
flat out vec3 up;
flat out vec3 toward;
flat out vec4 body;
flat out float height;
flat out float unit;
flat out uvec2 label;
out vec2 offset;
out float front;

const float POINT = 0.0, SEGMENT = 1.0, CIRCLE = 2.0;
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

// How far the body reaches along a unit vector in its own axes.
float reach(vec3 e) {
    if (shape.x == POINT) return shape.z;
    if (shape.x == SEGMENT) return shape.z + shape.y * abs(e.z);
    if (shape.x == CIRCLE) return shape.z + shape.y * length(e.xy);
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
    vec4 back = vec4(-turn.xyz, turn.w);
    right = to_space(back, axes[0]);
    up = to_space(back, axes[1]);
    toward = to_space(back, axes[2]);
    vec3 seen = (place - middle) * axes;
    if (part < -1.5 || dot(cut.xyz, place) > cut.w || (distance_ > 0.0 && seen.z > 0.9 * distance_)) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    // A body is as large as its centre's distance makes it; it is not drawn in perspective itself.
    float larger = distance_ > 0.0 ? distance_ / (distance_ - seen.z) : 1.0;
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    if (shape.x == SEGMENT) {
        // Along the axis as it is seen: a rectangle across would be mostly empty.
        vec2 along = vec2(right.z, up.z);
        float seen_length = length(along);
        along = seen_length > 1e-6 ? along / seen_length : vec2(1.0, 0.0);
        offset = along * corner.x * (shape.y * seen_length + shape.z) + vec2(-along.y, along.x) * corner.y * shape.z;
    } else {
        offset = corner * vec2(reach(right), reach(up));
    }
    // Half a pixel more, so that no ray at the edge is lost to rounding.
    offset += sign(offset) * 0.5 / (pixels * larger);
    height = seen.z;
    // In units of the body's size sums and products keep their digits.
    unit = shape.x == SEGMENT || shape.x == CIRCLE ? shape.y + shape.z : max(shape.y, max(shape.z, shape.w));
    body = vec4(shape.x, shape.yzw / unit);
    label = uvec2(uint(gl_InstanceID), packed_colour(linear(oklab())) | outline(thickness() * pixels * larger) << 24);
    front = 0.5 - (height + reach(toward)) / (2.0 * depth);
    gl_Position = vec4((seen.xy + offset) * larger / half_size, 2.0 * front - 1.0, 1.0);
}
