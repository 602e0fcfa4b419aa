#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths that meet the land.

#include "lib/frame.glsl"
#include "lib/turn.glsl"
#include "lib/spot.glsl"
#include "lib/tree.glsl"

layout(local_size_x = 64) in;

layout(binding = 9, scalar) readonly buffer Triangles { Triangle triangles[]; };
layout(binding = 10, r32f) uniform readonly image2D height;
layout(binding = 11, r32f) uniform readonly image2D wetness;
layout(binding = 12, r32f) uniform readonly image2D reef;
layout(binding = 13, r32f) uniform readonly image2D openness;

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"

Spot spot_on_land(vec3 point, vec3 outward, float footprint) {
    Stencil s = stencil(point.xz, frame.cells);
    Place place;
    place.point = point;
    place.slope = height_slope(point.xz);
    place.wetness = BILINEAR(wetness, s).x;
    place.reef = BILINEAR(reef, s).x;
    place.openness = BILINEAR(openness, stencil(point.xz, imageSize(openness).x)).x;
    place.footprint = push.work.plain == 1u ? 1e6 : footprint;
    Ground found = ground(place);
    vec3 normal = push.work.plain == 1u ? normal_from_slope(place.slope) : found.normal;
    return Spot(point, outward, normal, Bsdf(found.albedo, vec3(0.0), 1.0, 1.0), vec3(0.0), found.albedo, 0u);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].land) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    vec3 point = arrive(index, path, hit);
    Triangle triangle = triangles[hit.triangle];
    vec3 outward = normalize(cross(triangle.b - triangle.a, triangle.c - triangle.a));
    if (dot(outward, path.direction) > 0.0) outward = -outward;
    turn_at(index, path, spot_on_land(point, outward, path.width), hit.range);
}
