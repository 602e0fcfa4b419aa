#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths that meet what stands on the ground.

#include "lib/frame.glsl"
#include "lib/turn.glsl"
#include "lib/spot.glsl"
#include "lib/tree.glsl"
#include "lib/material.glsl"
#include "lib/octahedron.glsl"

layout(local_size_x = GROUP) in;

layout(binding = 9) uniform usamplerBuffer triangles;
layout(binding = 10, scalar) readonly buffer Coats { uint coats[]; };   // of triangles: indices into the materials
layout(binding = 11) uniform usamplerBuffer placements;
layout(binding = 12, scalar) readonly buffer Materials { Material materials[]; };

#include "lib/placements.glsl"
#include "lib/triangles.glsl"

Spot spot_on_model(Material material, Placement place, vec3 point, vec3 outward, vec3 normal, vec3 view, float footprint) {
    if (dot(normal, view) > 0.0) normal = -normal;
    if (push.work.plain == 1u) {
        vec3 mean = tinted(material.reflectance, 0.5);
        Bsdf bsdf = Bsdf(mean, material.transmittance, 1.0, 1.0);
        return Spot(point, outward, normal, bsdf, material.emission, mean, place.object);
    }
    Coat coat = coat(material, point, place.random, footprint);
    coat.reflectance *= furrow(material, point, footprint, normal);
    float width = max(material.roughness * material.roughness, 0.01);
    Bsdf bsdf = Bsdf(coat.reflectance, coat.transmittance, material.refractive_index, width);
    return Spot(point, outward, normal, bsdf, material.emission, coat.reflectance, place.object);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].models.paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    arrive(index, path, hit);
    Placement place = placement_at(hit.placement);
    Triangle triangle = triangle_at(hit.triangle);
    vec3 within = triangle.a + hit.u * (triangle.b - triangle.a) + hit.v * (triangle.c - triangle.a);
    vec3 point = place.position + place.scale * rotate(place.rotation, within);
    vec3 outward = cross(triangle.b - triangle.a, triangle.c - triangle.a);
    outward = normalize(rotate(place.rotation, outward));
    if (dot(outward, path.direction) > 0.0) outward = -outward;
    vec3 normal = (1.0 - hit.u - hit.v) * unpack_direction(triangle.normals[0]) + hit.u * unpack_direction(triangle.normals[1])
                + hit.v * unpack_direction(triangle.normals[2]);
    normal = normalize(rotate(place.rotation, normal));
    Spot spot = spot_on_model(materials[coats[hit.triangle]], place, point, outward, normal, path.direction, path.width);
    turn_at(index, path, spot, hit.range);
}
