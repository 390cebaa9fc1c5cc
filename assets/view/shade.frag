#version 300 es
// Light, contact shadows, cast shadows and outlines, from what the rays have met: as src/render/shade.rs.
precision highp float;
precision highp int;
precision highp usampler2D;
precision highp sampler2D;

uniform usampler2D met;
uniform sampler2D shadow;
uniform int samples;          // rays along a pixel's side: 1 or 2
uniform float sample_length;  // lengths to a sample
uniform float typical;        // thickness in samples of a middling body
uniform vec3 paper;           // linear light of the background
uniform vec3 accent;          // linear light of the outline of the picked body
uniform int picked;           // its row and one more
uniform bool shadows;
uniform mat3 light_axes;      // the light's right, up and toward along the picture's right, up and toward, as columns
uniform vec3 light_middle;    // what stands in the middle of the light's picture, as the picture's right, up and toward
uniform vec3 light_scale;     // lengths from that middle to its edges; the depth
uniform float distance_;      // of the eye from the picture's middle; 0: a parallel projection
uniform vec3 haze;            // how much of the farthest is the paper; the height where it begins; 1 over its depth
uniform float softness;       // half the width of a shadow's edge, in the light's samples

out vec4 light_out;

const vec3 KEY_LIGHT = vec3(-0.46, 0.60, 0.655);
const vec3 FILL_LIGHT = vec3(0.72, -0.25, 0.647);
const vec3 HALFWAY = vec3(-0.2529, 0.3298, 0.9095);
const int NEIGHBOURS = 11;
const vec2 PLACES[4] = vec2[4](vec2(0.9, 0.2), vec2(-0.15, 0.65), vec2(-0.6, -0.1), vec2(0.25, -0.95));

ivec2 size;

uvec4 near(ivec2 at) {
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) return uvec4(0u);
    return texelFetch(met, at, 0);
}

float height_of(uvec4 it) {
    return it.x == 0u ? -3e38 : uintBitsToFloat(it.y);
}

// How far the darkening near contacts reaches, in samples.
float reach() {
    return min(typical * 1.5, float(size.y) * 0.06);
}

float open(ivec2 at, float height, vec3 normal, int ray, int rays) {
    float samples_reached = reach();
    if (samples_reached < 1.5) return 1.0;
    float turn = float(ray) / float(rays);
    float length_reached = samples_reached * sample_length;
    float sum = 0.0;
    for (int k = 0; k < NEIGHBOURS; k++) {
        float part = (float(k) + 0.5 + turn) / (float(NEIGHBOURS) + 0.5);
        float angle = 6.2831853 * (part * 3.0 + turn);
        vec2 offset = round(vec2(cos(angle), -sin(angle)) * samples_reached * pow(part, 1.5));
        uvec4 other = near(at + ivec2(offset));
        if (other.x == 0u) continue;
        vec3 to = vec3(offset * sample_length, uintBitsToFloat(other.y) - height);
        float squared = dot(to, to);
        float above = dot(to, normal) - 0.06 * sqrt(squared);
        sum += max(above, 0.0) / (squared + 0.01 * length_reached * length_reached);
    }
    return max(1.0 - length_reached * sum / float(NEIGHBOURS), 0.0);
}

bool edge(ivec2 at, ivec2 offset, uvec4 here) {
    uvec4 other = near(at + offset);
    return other.x != here.x && height_of(other) <= height_of(here);
}

// Whether a body's own edge in front of another one or of nothing is so near.
bool at_edge(ivec2 at, uvec4 here, int width) {
    bool found = edge(at, ivec2(width, 0), here) || edge(at, ivec2(-width, 0), here)
        || edge(at, ivec2(0, width), here) || edge(at, ivec2(0, -width), here);
    if (found || width == 1) return found;
    int w = (width * 5 + 3) / 7;
    return edge(at, ivec2(w, w), here) || edge(at, ivec2(-w, w), here) || edge(at, ivec2(w, -w), here)
        || edge(at, ivec2(-w, -w), here);
}

// The part of the main light that reaches a point.
float lit(ivec2 at, float height, vec3 normal, int ray) {
    if (!shadows) return 1.0;
    vec3 point = vec3((vec2(at) + 0.5 - 0.5 * vec2(size)) * sample_length, height);
    vec2 side = vec2(textureSize(shadow, 0));
    float light_sample = 2.0 * light_scale.x / side.x;
    if (distance_ > 0.0) point.xy *= (distance_ - height) / distance_;
    vec3 seen = (point + normal * (1.5 * softness * light_sample) - light_middle) * light_axes;
    float turn = float(ray) * 0.39269908;
    mat2 turned = mat2(cos(turn), sin(turn), -sin(turn), cos(turn)) * softness;
    float dark = 0.0;
    for (int k = 0; k < 4; k++) {
        vec2 place = (0.5 + 0.5 * seen.xy / light_scale.xy) * side + turned * PLACES[k];
        ivec2 cell = ivec2(floor(place));
        if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, ivec2(side)))) continue;
        float depth = texelFetch(shadow, cell, 0).x;
        if (depth < 1.0 && (0.5 - depth) * 2.0 * light_scale.z > seen.z) dark += 0.25;
    }
    return 1.0 - dark;
}

vec3 light(ivec2 at, uvec4 here, int ray) {
    vec2 across = unpackSnorm2x16(here.z);
    vec3 normal = vec3(across, sqrt(max(1.0 - dot(across, across), 0.0)));
    float height = uintBitsToFloat(here.y);
    vec3 colour = vec3(uvec3(here.w, here.w >> 8, here.w >> 16) & 255u) / 255.0;
    colour *= colour;
    uint line = here.w >> 24;
    float strength = float(line & 63u) / 63.0;
    float drawn = strength > 0.0 && at_edge(at, here, 1 + int(line >> 6)) ? strength : 0.0;
    float opened = open(at, height, normal, ray, samples * samples);
    float ambient = 0.16 + 0.18 * (0.5 + 0.5 * normal.y);
    float key = 0.78 * max(dot(normal, KEY_LIGHT), 0.0) * lit(at, height, normal, ray);
    float direct = key + 0.16 * max(dot(normal, FILL_LIGHT), 0.0);
    float gleam = 0.13 * pow(max(dot(normal, HALFWAY), 0.0), 24.0) * key;
    vec3 shown = (colour * (ambient * opened + direct * (0.35 + 0.65 * opened)) + gleam * opened) * (1.0 - 0.84 * drawn);
    shown = mix(shown, paper, haze.x * clamp((haze.y - height) * haze.z, 0.0, 1.0));
    if (int(here.x) == picked) {
        bool rim = at_edge(at, here, max(2 * samples, 2)) || at_edge(at, here, samples);
        shown = rim ? accent : mix(shown, accent, 0.25);
    }
    return shown;
}

vec3 encoded(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
    size = textureSize(met, 0);
    ivec2 first = ivec2(gl_FragCoord.xy) * samples;
    vec3 sum = vec3(0.0);
    int rays = samples * samples;
    for (int ray = 0; ray < rays; ray++) {
        // Rays are numbered from the top left of a pixel.
        ivec2 at = first + ivec2(ray % samples, samples - 1 - ray / samples);
        uvec4 here = texelFetch(met, at, 0);
        sum += here.x == 0u ? paper : light(at, here, ray);
    }
    light_out = vec4(encoded(clamp(sum / float(rays), 0.0, 1.0)), 1.0);
}
