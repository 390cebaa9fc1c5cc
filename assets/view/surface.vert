#version 300 es
// Walls as triangles.
precision highp float;

layout(location = 0) in vec3 place;
layout(location = 1) in vec3 across; // the normal

uniform mat3 axes;
uniform vec3 middle;
uniform vec2 half_size;
uniform float distance_; // of the eye from the middle of the picture; 0: a parallel projection

out vec3 point;  // along right, up and toward, from what stands in the middle of the picture
out vec3 normal;

void main() {
    point = (place - middle) * axes;
    normal = across * axes;
    // Depth is of no use: bodies in front are found by their heights.
    if (distance_ > 0.0) {
        // The last number makes what lies between the corners right.
        gl_Position = vec4(point.xy / half_size, 0.0, max((distance_ - point.z) / distance_, 0.05));
    } else {
        gl_Position = vec4(point.xy / half_size, 0.0, 1.0);
    }
}
