#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of the samples that see one kind of thing: shade.comp, cut into its parts.

#include "lib/frame.glsl"
#include "lib/cast.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, rgba32f) uniform writeonly image2D radiance;
layout(binding = 3, r32f) uniform readonly image2D height;
layout(binding = 4, r32f) uniform readonly image2D water;
layout(binding = 5, r32f) uniform readonly image2D wetness;
layout(binding = 6, r32f) uniform readonly image2D reef;
layout(binding = 7, r32f) uniform readonly image2D openness;
layout(binding = 8, r32f) uniform readonly image2D surf;
layout(binding = 9, rg32f) uniform readonly image2D shadow;
layout(binding = 10, rgba32f) uniform readonly image2D glow;
layout(binding = 11, scalar) readonly buffer Casts { Cast casts[]; };
layout(binding = 12, r32f) uniform readonly image2D cast_maps;
layout(binding = 13, rgba32f) uniform readonly image2D canopy;

layout(push_constant, scalar) uniform Push {
    int coarse_cells;  // side of the grid of openness, surf, shadow and glow
    uint first_tile;   // of the list of tiles
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#include "lib/own_part.glsl"
#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/light.glsl"
#include "lib/sea.glsl"
#include "lib/foam.glsl"
#include "lib/clouds.glsl"
#include "lib/canopy.glsl"
#include "lib/wet.glsl"
#include "lib/casts.glsl"
#include "lib/shade.glsl"

vec3 seen(ivec2 at, vec3 view, float path) {
    vec3 surface = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    if (PART == GROUND) return ground_radiance(Hit(surface, footprint, 0.0), view, cast_turn(at));
    // On the sea a sample is a long ellipse; its mean diameter counts.
    footprint *= inversesqrt(max(-view.y, 0.02));
    Hit hit = sea_bottom(surface, refract(view, vec3(0.0, 1.0, 0.0), 1.0 / REFRACTIVE_INDEX), footprint);
    return sea_radiance(surface, view, footprint, hit, ground_radiance(hit, view, cast_turn(at)));
}

void main() {
    ivec2 at = own_sample();
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    vec3 view = camera_ray(vec2(at) + 0.5);
    float path;
    if (part_of(view, imageLoad(range, at).x, path) != PART) return;
    vec3 light;
    if (PART == CLEAR) {
        light = sky_radiance(view) + sun_disc_radiance(view);
    } else if (PART == CLOUDY) {
        light = with_clouds(sky_radiance(view) + sun_disc_radiance(view), view, 1e9);
    } else {
        light = with_clouds(veil(seen(at, view, path), view, path), view, path);
    }
    imageStore(radiance, at, vec4(light, 1.0));
}
