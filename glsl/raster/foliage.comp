#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of every sample that sees what stands on the ground. Surfaces scatter diffusely on the side that is lit, let
// light through to the other, and carry a thin gloss.

#include "lib/frame.glsl"
#include "lib/material.glsl"
#include "lib/cast.glsl"
#include "lib/octahedron.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, rgba32ui) uniform readonly uimage2D plant;
layout(binding = 3, rgba32f) uniform writeonly image2D radiance;
layout(binding = 4, scalar) readonly buffer Materials { Material materials[]; };
layout(binding = 5, r32f) uniform readonly image2D openness;
layout(binding = 6, rg32f) uniform readonly image2D shadow;
layout(binding = 7, rgba32f) uniform readonly image2D glow;
layout(binding = 8, scalar) readonly buffer Casts { Cast casts[]; };
layout(binding = 9, r32f) uniform readonly image2D cast_maps;
layout(binding = 10, rgba32f) uniform readonly image2D canopy;

layout(push_constant, scalar) uniform Push {
    ivec2 origin;      // of the tile, in samples of the whole picture
    int coarse_cells;  // side of the grid of openness, shadow and glow
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/light.glsl"
#include "lib/clouds.glsl"
#include "lib/gloss.glsl"
#include "lib/canopy.glsl"
#include "lib/casts.glsl"
#include "lib/foliage.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    float path = -imageLoad(range, at).x;
    if (path <= 0.0) return;
    vec3 view = camera_ray(vec2(push.origin + at) + 0.5);
    float sea_range = range_of_sea(view);
    if (sea_range > 0.0 && sea_range < path) return;
    uvec4 found = imageLoad(plant, at);
    vec3 seen = plant_radiance(found, view, path, cast_turn(push.origin + at));
    imageStore(radiance, at, vec4(with_clouds(veil(seen, view, path), view, path), 1.0));
}
