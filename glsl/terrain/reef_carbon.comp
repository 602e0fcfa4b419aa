#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Carbon spreads through the water (Korošec & Lebar Bajec (27, 28), as a conservative exchange between neighbours).

#include "lib/block.glsl"
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
    ivec2 first = first_cell();
    ivec2 size = imageSize(carbon_in);
    if (outside(first, size)) return;

    float carbon[ROWS + 2][COLUMNS + 2];
    EACH_WITH_RIM(1, j, i) {
        carbon[j][i] = imageLoad(carbon_in, clamp(first + ivec2(i, j) - 1, ivec2(0), size - 1)).x;
    }

    EACH_OWN(j, i) {
        ivec2 cell = first + ivec2(i, j) - 1;
        ivec2 own = min(cell, size - 1); // for loads: the last blocks may reach beyond the grid
        bool rim = !all(stencil(cell, size).axis);
        float concentration = carbon[j][i];
        vec4 axis = AXIS_OF(carbon, j, i);
        precise float gained = sum(mix(axis - concentration, vec4(0.0), lessThan(axis, vec4(0.0))));
        precise float mixed = concentration + push.mixing * gained;
        float depth = push.sea_level - imageLoad(height, own).x;
        if (!outside(cell, size)) {
            imageStore(carbon_out, cell, vec4(held(mixed, depth, rim, push.ocean_carbon, push.ocean_depth)));
        }
    }
}
