#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Where waves from the open sea arrive, 0…1: the share of seaward directions in which the water stays deep enough for
// them all the way in. Behind a reef it is calm, but for its passes.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, r32f) uniform writeonly image2D surf;

#include "lib/heightfield.glsl"
#include "lib/coarse.glsl"

const int DIRECTIONS = 16;
const float FETCH = 5000.0;        // metres of open water that make waves
const float BREAKING_DEPTH = 1.5;  // metres
const float BREAKING_ZONE = 40.0;  // metres that a breaker runs on

void main() {
    ivec2 at = coarse_at();
    if (!on_coarse_grid(at)) return;
    float depth = frame.sea_level - height_at(ground_cell(at));
    if (depth < -4.0 || depth > 14.0) {
        imageStore(surf, at, vec4(0.0));
        return;
    }
    float stride = max(1.5, FETCH / coarse_cell_size() / 160.0);
    int steps = int(FETCH / coarse_cell_size() / stride);
    float first = max(BREAKING_ZONE / coarse_cell_size(), 1.5);
    int open = 0;
    for (int direction = 0; direction < DIRECTIONS; ++direction) {
        float azimuth = 2.0 * PI * (float(direction) + 0.5) / float(DIRECTIONS);
        vec2 toward = vec2(cos(azimuth), sin(azimuth));
        bool blocked = false;
        for (int index = 0; index < steps && !blocked; ++index) {
            ivec2 cell = at + ivec2(round(toward * (first + float(index) * stride)));
            if (!on_coarse_grid(cell)) break;
            blocked = height_at(ground_cell(cell)) > frame.sea_level - BREAKING_DEPTH;
        }
        open += blocked ? 0 : 1;
    }
    imageStore(surf, at, vec4(clamp(float(open) / float(DIRECTIONS / 3), 0.0, 1.0), 0.0, 0.0, 0.0));
}
