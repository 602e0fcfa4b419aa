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

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (!on_coarse_grid(at)) return;
    vec2 xz = coarse_position(at);
    Place place;
    place.point = vec3(xz.x, height_at(ground_cell(at)), xz.y);
    place.slope = height_slope(xz);
    place.wetness = imageLoad(wetness, ground_cell(at)).x;
    place.reef = imageLoad(reef, ground_cell(at)).x;
    place.openness = imageLoad(openness, at).x;
    place.footprint = coarse_cell_size();
    Ground found = ground(place);
    vec3 light = frame.sun_irradiance * max(dot(found.normal, frame.sun_direction), 0.0)
               * sun_visibility(place.point.y, imageLoad(shadow, at).xy, coarse_cell_size(), coarse_cell_size())
               + sky_irradiance(found.normal) * place.openness + bounced(found.albedo, place.openness);
    imageStore(glow, at, vec4(found.albedo / PI * light, 1.0));
}
