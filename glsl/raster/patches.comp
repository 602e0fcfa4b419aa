#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Bounds of every patch of ground: for framing, culling and marching.

#include "lib/patch.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, r32f) uniform readonly image2D height;
layout(binding = 1, scalar) writeonly buffer Patches { Patch patches[]; };

layout(push_constant, scalar) uniform Push {
    int cells;
    int patches_per_side;
} push;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, ivec2(push.patches_per_side)))) return;
    // A cubic reaches one sample further on both sides.
    ivec2 first = max(at * (push.cells - 1) / push.patches_per_side - 1, ivec2(0));
    ivec2 last = min((at + 1) * (push.cells - 1) / push.patches_per_side + 2, ivec2(push.cells - 1));
    Patch bounds = Patch(1e30, -1e30);
    for (int row = first.y; row <= last.y; ++row) {
        for (int column = first.x; column <= last.x; ++column) {
            float ground = imageLoad(height, ivec2(column, row)).x;
            bounds.least = min(bounds.least, ground);
            bounds.greatest = max(bounds.greatest, ground);
        }
    }
    patches[at.y * push.patches_per_side + at.x] = bounds;
}
