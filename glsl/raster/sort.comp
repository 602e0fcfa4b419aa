#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// What each tile of samples shows: a bit for every kind.

#include "lib/frame.glsl"
#include "lib/parts.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, r32ui) uniform writeonly uimage2D parts;

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, imageSize(parts)))) return;
    ivec2 last = imageSize(range) - 1;
    uint found = 0u;
    for (int index = 0; index < TILE_SIDE * TILE_SIDE; ++index) {
        ivec2 at = min(tile * TILE_SIDE + ivec2(index % TILE_SIDE, index / TILE_SIDE), last);
        float path;
        found |= 1u << part_of(camera_ray(vec2(at) + 0.5), imageLoad(range, at).x, path);
    }
    imageStore(parts, tile, uvec4(found));
}
