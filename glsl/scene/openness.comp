#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// How much of the sky's light the ground's own shape lets through, 0…1, weighted with the cosine to the ground's normal.
// Horizon angles in sixteen directions; within each the integral over elevation is closed (after Max 1988, "Horizon
// mapping", and Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion").

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, r32f) uniform writeonly image2D openness;

#include "lib/heightfield.glsl"
#include "lib/coarse.glsl"

const int DIRECTIONS = 16;
const int STEPS = 16;

// What the part of the sky above elevation `e` gives, in a direction in which the unit normal leans by `lean` and
// rises by `rise`.
float slice(float e, float rise, float lean) {
    float s = sin(e);
    return 0.5 * rise * (1.0 - s * s) + 0.5 * lean * (0.5 * PI - e - s * cos(e));
}

void main() {
    ivec2 at = coarse_at();
    if (!on_coarse_grid(at)) return;
    float here = height_at(ground_cell(at));
    vec2 slope = height_slope(coarse_position(at));
    vec3 normal = normal_from_slope(slope);
    // Steps grow until they reach a fifth of the grid.
    float growth = pow(0.2 * float(push.cells), 1.0 / float(STEPS - 1));
    float seen = 0.0;
    float all = 0.0;
    for (int direction = 0; direction < DIRECTIONS; ++direction) {
        float azimuth = 2.0 * PI * (float(direction) + 0.5) / float(DIRECTIONS);
        vec2 toward = vec2(cos(azimuth), sin(azimuth));
        float steepest = 0.0;
        float reach = 1.0;
        for (int index = 0; index < STEPS; ++index) {
            ivec2 offset = ivec2(round(toward * reach));
            vec2 run = vec2(offset) * coarse_cell_size();
            float rise = height_at(ground_cell(at + offset)) - here;
            // What only continues the ground's own slope hides nothing more.
            if (rise > dot(slope, run) + 1e-3 * length(run)) steepest = max(steepest, rise / length(run));
            reach *= growth;
        }
        float lean = dot(normal.xz, toward);
        float own = max(atan(-lean, normal.y), 0.0);
        seen += slice(max(atan(steepest), own), normal.y, lean);
        all += slice(own, normal.y, lean);
    }
    imageStore(openness, at, vec4(clamp(seen / all, 0.0, 1.0), 0.0, 0.0, 0.0));
}
