#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// One layer of the land, for files and renderers. Images of processes that the world does not have are a single texel, of zeros.

#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform readonly image2D height;
layout(binding = 1, r32f) uniform readonly image2D change;
layout(binding = 2, rgba32f) uniform readonly image2D water;
layout(binding = 3, r32f) uniform readonly image2D sediment;
layout(binding = 4, rgba32f) uniform readonly image2D axis;
layout(binding = 5, rgba32f) uniform readonly image2D diagonal;
layout(binding = 6, r32f) uniform readonly image2D reef;
layout(binding = 7, r32f) uniform writeonly image2D layer_out;
layout(push_constant, scalar) uniform Push {
    uint layer; // height, water, sediment, wear, deposit, reef, flow, wetness
    float sea_level;        // now
    float sea_of_rivers;    // while rivers ran
    float wet_memory;
} push;

#define LOAD(image) imageLoad(image, min(cell, imageSize(image) - 1))

float value(ivec2 cell) {
    float h = LOAD(height).x;
    bool sea = h < push.sea_level;
    // Where a reef, or a fall of the sea, has made land since the rivers ran, what stood here was the sea.
    bool risen = h - LOAD(reef).x < push.sea_of_rivers;
    switch (push.layer) {
        case 0u: return h;
        case 1u: return sea || risen ? 0.0 : LOAD(water).x;
        case 2u: return LOAD(sediment).x;
        case 3u: return max(0.0, -LOAD(change).x);
        case 4u: return max(0.0, LOAD(change).x);
        case 5u: return max(0.0, LOAD(reef).x);
        case 6u: return sum(LOAD(axis), LOAD(diagonal));
        default: return sea ? 1.0 : risen ? 0.0 : clamp(LOAD(water).w / push.wet_memory, 0.0, 1.0);
    }
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(layer_out))) return;

    imageStore(layer_out, cell, vec4(value(cell)));
}
