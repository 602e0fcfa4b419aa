#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Coral builds the bed up where light and carbon reach it, and uses carbon up (Nakamura & Nakamori 2007; Korošec & Lebar Bajec
// (24–26, 29)). Each invocation touches its own cell alone.

#include "lib/grid.glsl"
#include "lib/carbon.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(constant_id = 0) const bool CONTROLS = false;
layout(binding = 0, r32f) uniform image2D reef;
layout(binding = 1, r32f) uniform image2D carbon;
layout(binding = 2, r32f) uniform writeonly image2D height;
layout(binding = 3, r32f) uniform readonly image2D bed;
layout(binding = 4, rgba32f) uniform readonly image2D controls;
layout(push_constant, scalar) uniform Push {
    float sea_level;
    float growth;      // in one step where there is full light and carbon is 1, m
    float light_decay;
    float max_depth;
    float uptake;
    float keep;
    float ocean_carbon;
    float ocean_depth;
} push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(reef))) return;

    float ground = imageLoad(bed, cell).x;
    precise float thickness = imageLoad(reef, cell).x;
    float concentration = max(0.0, imageLoad(carbon, cell).x);

    precise float depth = push.sea_level - (ground + thickness);
    bool lives = depth > 0.0 && depth < push.max_depth;
    float calcified =
        lives ? concentration * concentration * push.growth * exp(-push.light_decay * depth) : 0.0;
    // Where the mask holds coral back, it takes less carbon, too.
    if (CONTROLS) calcified *= imageLoad(controls, cell).z;
    thickness += min(calcified, max(0.0, depth - push.keep));
    concentration = max(0.0, concentration - push.uptake * calcified / max(depth, 0.5));

    precise float grown = ground + thickness;
    depth = push.sea_level - grown;
    bool rim = !all(stencil(cell, imageSize(reef)).axis);
    imageStore(reef, cell, vec4(thickness));
    imageStore(height, cell, vec4(grown));
    imageStore(carbon, cell, vec4(held(concentration, depth, rim, push.ocean_carbon, push.ocean_depth)));
}
