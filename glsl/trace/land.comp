#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths that meet the land.

#include "lib/frame.glsl"
#include "lib/turn.glsl"
#include "lib/spot.glsl"
#include "lib/tree.glsl"

layout(local_size_x = GROUP) in;

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
#include "lib/corner.glsl"
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
    place.footprint = footprint;
    Ground found = ground(place);
    vec3 normal = found.normal;
    // A river or a lake: its bed, seen through water that mirrors.
    float depth = point.y < frame.sea_level ? 0.0 : BILINEAR(water, s).x;
    if (choice < smoothstep(0.08, 0.6, depth)) {
        vec3 through = 0.7 * found.albedo * exp(-2.0 * frame.attenuation * depth);
        Bsdf wet = Bsdf(through, vec3(0.0), REFRACTIVE_INDEX, 0.02);
        return Spot(point, outward, normalize(mix(normal, vec3(0.0, 1.0, 0.0), 0.8)), wet, vec3(0.0), through, 0u);
    }
    return Spot(point, outward, normal, Bsdf(found.albedo, vec3(0.0), 1.0, 1.0), vec3(0.0), found.albedo, 0u);
}

// With constant materials.
Spot spot_on_mesh(mat3 triangle, Hit hit, vec3 point, vec3 outward, vec3 view) {
    Corner a = corner_at(triangle[0]);
    Corner b = corner_at(triangle[1]);
    Corner c = corner_at(triangle[2]);
    vec3 weights = vec3(1.0 - hit.u - hit.v, hit.u, hit.v);
    vec3 normal = normalize(mat3(a.normal, b.normal, c.normal) * weights);
    if (dot(normal, view) > 0.0) normal = -normal;
    vec3 albedo = mat3(a.albedo, b.albedo, c.albedo) * weights;
    return Spot(point, outward, normal, Bsdf(albedo, vec3(0.0), 1.0, 1.0), vec3(0.0), albedo, 0u);
}

// Corners of a triangle of the land's own, or of what the sea covers beyond.
mat3 corners_of(uint number) {
    if ((number & GRID) != 0u) return ground_corners(number, Lattice(frame.cell_size, 0.5 * frame.extent));
    Triangle triangle = triangle_at(number);
    return mat3(triangle.a, triangle.b, triangle.c);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].land.paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    vec3 point = arrive(index, path, hit);
    mat3 triangle = corners_of(hit.triangle);
    vec3 outward = normalize(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
    if (dot(outward, path.direction) > 0.0) outward = -outward;
    Spot spot = push.work.plain == 1u ? spot_on_mesh(triangle, hit, point, outward, path.direction)
                                      : spot_on_land(point, outward, path.width, random_pair(index, 3u).x);
    turn_at(index, path, spot, hit.range);
}
