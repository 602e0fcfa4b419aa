#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// One more sweep of the diffusion of suspended sediment, where a single one would not be stable (Korošec & Lebar Bajec (18), as
// a conservative exchange between wet cells).

#include "lib/grid.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
layout(binding = 0, rgba32f) uniform readonly image2D water;
layout(binding = 1, r32f) uniform readonly image2D sediment_in;
layout(binding = 2, r32f) uniform writeonly image2D sediment_out;
layout(push_constant, scalar) uniform Push { float mixing; } push;

const float DRY = 1e-6;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(water))) return;

    Stencil at = stencil(cell, imageSize(water));
    float sediment = imageLoad(sediment_in, cell).x;
    bvec4 wet = greaterThan(min(vec4(imageLoad(water, cell).x), AXIS(water, at)), vec4(DRY));
    precise vec4 rise = AXIS(sediment_in, at) - sediment;
    precise float diffused = sediment + push.mixing * sum(mix(vec4(0.0), rise, wet));
    imageStore(sediment_out, cell, vec4(diffused));
}
