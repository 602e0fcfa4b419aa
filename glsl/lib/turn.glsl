// What the programs share that turn paths: the paths and their queues, and looking for light. `lib/frame.glsl` stands before.
#ifndef TURN_GLSL
#define TURN_GLSL

#include "lib/bsdf.glsl"
#include "lib/fresnel.glsl"
#include "lib/hit.glsl"
#include "lib/luminance.glsl"
#include "lib/path.glsl"
#include "lib/sampler.glsl"
#include "lib/sky.glsl"
#include "lib/water.glsl"
#include "lib/air.glsl"

layout(binding = 1, scalar) buffer Paths { Path paths[]; };
layout(binding = 2, scalar) readonly buffer Hits { Hit hits[]; };
layout(binding = 3, scalar) buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Queue { uint queue[]; };
layout(binding = 5, scalar) writeonly buffer Next { uint next[]; };
layout(binding = 6, scalar) writeonly buffer Looks { Look looks[]; };
layout(binding = 7, scalar) writeonly buffer Features { Feature features[]; };
layout(binding = 8, scalar) readonly buffer Dome { float dome[]; };

layout(push_constant, scalar) uniform Push { Work work; } push;

#include "lib/dome.glsl"

float sun_solid_angle() {
    // 2π(1 − cos r), without the difference.
    float s = sin(0.5 * frame.sun_radius);
    return 4.0 * PI * s * s;
}

// Of the disc, the same all over: what faces its middle receives ∫ cos = π sin² r of it.
vec3 sun_radiance() {
    float s = sin(frame.sun_radius);
    return frame.sun_irradiance / (PI * s * s);
}

bool has_sun() {
    return frame.sun_irradiance != vec3(0.0);
}

bool in_sun(vec3 direction) {
    return distance(direction, frame.sun_direction) <= 2.0 * sin(0.5 * frame.sun_radius);
}

// Random numbers of a path in this turn: pair 0 for the light that is looked for, 1 for the way on, 2 and 3 for
// choices.
vec2 random_pair(uint index, uint pair) {
    int pixel = push.work.first + int(index);
    ivec2 at = push.work.origin + ivec2(pixel % push.work.columns, pixel / push.work.columns);
    return sampled(sampler_of(push.work.seed, at, push.work.index), 4u * push.work.turn + 2u + pair);
}

// Where a ray starts that leaves a surface towards `direction`: off it by more than rounding can have put it behind.
vec3 start(vec3 point, vec3 outward, vec3 direction) {
    float off = 4e-7 * (abs(point.x) + abs(point.y) + abs(point.z)) + 1e-5;
    return point + (dot(outward, direction) > 0.0 ? off : -off) * outward;
}

// A light that is looked for, seen from a place in the air or through the flat surface of the sea.
struct Light {
    vec3 direction;   // at the place
    vec3 above;       // in the air
    float reach;      // from the place to the surface of the sea; ENDLESS in the air
    vec3 radiance;    // that arrives there, over the density of `direction` there
    float density;    // in the measure of directions in the air, with what gets through the surface
    float measure;    // density of directions in the air over that at the place
};

// Light from `direction` in the air, found with `density`, at a place `deep` metres under water. Radiance grows by the square of the
// refractive index as it enters, and directions draw together as much (Veach 1997, section 5.2).
Light through_sea(vec3 direction, vec3 radiance, float density, float deep) {
    vec3 inside = -refract(-direction, vec3(0.0, 1.0, 0.0), 1.0 / REFRACTIVE_INDEX);
    float passes = 1.0 - fresnel_dielectric(direction.y, REFRACTIVE_INDEX);
    float measure = passes * direction.y / (REFRACTIVE_INDEX * REFRACTIVE_INDEX * inside.y);
    float reach = deep / inside.y;
    vec3 left = exp(-frame.attenuation * reach);
    return Light(inside, direction, reach, radiance * left * passes * direction.y / inside.y / density, density, measure);
}

