#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Carbon spreads through the water (Korošec & Lebar Bajec (27, 28), as a conservative exchange between neighbours).

#include "lib/grid.glsl"
#include "lib/carbon.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
layout(binding = 0, r32f) uniform readonly image2D carbon_in;
layout(binding = 1, r32f) uniform writeonly image2D carbon_out;
layout(binding = 2, r32f) uniform readonly image2D height;
layout(push_constant, scalar) uniform Push {
    float mixing; // with each neighbour
    float sea_level;
    float ocean_carbon;
    float ocean_depth;
} push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(carbon_in))) return;

    Stencil at = stencil(cell, imageSize(carbon_in));
    float concentration = imageLoad(carbon_in, cell).x;
    vec4 axis = AXIS(carbon_in, at);
    precise float gained = sum(mix(axis - concentration, vec4(0.0), lessThan(axis, vec4(0.0))));
    precise float mixed = concentration + push.mixing * gained;
    float depth = push.sea_level - imageLoad(height, cell).x;
    imageStore(carbon_out, cell, vec4(held(mixed, depth, !all(at.axis), push.ocean_carbon, push.ocean_depth)));
}
