#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths that meet the land.

#include "lib/frame.glsl"
#include "lib/turn.glsl"
#include "lib/spot.glsl"
#include "lib/tree.glsl"

layout(local_size_x = 64) in;

layout(binding = 9) uniform usamplerBuffer triangles;
layout(binding = 10, r32f) uniform readonly image2D height;
layout(binding = 11, r32f) uniform readonly image2D wetness;
layout(binding = 12, r32f) uniform readonly image2D reef;
layout(binding = 13, r32f) uniform readonly image2D openness;
layout(binding = 14, r32f) uniform readonly image2D water;

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/ground.glsl"
#include "lib/triangles.glsl"

Spot spot_on_land(vec3 point, vec3 outward, float footprint, float choice) {
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
    // A river or a lake: its bed, seen through water that mirrors.
    float depth = push.work.plain == 1u || point.y < frame.sea_level ? 0.0 : BILINEAR(water, s).x;
    if (choice < smoothstep(0.08, 0.6, depth)) {
        vec3 through = 0.7 * found.albedo * exp(-2.0 * frame.attenuation * depth);
        Bsdf wet = Bsdf(through, vec3(0.0), REFRACTIVE_INDEX, 0.02);
        return Spot(point, outward, normalize(mix(normal, vec3(0.0, 1.0, 0.0), 0.8)), wet, vec3(0.0), through, 0u);
    }
    return Spot(point, outward, normal, Bsdf(found.albedo, vec3(0.0), 1.0, 1.0), vec3(0.0), found.albedo, 0u);
}

// Normal of a triangle, of any length: of the land's own, or of what the sea covers beyond.
vec3 facing_of(uint number) {
    if ((number & GRID) != 0u) {
        mat3 corners = ground_corners(number, Lattice(frame.cell_size, 0.5 * frame.extent));
        return cross(corners[1] - corners[0], corners[2] - corners[0]);
    }
    Triangle triangle = triangle_at(number);
    return cross(triangle.b - triangle.a, triangle.c - triangle.a);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].land) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    vec3 point = arrive(index, path, hit);
    vec3 outward = normalize(facing_of(hit.triangle));
    if (dot(outward, path.direction) > 0.0) outward = -outward;
    turn_at(index, path, spot_on_land(point, outward, path.width, random_pair(index, 3u).x), hit.range);
}
