#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Octaves of simplex noise, their domain warped by three more (Korošec & Lebar Bajec (3)).

#include "lib/combine.glsl"
#include "lib/grid.glsl"
#include "lib/noise.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform image2D height;
layout(push_constant, scalar) uniform Push {
    vec2 origin;
    float cell_size;
    float amplitude;
    float offset;
    float wavelength;
    uint octaves;
    float warp;
    uint seed;
    float reference;
} push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height))) return;

    vec2 p = push.origin + vec2(cell) * push.cell_size;
    if (push.warp != 0.0) {
        p += push.warp
            * vec2(octaves(p, push.wavelength, 3u, mix_bits(push.seed ^ 0x9e3779b9u)),
                   octaves(p, push.wavelength, 3u, mix_bits(push.seed ^ 0x85ebca6bu)));
    }
    float value = push.offset + push.amplitude * octaves(p, push.wavelength, push.octaves, push.seed);
    imageStore(height, cell, vec4(combine(imageLoad(height, cell).x, value, push.reference)));
}
