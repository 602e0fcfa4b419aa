#version 460
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Thermal erosion: where the ground is steeper than the angle of repose, debris slides to lower neighbours (Jákó & Tóth 2011;
// Korošec & Lebar Bajec (20–22), with shares by the difference in height). Gathering: what a neighbour gives is worked
// out again here, in the same order of operations, so that nothing is lost between the two.

#include "lib/block.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
// How much moves: half of the excess over the repose slope, or half of the whole drop.
layout(constant_id = 0) const uint LAW = 0;
layout(constant_id = 1) const bool CONTROLS = false;
layout(binding = 0, r32f) uniform readonly image2D height_in;
layout(binding = 1, r32f) uniform writeonly image2D height_out;
layout(binding = 2, r32f) uniform image2D change;
layout(binding = 3, r32f) uniform readonly image2D start;
layout(binding = 4, rgba32f) uniform readonly image2D controls;
layout(push_constant, scalar) uniform Push {
    float half_rate;
    float rise_on_land;     // of the repose slope over one cell
    float rise_under_water;
    float sea_level;
    float top;              // only cells below this give; lower than NOWHERE
} push;

const float NOWHERE = 1e30; // higher than any ground: nothing slides off the grid

// What a cell gives for each metre of drop to a steeper neighbour.
float gives(float h, vec4 axis_drop, vec4 diagonal_drop, float rise) {
    bvec4 axis_steep = greaterThan(axis_drop, vec4(rise));
    bvec4 diagonal_steep = greaterThan(diagonal_drop, vec4(SQRT2 * rise));
    float axis_most = max4(axis_drop);
    float diagonal_most = max4(diagonal_drop);
    float moved = LAW == 0u ? max(axis_most - rise, diagonal_most - SQRT2 * rise) : max(axis_most, diagonal_most);
    float steep = sum(mix(vec4(0.0), axis_drop, axis_steep), mix(vec4(0.0), diagonal_drop, diagonal_steep));
    return steep > 0.0 && h < push.top ? push.half_rate * moved / steep : 0.0;
}

void main() {
    ivec2 first = first_cell();
    ivec2 size = imageSize(height_in);
    if (outside(first, size)) return;

    float h[ROWS + 4][COLUMNS + 4];
    EACH_WITH_RIM(2, j, i) {
        ivec2 cell = first + ivec2(i, j) - 2;
        float height = imageLoad(height_in, clamp(cell, ivec2(0), size - 1)).x;
        h[j][i] = outside(cell, size) ? NOWHERE : height;
    }

    float rise[ROWS + 2][COLUMNS + 2];
    float rate[ROWS + 2][COLUMNS + 2];
    EACH_WITH_RIM(1, j, i) {
        float own = h[j + 1][i + 1];
        rise[j][i] = own < push.sea_level ? push.rise_under_water : push.rise_on_land;
        rate[j][i] =
            gives(own, own - AXIS_OF(h, j + 1, i + 1), own - DIAGONAL_OF(h, j + 1, i + 1), rise[j][i]);
    }

    const ivec2 NEIGHBOURS[8] = ivec2[8](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1),
                                         ivec2(-1, -1), ivec2(1, -1), ivec2(-1, 1), ivec2(1, 1));
    EACH_OWN(j, i) {
        ivec2 cell = first + ivec2(i, j) - 1;
        ivec2 own = min(cell, size - 1); // for loads: the last blocks may reach beyond the grid
        float own_mask = CONTROLS ? imageLoad(controls, own).z : 1.0;
        float flow[8];
        [[unroll]] for (int n = 0; n < 8; ++n) {
            ivec2 to = NEIGHBOURS[n];
            float length = n < 4 ? 1.0 : SQRT2;
            precise float drop = h[j + 1][i + 1] - h[j + 1 + to.y][i + 1 + to.x];
            precise float given = drop > rise[j][i] * length ? rate[j][i] * drop : 0.0;
            float rise_there = rise[j + to.y][i + to.x];
            precise float taken = -drop > rise_there * length ? rate[j + to.y][i + to.x] * -drop : 0.0;
            float mask =
                CONTROLS ? min(own_mask, imageLoad(controls, clamp(own + to, ivec2(0), size - 1)).z) : 1.0;
            precise float moved = (taken - given) * mask;
            flow[n] = moved;
        }
        precise float moved = sum(vec4(flow[0], flow[1], flow[2], flow[3]), vec4(flow[4], flow[5], flow[6], flow[7]));
        precise float e = imageLoad(change, own).x + moved;
        precise float grown = imageLoad(start, own).x + e;
        if (!outside(cell, size)) {
            imageStore(change, cell, vec4(e));
            imageStore(height_out, cell, vec4(grown));
        }
    }
}
