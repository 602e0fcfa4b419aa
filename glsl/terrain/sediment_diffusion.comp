#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// One more sweep of the diffusion of suspended sediment, where a single one would not be stable (Korošec & Lebar Bajec (18), as
// a conservative exchange between wet cells).

#include "lib/block.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, rgba32f) uniform readonly image2D water;
layout(binding = 1, r32f) uniform readonly image2D sediment_in;
layout(binding = 2, r32f) uniform writeonly image2D sediment_out;
layout(push_constant, scalar) uniform Push { float mixing; } push;

const float DRY = 1e-6;

void main() {
    ivec2 first = first_cell();
    ivec2 size = imageSize(water);
    if (outside(first, size)) return;

    vec3 depth[ROWS + 2];
    vec3 suspension[ROWS + 2];
    [[unroll]] for (int j = 0; j < ROWS + 2; ++j) {
        Row at = row(first, j, size);
        depth[j] = ROW(water, at);
        suspension[j] = ROW(sediment_in, at);
    }

    [[unroll]] for (int j = 1; j <= ROWS; ++j) {
        ivec2 cell = first + ivec2(0, j - 1);
        float sediment = suspension[j].y;
        bvec4 wet = greaterThan(min(vec4(depth[j].y), axis_of(depth[j - 1], depth[j], depth[j + 1])), vec4(DRY));
        precise vec4 rise = axis_of(suspension[j - 1], suspension[j], suspension[j + 1]) - sediment;
        precise float diffused = sediment + push.mixing * sum(mix(vec4(0.0), rise, wet));
        if (cell.y < size.y) imageStore(sediment_out, cell, vec4(diffused));
    }
}
