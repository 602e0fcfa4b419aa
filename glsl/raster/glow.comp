#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance that leaves the ground at every sample, for what only needs it coarsely: mirror images in the sea.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, r32f) uniform readonly image2D wetness;
layout(binding = 3, r32f) uniform readonly image2D reef;
layout(binding = 4, r32f) uniform readonly image2D openness;
layout(binding = 5, rg32f) uniform readonly image2D shadow;
layout(binding = 6, rgba32f) uniform writeonly image2D glow;

#include "lib/heightfield.glsl"
#include "lib/coarse.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/light.glsl"
#include "lib/glow.glsl"

void main() {
    ivec2 at = coarse_at();
    if (!on_coarse_grid(at)) return;
    Place place = coarse_place(at);
    Ground found = ground(place);
    imageStore(glow, at, vec4(glow_of(found, place, imageLoad(shadow, at).xy), 1.0));
}
