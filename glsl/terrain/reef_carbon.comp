#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Carbon spreads through the water (Korošec & Lebar Bajec (27, 28), as a conservative exchange between neighbours).

#include "lib/block.glsl"
#include "lib/carbon.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
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
    ivec2 first = first_cell();
    ivec2 size = imageSize(carbon_in);
    if (outside(first, size)) return;

    vec3 carbon[ROWS + 2];
    [[unroll]] for (int j = 0; j < ROWS + 2; ++j) {
        Row at = row(first, j, size);
        carbon[j] = ROW(carbon_in, at);
    }

    [[unroll]] for (int j = 1; j <= ROWS; ++j) {
        ivec2 cell = first + ivec2(0, j - 1);
        bool rim = !all(stencil(cell, size).axis);
        float concentration = carbon[j].y;
        vec4 axis = axis_of(carbon[j - 1], carbon[j], carbon[j + 1]);
        precise float gained = sum(mix(axis - concentration, vec4(0.0), lessThan(axis, vec4(0.0))));
        precise float mixed = concentration + push.mixing * gained;
        float depth = push.sea_level - imageLoad(height, min(cell, size - 1)).x;
        if (cell.y < size.y) {
            imageStore(carbon_out, cell, vec4(held(mixed, depth, rim, push.ocean_carbon, push.ocean_depth)));
        }
    }
}
