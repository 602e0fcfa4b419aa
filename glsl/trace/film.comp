#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require
// Adds finished paths to their pixels. Each sample is rounded to a whole number of steps, so that sums are exact and come out
// the same in any order, cut and merge.

#include "lib/path.glsl"
#include "lib/film.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, scalar) readonly buffer Paths { Path paths[]; };
layout(binding = 1, scalar) readonly buffer Features { Feature features[]; };
layout(binding = 2, scalar) buffer Film { Pixel film[]; };

layout(binding = 3, scalar) buffer Flaws { Flawed flaws[]; };   // one

layout(push_constant, scalar) uniform Push {
    uint index;         // of the sample
    int first;          // of the pixels that are at work
    int count;
    float exposure;
} push;

bool finite(vec3 value) {
    return !any(isnan(value)) && !any(isinf(value));
}

void main() {
    int slot = int(gl_GlobalInvocationID.x);
    if (slot >= push.count) return;
    vec3 radiance = push.exposure * paths[slot].radiance;
    Feature feature = features[slot];
    bool sound = finite(radiance) && finite(feature.albedo) && finite(feature.normal) && finite(feature.position)
              && finite(vec3(feature.depth));
    if (!sound) {
        atomicAdd(flaws[0].not_finite, 1u);
        return;
    }
    // Depths and positions at the horizon of a sea may be as far off as they like.
    if (any(greaterThan(abs(radiance), vec3(LARGEST / STEPS)))) atomicAdd(flaws[0].cut_off, 1u);
    Pixel pixel = film[push.first + slot];
    for (int channel = 0; channel < 3; ++channel) {
        int64_t light = rounded(radiance[channel], STEPS);
        pixel.radiance[channel] += light;
        if ((push.index & 1u) == 1u) pixel.odd[channel] += light;
        pixel.albedo[channel] += rounded(feature.albedo[channel], STEPS);
        pixel.normal[channel] += rounded(feature.normal[channel], STEPS);
        pixel.position[channel] += rounded(feature.position[channel], STEPS_IN_METRE);
    }
    pixel.depth += rounded(feature.depth, STEPS_IN_METRE);
    pixel.covered += feature.depth > 0.0 ? 1u : 0u;
    if (push.index == 0u) pixel.object = feature.object;
    film[push.first + slot] = pixel;
}
