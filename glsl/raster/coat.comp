#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// What the ground looks like at every sample of the coarse grid, for pictures that are drawn too often to work it out: its colour, its
// relief, the white water over it; and the radiance that leaves it (glow.comp).

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, r32f) uniform readonly image2D wetness;
layout(binding = 3, r32f) uniform readonly image2D reef;
layout(binding = 4, r32f) uniform readonly image2D openness;
layout(binding = 5, r32f) uniform readonly image2D surf;
layout(binding = 6, rg32f) uniform readonly image2D shadow;
layout(binding = 7, rgba32f) uniform writeonly image2D glow;
layout(binding = 8, rgba32f) uniform writeonly image2D coat;   // albedo; share of white water
layout(binding = 9, rg32f) uniform writeonly image2D relief;   // slope beside that of the ground

#include "lib/heightfield.glsl"
#include "lib/coarse.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/light.glsl"
#include "lib/foam.glsl"
#include "lib/glow.glsl"

void main() {
    ivec2 at = coarse_at();
    if (!on_coarse_grid(at)) return;
    Place place = coarse_place(at);
    Ground found = ground(place);
    float depth = frame.sea_level - place.point.y;
    float white = depth < -1.0 ? 0.0 : foam(place.point.xz, max(depth, 0.0), imageLoad(surf, at).x, place.footprint);
    vec2 slope = -found.normal.xz / found.normal.y;
    imageStore(glow, at, vec4(glow_of(found, place, imageLoad(shadow, at).xy), 1.0));
    imageStore(coat, at, vec4(found.albedo, white));
    imageStore(relief, at, vec4(slope - place.slope, 0.0, 0.0));
}