// One of the lights, by chance: the sun or a place in the sky. No density if there is none.
Light find_light(uint index, Path path, float height_) {
    vec2 u = random_pair(index, 0u);
    float share = path.sky_share;
    // The same number chooses the light and, stretched, the row of the sky.
    bool sky = u.y < share;
    vec3 direction;
    vec3 radiance;
    float density;
    if (sky) {
        direction = dome_direction(vec2(u.x, u.y / share), density);
        radiance = sky_radiance(direction);
        density *= share;
    } else {
        vec2 v = vec2(u.x, (u.y - share) / (1.0 - share));
        // Uniform over the disc's cap.
        float s = sin(0.5 * frame.sun_radius);
        float fall = 2.0 * s * s * v.x;
        float level = sqrt(max(fall * (2.0 - fall), 0.0));
        float angle = 2.0 * PI * v.y;
        direction = frame_of(frame.sun_direction) * vec3(level * cos(angle), level * sin(angle), 1.0 - fall);
        density = (1.0 - share) / sun_solid_angle();
        radiance = sun_radiance();
    }
    // From above the sea hides what is below the horizon; from below the way through it is one more turn.
    bool hidden = path.medium == WATER ? direction.y <= 0.0 || push.work.turn + 2u > push.work.bounces
                                       : direction.y < 0.0 && (push.work.sea_level - height_) / direction.y < HORIZON;
    if (density <= 0.0 || hidden) return Light(vec3(0.0), vec3(0.0), ENDLESS, vec3(0.0), 0.0, 1.0);
    if (path.medium == WATER) return through_sea(direction, radiance, density, max(frame.sea_level - height_, 0.0));
    return Light(direction, direction, ENDLESS, radiance / density, density, 1.0);
}

// Looks whether the light is hidden. `value` of it leaves towards the path, which finds it itself with the density `scattering`.
void look(uint index, Path path, vec3 origin, Light light, vec3 value, float scattering) {
    if (light.density <= 0.0) return;
    float balance = light.density / (light.density + scattering * light.measure);
    vec3 seen = path.throughput * value * light.radiance * balance;
    if (seen == vec3(0.0)) return;
    ENQUEUE(looks, turns[push.work.turn].looks, (Look(origin, light.direction, light.reach, light.above, seen, index)))
}

// Takes what the air or the water does to the path on its way to `hit`; returns where it has come to. What the path has
// gathered is kept.
vec3 arrive(uint index, inout Path path, Hit hit) {
    vec3 view = path.direction;
    if (path.medium == WATER) {
        vec3 left = exp(-frame.attenuation * hit.range);
        if (view.y < 0.0) {
            // What the water itself scatters back, as from an endless depth, less what lies below the bottom.
            vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
            vec3 round_trip = left * exp(1.1 * frame.attenuation * view.y * hit.range);
            vec3 body = frame.deep_colour / PI * open_light * (1.0 - round_trip);
            path.radiance += path.throughput * REFRACTIVE_INDEX * REFRACTIVE_INDEX * body;
        }
        path.throughput *= left;
    } else if (frame.molecule_extinction != vec3(0.0)) {
        Veil air = veil_of(path.origin.y, view, hit.range);
        path.radiance += path.throughput * air.light;
        path.throughput *= air.transmittance;
    }
    path.width = max(path.width + path.spread * hit.range, 1e-4);
    paths[index].radiance = path.radiance;
    return path.origin + hit.range * view;
}

// Sends the path on, or ends it: by chance where it carries little (Arvo & Kirk 1990, "Particle Transport and Image Synthesis").
void go_on(uint index, Path path) {
    if (push.work.turn >= 3u) {
        float survives = clamp(largest(path.throughput), 0.05, 0.95);
        if (random_pair(index, 2u).y >= survives) return;
        path.throughput /= survives;
    }
    paths[index] = path;
    ENQUEUE(next, turns[push.work.turn + 1u].paths, index)
}

#endif
