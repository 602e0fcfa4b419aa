#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Displaces the divided patch to the ground's height.

#include "lib/frame.glsl"

layout(quads, equal_spacing, cw) in;

layout(binding = 1, r32f) uniform readonly image2D height;

#include "lib/heightfield.glsl"
#include "lib/tile.glsl"

layout(location = 0) patch in ivec2 origin;
layout(location = 0) out vec3 point;

void main() {
    // Patch index plus fraction is exact, so neighbours agree on their common edge to the last bit.
    vec2 at = vec2(origin) + gl_TessCoord.xy;
    vec2 xz = at / float(frame.patches) * frame.extent - 0.5 * frame.extent;
    point = vec3(xz.x, height_cubic(xz), xz.y);
    gl_Position = tile_clip(point);
}
