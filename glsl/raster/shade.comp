#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Radiance of every sample: ground, sea or sky, whichever the ray meets first. The bottom of the sea is shaded as the
// ground is, by light that came through the water.

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
    ivec2 origin;      // of the tile, in samples of the whole picture
    int coarse_cells;  // side of the grid of openness, surf, shadow and glow
} push;

float coarse_cell_size() {
    return frame.extent / float(push.coarse_cells - 1);
}

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/light.glsl"
#include "lib/sea.glsl"
#include "lib/foam.glsl"
#include "lib/wet.glsl"
#include "lib/clouds.glsl"
#include "lib/canopy.glsl"
#include "lib/casts.glsl"
#include "lib/shade.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    vec3 view = camera_ray(vec2(push.origin + at) + 0.5);
    // Negative is the range of what stands on the ground.
    float first_range = imageLoad(range, at).x;
    float ground_range = abs(first_range);
    float sea_range = range_of_sea(view);
    bool sea = sea_range > 0.0 && (ground_range == 0.0 || sea_range < ground_range);
    if (!sea && first_range < 0.0) return;
    float path = sea ? sea_range : ground_range;
    if (path == 0.0) {
        imageStore(radiance, at, vec4(with_clouds(sky_radiance(view) + sun_disc_radiance(view), view, 1e9), 1.0));
        return;
    }

    vec3 surface = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    Hit hit = Hit(surface, footprint, 0.0);
    if (sea) {
        // On the sea a sample is a long ellipse; its mean diameter counts.
        footprint *= inversesqrt(max(-view.y, 0.02));
        hit = sea_bottom(surface, refract(view, vec3(0.0, 1.0, 0.0), 1.0 / REFRACTIVE_INDEX), footprint);
    }
    vec3 seen = ground_radiance(hit, view, cast_turn(push.origin + at));
    if (sea) seen = sea_radiance(surface, view, footprint, hit, seen);
    imageStore(radiance, at, vec4(with_clouds(veil(seen, view, path), view, path), 1.0));
}
