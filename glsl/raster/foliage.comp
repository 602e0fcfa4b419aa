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

// What the sun and the sky send to both sides of a surface.
struct Arriving {
    vec3 sun;          // on a plane that faces it
    float sky;         // share of the sky that is seen
    vec3 below;        // radiance of the ground below
    float hidden;      // share of the sky that other leaves hide
};

// Light from above and below on a plane with this normal.
vec3 dome(Arriving light, vec3 normal) {
    return light.sky * sky_irradiance(normal) + light.below * PI * 0.5 * (1.0 - normal.y);
}

vec3 leaving(Material material, Coat coat, Arriving light, vec3 normal, vec3 view, float footprint) {
    // The normal on the eye's side.
    vec3 n = dot(normal, view) > 0.0 ? -normal : normal;
    float facing = dot(n, frame.sun_direction);
    float mirrored = rough_schlick(material, dot(n, -view));
    vec3 scattered = coat.reflectance / PI * (light.sun * max(facing, 0.0) + dome(light, n))
                   + coat.transmittance / PI * (light.sun * max(-facing, 0.0) + dome(light, -n));
    // Leaves that hide the sky are lit themselves, half of them well, and are of the same colour.
    vec3 albedo = coat.reflectance + coat.transmittance;
    vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
    scattered += light.hidden * 0.25 * albedo * albedo / PI * open_light;
    vec3 gloss = light.sun * highlight(material, n, -view, frame.sun_direction, footprint) + mirrored * dome(light, n) / PI;
    return (1.0 - mirrored) * scattered + gloss;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(range)))) return;
    float path = -imageLoad(range, at).x;
    if (path <= 0.0) return;
    vec3 view = camera_ray(vec2(push.origin + at) + 0.5);
    float sea_range = range_of_sea(view);
    if (sea_range > 0.0 && sea_range < path) return;
    uvec4 found = imageLoad(plant, at);

    vec3 point = frame.eye + path * view;
    float footprint = path * frame.sample_angle;
    Material material = materials[found.x];
    Coat coat = coat(material, point, found.y, footprint);
    Stencil coarse = stencil(point.xz, push.coarse_cells);
    Arriving light;
    vec4 leaves = BILINEAR(canopy, stencil(point.xz, imageSize(canopy).x));
    float visible = sun_visibility(point.y, BILINEAR(shadow, coarse).xy, coarse_cell_size(), footprint);
    if (visible > 0.0) {
        float elsewhere = through_canopy(leaves, point.y, 1.0 / max(frame.sun_direction.y, 0.1));
        visible *= cast_visibility(point, 0.02 + footprint, 6, cast_turn(push.origin + at), elsewhere);
    }
    // Own leaves are among those of the canopy: what hides more counts.
    vec2 open = unpackUnorm2x16(found.w);
    light.sun = frame.sun_irradiance * visible;
    light.sky = BILINEAR(openness, coarse).x * min(open.x, through_canopy(leaves, point.y, MEAN_PATH));
    light.below = BILINEAR(glow, coarse).rgb * open.y * through_canopy(leaves, -1e9, MEAN_PATH);
    light.hidden = 1.0 - light.sky;
    vec3 normal = unpack_direction(found.z);
    coat.reflectance *= furrow(material, point, footprint, normal);
    vec3 seen = leaving(material, coat, light, normal, view, footprint);
    imageStore(radiance, at, vec4(with_clouds(veil(seen, view, path), view, path), 1.0));
}
