// The sample of an invocation of a program that shades one kind: tiles of samples stand in a list. The includer declares `range` and, in its push
// constants, `first_tile`.
#ifndef OWN_PART_GLSL
#define OWN_PART_GLSL

#include "lib/parts.glsl"

layout(constant_id = 0) const uint PART = 0;
layout(constant_id = 1) const uint SKY = 0;

#define SKY_KIND SKY

layout(binding = 20, scalar) readonly buffer Tiles { uint tiles[]; };   // row · 2¹⁶ + column

ivec2 own_sample() {
    uint tile = tiles[push.first_tile + gl_WorkGroupID.x];
    return ivec2(tile & 0xffffu, tile >> 16) * TILE_SIDE + ivec2(gl_LocalInvocationID.xy);
}

#endif
