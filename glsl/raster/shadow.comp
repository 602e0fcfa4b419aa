#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// The sun's shadow over the whole ground: above every sample, the height (m above the datum) at which the sun's centre
// comes out from behind the ground towards it, and how far away what hides it is. A height interpolates smoothly, so
// the shadow's edge is finer than the grid, and it serves for anything that stands above the ground too.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, rg32f) uniform writeonly image2D shadow;

#include "lib/heightfield.glsl"
#include "lib/coarse.glsl"
#include "lib/sky.glsl"
#include "lib/light.glsl"

void main() {
    ivec2 at = coarse_at();
    if (!on_coarse_grid(at)) return;
    vec2 start = coarse_position(at);
    float level = length(frame.sun_direction.xz);
    float rise = sun_rise();
    // Where nothing hides the sun, far below all light.
    float lowest = height_at(ground_cell(at)) - max(1e4, rise * coarse_cell_size());
    if (level < 1e-4 || frame.sun_direction.y <= 0.0) {
        imageStore(shadow, at, vec4(lowest, 0.0, 0.0, 0.0));
        return;
    }
    vec2 toward = frame.sun_direction.xz / level;
    float stride = coarse_cell_size() / max(abs(toward.x), abs(toward.y));
    float best = lowest;
    float distance_of_best = 0.0;
    // A ray that is above the highest ground meets nothing more.
    int last = int(min(float(2 * push.cells), (frame.top - height_at(ground_cell(at))) / (rise * stride) + 2.0));
    for (int index = 1; index <= last; ++index) {
        float along = float(index) * stride;
        vec2 xz = start + along * toward;
        if (outside(xz) > 0.0) break;
        float shade = height_bilinear(xz) - rise * along;
        if (shade > best) {
            best = shade;
            distance_of_best = along;
        }
    }
    imageStore(shadow, at, vec4(best, distance_of_best, 0.0, 0.0));
}
