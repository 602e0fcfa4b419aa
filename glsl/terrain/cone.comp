#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// A cone with a curved flank (Korošec & Lebar Bajec (1, 2)).

#include "lib/combine.glsl"
#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform image2D height;
layout(push_constant, scalar) uniform Push {
    vec2 origin; // of cell (0, 0), from the cone's centre
    float cell_size;
    float peak;
    float radius;
    float exponent;
    float reference;
} push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height))) return;

    float r = length(push.origin + vec2(cell) * push.cell_size);
    float value = r < push.radius ? push.peak * (1.0 - pow(r / push.radius, push.exponent)) : 0.0;
    imageStore(height, cell, vec4(combine(imageLoad(height, cell).x, value, push.reference)));
}
