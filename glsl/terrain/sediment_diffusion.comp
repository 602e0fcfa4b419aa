#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// One more sweep of the diffusion of suspended sediment, where a single one would not be stable (Korošec & Lebar Bajec (18), as
// a conservative exchange between wet cells).

#include "lib/block.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
layout(binding = 0, rgba32f) uniform readonly image2D water;
layout(binding = 1, r32f) uniform readonly image2D sediment_in;
layout(binding = 2, r32f) uniform writeonly image2D sediment_out;
layout(push_constant, scalar) uniform Push { float mixing; } push;

const float DRY = 1e-6;

void main() {
    ivec2 first = first_cell();
    ivec2 size = imageSize(water);
    if (outside(first, size)) return;

    float depth[ROWS + 2][COLUMNS + 2];
    float suspension[ROWS + 2][COLUMNS + 2];
    EACH_WITH_RIM(1, j, i) {
        ivec2 at = clamp(first + ivec2(i, j) - 1, ivec2(0), size - 1);
        depth[j][i] = imageLoad(water, at).x;
        suspension[j][i] = imageLoad(sediment_in, at).x;
    }

    EACH_OWN(j, i) {
        ivec2 cell = first + ivec2(i, j) - 1;
        float sediment = suspension[j][i];
        bvec4 wet = greaterThan(min(vec4(depth[j][i]), AXIS_OF(depth, j, i)), vec4(DRY));
        precise vec4 rise = AXIS_OF(suspension, j, i) - sediment;
        precise float diffused = sediment + push.mixing * sum(mix(vec4(0.0), rise, wet));
        if (!outside(cell, size)) imageStore(sediment_out, cell, vec4(diffused));
    }
}
