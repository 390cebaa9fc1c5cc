#version 300 es
// Faint behind bodies.
precision highp float;
precision highp int;
precision highp usampler2D;

in float height;

uniform usampler2D met;
uniform int samples;
uniform vec4 ink;
uniform float behind; // what is left of the ink there

out vec4 light_out;

void main() {
    uvec4 here = texelFetch(met, ivec2(gl_FragCoord.xy) * samples, 0);
    bool hidden = here.x != 0u && uintBitsToFloat(here.y) > height;
    float alpha = ink.a * (hidden ? behind : 1.0);
    light_out = vec4(ink.rgb * alpha, alpha);
}
