#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// The ground as maps for other programs: slope, normal, the weights of its materials and its colour.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, r32f) uniform readonly image2D wetness;
layout(binding = 3, r32f) uniform readonly image2D reef;
layout(binding = 4, r32f) uniform readonly image2D openness;
layout(binding = 5, r32f) uniform writeonly image2D slope_map;    // degrees
layout(binding = 6, rgba32f) uniform writeonly image2D normal_map; // world (x, −z, y)·½ + ½, and 1
layout(binding = 7, rgba32f) uniform writeonly image2D splat_map;  // grass, rock, sand, sea floor
layout(binding = 8, rgba8) uniform writeonly image2D albedo_map;   // sRGB, and 1

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/srgb.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, ivec2(frame.cells)))) return;
    vec2 xz = vec2(at) * frame.cell_size - 0.5 * frame.extent;
    Place place;
    place.point = vec3(xz.x, height_at(at), xz.y);
    // Central differences; one-sided at the rim.
    ivec2 west = clamp_to_grid(at - ivec2(1, 0));
    ivec2 east = clamp_to_grid(at + ivec2(1, 0));
    ivec2 north = clamp_to_grid(at - ivec2(0, 1));
    ivec2 south = clamp_to_grid(at + ivec2(0, 1));
    vec2 run = vec2(east.x - west.x, south.y - north.y) * frame.cell_size;
    place.slope = vec2(height_at(east) - height_at(west), height_at(south) - height_at(north)) / run;
    place.wetness = imageLoad(wetness, at).x;
    place.reef = imageLoad(reef, at).x;
    place.openness = BILINEAR(openness, stencil(xz, imageSize(openness).x)).x;
    place.footprint = frame.cell_size;
    vec3 normal = normal_from_slope(place.slope);
    imageStore(slope_map, at, vec4(degrees(atan(length(place.slope))), 0.0, 0.0, 0.0));
    imageStore(normal_map, at, vec4(vec3(normal.x, -normal.z, normal.y) * 0.5 + 0.5, 1.0));
    Ground found = ground(place);
    imageStore(splat_map, at, found.weights);
    imageStore(albedo_map, at, vec4(encoded(found.albedo), 1.0));
}
