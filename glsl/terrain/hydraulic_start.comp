#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// The sea is full before it rains.

#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform readonly image2D height;
layout(binding = 1, rgba32f) uniform writeonly image2D water;
layout(push_constant, scalar) uniform Push { float sea_level; } push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height))) return;

    imageStore(water, cell, vec4(max(0.0, push.sea_level - imageLoad(height, cell).x), 0.0, 0.0, 0.0));
}
