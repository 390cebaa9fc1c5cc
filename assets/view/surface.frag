#version 300 es
// Translucent walls: fainter where they are seen flat on, darker where bodies shade them, nothing behind bodies.
precision highp float;
precision highp int;
precision highp usampler2D;
precision highp sampler2D;

in vec3 point;
in vec3 normal;

uniform usampler2D met;
uniform sampler2D shadow;
uniform int samples;
uniform vec3 ink;
uniform bool shadows;
uniform mat3 light_axes;
uniform vec3 light_middle;
uniform vec3 light_scale;
uniform float softness;

out vec4 light_out;

// What is left of the ink where a wall is seen flat on, what a grazing look adds, and what a full shadow adds.
const float FLAT = 0.07, GRAZING = 0.13, SHADED = 0.22;
const int RINGS = 3, TURNS = 8;

// The part of the main light that bodies keep from the wall, softer than on bodies: walls are far from most of them.
float shade() {
    vec3 seen = (point - light_middle) * light_axes;
    vec2 side = vec2(textureSize(shadow, 0));
    float dark = 0.0;
    for (int k = 0; k < RINGS * TURNS; k++) {
        float angle = 6.2831853 * (float(k % TURNS) + 0.5 * float(k / TURNS)) / float(TURNS);
        float far = 2.5 * softness * (float(k / TURNS) + 0.5) / float(RINGS);
        ivec2 cell = ivec2(floor((0.5 + 0.5 * seen.xy / light_scale.xy) * side + far * vec2(cos(angle), sin(angle))));
        if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, ivec2(side)))) continue;
        float depth = texelFetch(shadow, cell, 0).x;
        if (depth < 1.0 && (0.5 - depth) * 2.0 * light_scale.z > seen.z) dark += 1.0;
    }
    return dark / float(RINGS * TURNS);
}

void main() {
    uvec4 here = texelFetch(met, ivec2(gl_FragCoord.xy) * samples, 0);
    if (here.x != 0u && uintBitsToFloat(here.y) > point.z) discard;
    float flat_on = abs(normalize(normal).z);
    float alpha = FLAT + GRAZING * (1.0 - flat_on) + (shadows ? SHADED * shade() : 0.0);
    light_out = vec4(ink * alpha, alpha);
}
