#version 300 es
// A straight line as a thin rectangle: of walls, the periodic cell, and contacts.
precision highp float;

layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;

uniform mat3 axes;
uniform vec3 middle;
uniform vec2 half_size;
uniform vec2 pixel;  // lengths to a pixel of the picture, across and up
uniform float width; // in pixels
uniform float distance_; // of the eye from the middle of the picture; 0: a parallel projection

out float height;

void main() {
    vec3 a = (from - middle) * axes;
    vec3 b = (to - middle) * axes;
    if (distance_ > 0.0) {
        a.xy *= distance_ / max(distance_ - a.z, 0.1 * distance_);
        b.xy *= distance_ / max(distance_ - b.z, 0.1 * distance_);
    }
    vec2 along = b.xy - a.xy;
    float seen = length(along);
    along = seen > 0.0 ? along / seen : vec2(1.0, 0.0);
    vec3 end = (gl_VertexID & 1) == 0 ? a : b;
    float side = gl_VertexID < 2 ? -0.5 : 0.5;
    height = end.z;
    gl_Position = vec4((end.xy + vec2(-along.y, along.x) * side * width * pixel) / half_size, 0.0, 1.0);
}
