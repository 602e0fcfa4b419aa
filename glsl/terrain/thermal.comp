#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Thermal erosion: where the ground is steeper than the angle of repose, debris slides to lower neighbours (Jákó & Tóth 2011;
// Korošec & Lebar Bajec (20–22), with shares by the difference in height). Gathering: what a neighbour gives is worked
// out again here, in the same order of operations, so that nothing is lost between the two.

#include "lib/grid.glsl"

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
    float top;              // only cells below this give
} push;

const float NOWHERE = 1e30; // higher than any ground: nothing slides off the grid

float height_at(ivec2 cell, ivec2 size) {
    float h = imageLoad(height_in, clamp(cell, ivec2(0), size - 1)).x;
    return outside(cell, size) ? NOWHERE : h;
}

// What a cell gives for each metre of drop to a steeper neighbour.
float gives(float h, vec4 axis_drop, vec4 diagonal_drop, float rise) {
    vec4 axis_excess = axis_drop - rise;
    vec4 diagonal_excess = diagonal_drop - SQRT2 * rise;
    float moved = LAW == 0u ? max(max4(axis_excess), max4(diagonal_excess)) : max(max4(axis_drop), max4(diagonal_drop));
    float steep = sum(mix(vec4(0.0), axis_drop, greaterThan(axis_excess, vec4(0.0))),
                      mix(vec4(0.0), diagonal_drop, greaterThan(diagonal_excess, vec4(0.0))));
    return steep > 0.0 && h < push.top ? push.half_rate * moved / steep : 0.0;
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(height_in);
    if (outside(cell, size)) return;

    float h[25];
    for (int k = 0; k < 25; ++k) {
        h[k] = height_at(cell + ivec2(k % 5, k / 5) - 2, size);
    }
    const int OFFSET[8] = int[8](-1, 1, -5, 5, -6, -4, 4, 6);

    float rate[9]; // of the neighbours in the order of OFFSET, then of the cell itself
    float rise[9];
    for (int n = 0; n < 9; ++n) {
        int k = n < 8 ? 12 + OFFSET[n] : 12;
        vec4 axis = h[k] - vec4(h[k - 1], h[k + 1], h[k - 5], h[k + 5]);
        vec4 diagonal = h[k] - vec4(h[k - 6], h[k - 4], h[k + 4], h[k + 6]);
        rise[n] = h[k] < push.sea_level ? push.rise_under_water : push.rise_on_land;
        rate[n] = h[k] < NOWHERE ? gives(h[k], axis, diagonal, rise[n]) : 0.0;
    }

    float flow[8];
    float own_mask = CONTROLS ? imageLoad(controls, cell).z : 1.0;
    for (int n = 0; n < 8; ++n) {
        float length = n < 4 ? 1.0 : SQRT2;
        precise float drop = h[12] - h[12 + OFFSET[n]];
        precise float given = drop > rise[8] * length ? rate[8] * drop : 0.0;
        precise float taken = -drop > rise[n] * length ? rate[n] * -drop : 0.0;
        float mask = 1.0;
        if (CONTROLS) {
            ivec2 neighbour = cell + ivec2((OFFSET[n] + 12) % 5, (OFFSET[n] + 12) / 5) - 2;
            mask = min(own_mask, imageLoad(controls, clamp(neighbour, ivec2(0), size - 1)).z);
        }
        flow[n] = (taken - given) * mask;
    }
    precise float moved = sum(vec4(flow[0], flow[1], flow[2], flow[3]), vec4(flow[4], flow[5], flow[6], flow[7]));
    precise float e = imageLoad(change, cell).x + moved;
    precise float grown = imageLoad(start, cell).x + e;
    imageStore(change, cell, vec4(e));
    imageStore(height_out, cell, vec4(grown));
}
