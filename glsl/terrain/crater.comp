#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Mirrors what stands above a level down into a crater (Korošec & Lebar Bajec (5)).

#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform image2D height;
layout(push_constant, scalar) uniform Push { float level; } push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height))) return;

    float h = imageLoad(height, cell).x;
    imageStore(height, cell, vec4(h > push.level ? 2.0 * push.level - h : h));
}
