#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Paths at the surface of the sea: they are mirrored by waves, or change between air and water.

#include "lib/frame.glsl"
#include "lib/turn.glsl"
#include "lib/spot.glsl"

layout(local_size_x = GROUP) in;

layout(binding = 9, r32f) uniform readonly image2D height;
layout(binding = 10, r32f) uniform readonly image2D surf;

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/sea.glsl"
#include "lib/waves.glsl"
#include "lib/foam.glsl"

// A path at the sea's surface. Coming from above it meets waves, some of which a sample can tell apart; from below the
// surface is flat, as for light that is looked for through it.
void cross_sea(uint index, inout Path path, vec3 point, float footprint) {
    vec3 view = path.direction;
    vec3 u = vec3(random_pair(index, 1u), random_pair(index, 2u).x);
    path.origin = vec3(point.x, frame.sea_level, point.z);
    if (path.medium == WATER) {
        float mirrored = fresnel_dielectric(view.y, 1.0 / REFRACTIVE_INDEX);
        if (u.z < mirrored) {
            path.direction = vec3(view.x, -view.y, view.z);
            path.density = 0.0;
            return;
        }
        vec3 above = refract(view, vec3(0.0, -1.0, 0.0), REFRACTIVE_INDEX);
        path.density *= (1.0 - mirrored) * above.y / (REFRACTIVE_INDEX * REFRACTIVE_INDEX * view.y);
        path.throughput *= REFRACTIVE_INDEX * REFRACTIVE_INDEX;
        path.direction = above;
        path.medium = AIR;
        return;
    }
    Ripples found = ripples(point.xz, footprint);
    Waves waves = waves_of(found.slope, found.deviation, view);

    float sky = frame.sky == SKY_NONE ? 0.0 : 0.05 * luminance(sky_irradiance(vec3(0.0, 1.0, 0.0)));
    float sun = luminance(frame.sun_irradiance) * mirrored_by_waves(waves, frame.sun_direction).x;
    path.sky_share = sky + sun > 0.0 ? sky / (sky + sun) : 1.0;
    Light light = find_light(index, path, frame.sea_level);
    vec2 value = mirrored_by_waves(waves, light.direction);
    look(index, path, path.origin, light, vec3(value.x), value.y);

    Crossing way = cross_waves(waves, u);
    path.direction = way.direction;
    path.density = way.density;
    path.throughput *= way.weight;
    if (way.medium == WATER) path.throughput /= REFRACTIVE_INDEX * REFRACTIVE_INDEX;
    path.medium = way.medium;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.work.turn].sea.paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    vec3 point = arrive(index, path, hit);
    if (push.work.turn == 0u) features[index] = Feature(vec3(0.0), vec3(0.0, 1.0, 0.0), point, hit.range, 0u);
    if (push.work.turn >= push.work.bounces) return;
    // On the sea a sample is a long ellipse; its mean diameter counts.
    float footprint = path.width * inversesqrt(max(abs(path.direction.y), 0.02));
    if (path.medium == AIR && push.work.plain == 0u) {
        float depth = frame.sea_level - height_bilinear(point.xz);
        float white = foam(point.xz, depth, BILINEAR(surf, stencil(point.xz, imageSize(surf).x)).x, footprint);
        if (random_pair(index, 3u).x < white) {
            const vec3 UP = vec3(0.0, 1.0, 0.0);
            turn_at(index, path, Spot(point, UP, UP, Bsdf(vec3(FOAM), vec3(0.0), 1.0, 1.0), vec3(0.0), vec3(FOAM), 0u), hit.range);
            return;
        }
    }
    cross_sea(index, path, point, footprint);
    go_on(index, path);
}
