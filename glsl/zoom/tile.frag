#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Light on the zoom's surface, and marks on it that show its tiles.

#include "lib/frame.glsl"
#include "lib/sky.glsl"

layout(location = 0) in vec3 place;
layout(location = 1) in vec2 slope;
layout(location = 2) in vec3 albedo;
layout(location = 3) in float relief;
layout(location = 4) in vec2 grid;
layout(location = 5) flat in uint level;

layout(constant_id = 0) const uint BITS = 7u;
layout(constant_id = 2) const bool LEVELS = false;      // tiles have the colours of their levels
layout(constant_id = 3) const bool BORDERS = false;     // lines around tiles
layout(constant_id = 4) const bool WIREFRAME = false;   // and around triangles

const uint LEVEL_COLOURS = 7u;

// What marks look like (zoom/marks.rs).
layout(binding = 5, scalar) uniform TileMarks {
    vec3 levels[LEVEL_COLOURS]; // reflectances; levels take turns
    vec3 border;                // radiance
    vec3 edge;
    float width;                // of an edge's line, samples; a border's is twice as wide, or four times with its case
} marks;

// Radiance, cd/m², and the distance.
layout(location = 0) out vec4 radiance;

// What lies in the open has all of the sky, hollows have half of it and what the ground around sends.
vec3 light(vec3 normal, vec3 albedo) {
    float openness = mix(0.45, 1.0, smoothstep(-0.7, 0.3, relief)) * (0.5 + 0.5 * normal.y);
    vec3 sun = frame.sun_irradiance * max(dot(normal, frame.sun_direction), 0.0);
    vec3 around = albedo * (frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0)));
    return sun + sky_irradiance(normal) * openness + around * (1.0 - openness);
}

// How much of a sample is covered by a line that goes where `off` is 0. After Bærentzen et al., "Single-pass wireframe rendering", 2006: what a function comes to
// over how much it changes from a sample to the next is a distance in samples.
float covered(float off, vec2 change, float width) {
    return clamp(0.5 * width + 0.5 - abs(off) / max(length(change), 1e-9), 0.0, 1.0);
}

// How columns and rows, a column of this each, change to the next sample across and down.
mat2 change() {
    return transpose(mat2(dFdx(grid), dFdy(grid)));
}

// How much of a sample is covered by the edges of triangles.
float edges(mat2 change) {
    ivec2 cell = ivec2(floor(grid));
    vec2 part = grid - vec2(cell);
    bool rises = ((cell.x ^ cell.y) & 1) == 0;
    float diagonal = rises ? covered(part.x - part.y, change[0] - change[1], marks.width)
                           : covered(part.x + part.y - 1.0, change[0] + change[1], marks.width);
    vec2 off = grid - round(grid);
    return max(diagonal, max(covered(off.x, change[0], marks.width), covered(off.y, change[1], marks.width)));
}

// And by the nearest sides of the tile, lines of that width.
float border(mat2 change, float width) {
    vec2 off = min(grid, float(1 << int(BITS)) - grid);
    return max(covered(off.x, change[0], width), covered(off.y, change[1], width));
}

void main() {
    vec3 normal = normalize(vec3(-slope.x, 1.0, -slope.y));
    vec3 own = LEVELS ? mix(albedo, marks.levels[level % LEVEL_COLOURS], 0.75) : albedo;
    radiance = vec4(own / PI * light(normal, own), length(place));
    if (WIREFRAME) radiance.rgb = mix(radiance.rgb, marks.edge, 0.7 * edges(change()));
    if (BORDERS) {
        // Cased in black, so that they stand out from any ground.
        mat2 change = change();
        radiance.rgb = mix(radiance.rgb, vec3(0.0), border(change, 4.0 * marks.width));
        radiance.rgb = mix(radiance.rgb, marks.border, border(change, 2.0 * marks.width));
    }
}
