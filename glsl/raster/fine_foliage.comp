#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of the samples that see plants: foliage.comp, for tiles that stand in a list.

#include "lib/frame.glsl"
#include "lib/material.glsl"
#include "lib/cast.glsl"
#include "lib/octahedron.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// Whether plants cast shadows of their own.
layout(constant_id = 2) const bool CASTS = true;

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
    int coarse_cells;  // side of the grid of openness, shadow and glow
    uint first_tile;   // of the list of tiles
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#define WITH_CASTS CASTS

#include "lib/own_part.glsl"
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
    ivec2 at = own_sample();
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    vec3 view = camera_ray(vec2(at) + 0.5);
    float path;
    if (part_of(view, imageLoad(range, at).x, path) != PART) return;
    vec3 seen = plant_radiance(imageLoad(plant, at), view, path, cast_turn(at));
    imageStore(radiance, at, vec4(with_clouds(veil(seen, view, path), view, path), 1.0));
}
