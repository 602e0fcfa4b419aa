#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Where paths end or turn: takes the light of the sky, looks for a light from every surface, and chooses where the path
// goes on.

#include "lib/frame.glsl"
#include "lib/path.glsl"
#include "lib/tree.glsl"
#include "lib/material.glsl"
#include "lib/octahedron.glsl"
#include "lib/sampler.glsl"
#include "lib/hit.glsl"

layout(local_size_x = 64) in;

layout(binding = 1, scalar) buffer Paths { Path paths[]; };
layout(binding = 2, scalar) readonly buffer Hits { Hit hits[]; };
layout(binding = 3, scalar) buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Queue { uint queue[]; };
layout(binding = 5, scalar) writeonly buffer Next { uint next[]; };
layout(binding = 6, scalar) writeonly buffer Looks { Look looks[]; };
layout(binding = 7, scalar) writeonly buffer Features { Feature features[]; };
layout(binding = 8, scalar) readonly buffer Triangles { Triangle triangles[]; };
layout(binding = 9, scalar) readonly buffer Facets { Facet facets_[]; };
layout(binding = 10, scalar) readonly buffer Placements { Placement placements[]; };
layout(binding = 11, scalar) readonly buffer Materials { Material materials[]; };
layout(binding = 12, scalar) readonly buffer Dome { float dome[]; };
layout(binding = 13, r32f) uniform readonly image2D height;
layout(binding = 14, r32f) uniform readonly image2D wetness;
layout(binding = 15, r32f) uniform readonly image2D reef;
layout(binding = 16, r32f) uniform readonly image2D openness;

layout(push_constant, scalar) uniform Push {
    uint seed;
    uint index;         // of the sample
    ivec2 origin;       // first pixel of the block, in all of the picture
    int columns;        // of the block
    int first;          // of its pixels that are at work
    uint turn;
    uint bounces;       // scatterings that a path may have
    uint plain;         // 1: materials have their mean colour and nothing else
} push;

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/sky.glsl"
#include "lib/air.glsl"
#include "lib/sea.glsl"
#include "lib/bsdf.glsl"
#include "lib/dome.glsl"

const float NO_MIRROR = 1.0;          // refractive index of what has no coat
const float WATER_INDEX = REFRACTIVE_INDEX;

float luminance(vec3 color) {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}

// The place that a path has come to, in the air or under water.
struct Spot {
    vec3 point;
    vec3 outward;    // geometric normal, on the path's side
    vec3 normal;     // of shading
    Bsdf bsdf;
    vec3 emission;
    vec3 albedo;
    uint object;
};

float sun_solid_angle() {
    // 2π(1 − cos r), without the difference.
    float s = sin(0.5 * frame.sun_radius);
    return 4.0 * PI * s * s;
}

bool has_sun() {
    return frame.sun_irradiance != vec3(0.0);
}

bool in_sun(vec3 direction) {
    return distance(direction, frame.sun_direction) <= 2.0 * sin(0.5 * frame.sun_radius);
}

// Whatever the path sees beyond all surfaces. A light that the last place looked for counts by how much better the path
// finds it (Veach & Guibas 1995, the balance heuristic).
vec3 beyond(Path path) {
    vec3 direction = path.direction;
    bool looked = path.density > 0.0;
    vec3 light = sky_radiance(direction);
    if (looked) light *= path.density / (path.density + path.sky_share * dome_density(direction));
    if (has_sun() && in_sun(direction)) {
        float share = looked ? path.density / (path.density + (1.0 - path.sky_share) / sun_solid_angle()) : 1.0;
        light += share * frame.sun_irradiance / sun_solid_angle();
    }
    return light;
}

Spot spot_on_land(vec3 point, vec3 outward, float footprint) {
    Stencil s = stencil(point.xz, frame.cells);
    Place place;
    place.point = point;
    place.slope = height_slope(point.xz);
    place.wetness = BILINEAR(wetness, s).x;
    place.reef = BILINEAR(reef, s).x;
    place.openness = BILINEAR(openness, stencil(point.xz, imageSize(openness).x)).x;
    place.footprint = push.plain == 1u ? 1e6 : footprint;
    Ground found = ground(place);
    vec3 normal = push.plain == 1u ? normal_from_slope(place.slope) : found.normal;
    return Spot(point, outward, normal, Bsdf(found.albedo, vec3(0.0), NO_MIRROR, 1.0), vec3(0.0), found.albedo, 0u);
}

Spot spot_on_model(Material material, Placement place, vec3 point, vec3 outward, vec3 normal, vec3 view, float footprint) {
    if (dot(normal, view) > 0.0) normal = -normal;
    if (push.plain == 1u) {
        vec3 mean = tinted(material.reflectance, 0.5);
        Bsdf bsdf = Bsdf(mean, material.transmittance, NO_MIRROR, 1.0);
        return Spot(point, outward, normal, bsdf, material.emission, mean, place.object);
    }
    Coat coat = coat(material, point, place.random, footprint);
    coat.reflectance *= furrow(material, point, footprint, normal);
    float width = max(material.roughness * material.roughness, 0.01);
    Bsdf bsdf = Bsdf(coat.reflectance, coat.transmittance, material.refractive_index, width);
    return Spot(point, outward, normal, bsdf, material.emission, coat.reflectance, place.object);
}

Spot spot_at(Hit hit, vec3 view, float footprint) {
    Placement place = placements[hit.placement];
    Triangle triangle = triangles[hit.triangle];
    Facet facet = facets_[hit.triangle];
    vec3 within = triangle.a + hit.u * (triangle.b - triangle.a) + hit.v * (triangle.c - triangle.a);
    vec3 point = place.position + place.scale * rotate(place.rotation, within);
    vec3 outward = cross(triangle.b - triangle.a, triangle.c - triangle.a);
    outward = normalize(rotate(place.rotation, outward));
    if (dot(outward, view) > 0.0) outward = -outward;
    if (facet.material == GROUND) return spot_on_land(point, outward, footprint);
    vec3 normal = (1.0 - hit.u - hit.v) * unpack_direction(facet.normals[0]) + hit.u * unpack_direction(facet.normals[1])
                + hit.v * unpack_direction(facet.normals[2]);
    normal = normalize(rotate(place.rotation, normal));
    return spot_on_model(materials[facet.material], place, point, outward, normal, view, footprint);
}

// Where a ray starts that leaves a surface towards `direction`: off it by more than rounding can have put it behind.
vec3 start(vec3 point, vec3 outward, vec3 direction) {
    float off = 4e-7 * (abs(point.x) + abs(point.y) + abs(point.z)) + 1e-5;
    return point + (dot(outward, direction) > 0.0 ? off : -off) * outward;
}

// Fresnel's reflectance of unpolarised light that comes at `cosine` into what is `index` times as dense.
float fresnel_dielectric(float cosine, float index) {
    float sine = 1.0 - (1.0 - cosine * cosine) / (index * index);
    if (sine <= 0.0) return 1.0;
    float inside = sqrt(sine);
    float parallel = (index * cosine - inside) / (index * cosine + inside);
    float across = (cosine - index * inside) / (cosine + index * inside);
    return 0.5 * (parallel * parallel + across * across);
}

// A light that is looked for, seen from a place in the air or through the flat surface of the sea.
struct Light {
    vec3 direction;   // at the place
    vec3 radiance;    // that arrives there, over the density of `direction` there
    float density;    // in the measure of directions in the air, with what gets through the surface
    float measure;    // density of directions in the air over that at the place
};

// Light from `direction` in the air, found with `density`, at a place `deep` metres under water. Radiance grows by the square of the
// refractive index as it enters, and directions draw together as much (Veach 1997, section 5.2).
Light through_sea(vec3 direction, vec3 radiance, float density, float deep) {
    vec3 inside = -refract(-direction, vec3(0.0, 1.0, 0.0), 1.0 / WATER_INDEX);
    float passes = 1.0 - fresnel_dielectric(direction.y, WATER_INDEX);
    float measure = passes * direction.y / (WATER_INDEX * WATER_INDEX * inside.y);
    vec3 left = exp(-frame.attenuation * (deep / inside.y));
    return Light(inside, radiance * left * passes * direction.y / inside.y / density, density, measure);
}

// Value times cosine towards the path, for light from the world direction `l`.
vec3 leaving(Spot spot, vec3 view, vec3 l, out float density) {
    mat3 axes = frame_of(spot.normal);
    density = 0.0;
    vec3 local = l * axes;
    // Light must come from the same side of the surface as of its shading normal.
    if (local.z == 0.0 || (local.z > 0.0) != (dot(l, spot.outward) > 0.0)) return vec3(0.0);
    vec3 v = -view * axes;
    v.z = max(v.z, 1e-3);
    return scattered(spot.bsdf, normalize(v), local, density);
}

// How often to look for the sky rather than for the sun here.
float sky_share(Spot spot) {
    float sky = frame.sky == SKY_NONE ? 0.0 : luminance(sky_irradiance(vec3(0.0, 1.0, 0.0)));
    if (!has_sun()) return 1.0;
    float facing = dot(spot.normal, frame.sun_direction);
    float reflected = luminance(spot.bsdf.reflectance);
    float transmitted = luminance(spot.bsdf.transmittance);
    float sun = luminance(frame.sun_irradiance) * (facing > 0.0 ? facing * reflected : -facing * transmitted);
    if (spot.bsdf.refractive_index > 1.0 && facing > 0.0) sun += 0.05 * luminance(frame.sun_irradiance);
    sky *= 0.5 * (reflected + transmitted) + 0.02;
    return sky + sun > 0.0 ? sky / (sky + sun) : 1.0;
}

// One of the lights, by chance: the sun or a place in the sky. No density if there is none.
Light find_light(Path path, float height_, Sampler random) {
    vec2 u = sampled(random, 3u * push.turn + 3u);
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
        radiance = frame.sun_irradiance / sun_solid_angle();
    }
    if (density <= 0.0 || path.medium == WATER && direction.y <= 0.0) return Light(vec3(0.0), vec3(0.0), 0.0, 1.0);
    if (path.medium == WATER) return through_sea(direction, radiance, density, max(frame.sea_level - height_, 0.0));
    return Light(direction, radiance / density, density, 1.0);
}

// Looks whether the light is hidden. `value` of it leaves towards the path, which finds it itself with the density `scattering`.
void look(uint index, Path path, vec3 origin, Light light, vec3 value, float scattering) {
    if (light.density <= 0.0) return;
    float balance = light.density / (light.density + scattering * light.measure);
    vec3 seen = path.throughput * value * light.radiance * balance;
    if (seen == vec3(0.0)) return;
    looks[atomicAdd(turns[push.turn].looks, 1u)] = Look(origin, light.direction, seen, index);
}

// What waves mirror: facets round the normal of those that a sample can tell apart, in whose frame the path leaves towards `v`.
// Light that a facet sends down meets another wave and is taken to come up, as if it had been mirrored by the level sea.
struct Waves {
    mat3 axes;
    vec3 v;
    float width;
};

float mirrored_by_facets(Waves waves, vec3 l) {
    vec3 local = l * waves.axes;
    vec3 sum = waves.v + local;
    if (sum.z <= 0.0) return 0.0;
    vec3 m = normalize(sum);
    float facing = dot(waves.v, m);
    return facing <= 0.0 ? 0.0 : fresnel_dielectric(facing, WATER_INDEX) * mirror_density(waves.width, waves.v, m);
}

// Value times cosine for light from `l` above the sea; it is its density, too.
float mirrored_by_waves(Waves waves, vec3 l) {
    if (l.y <= 0.0) return 0.0;
    return mirrored_by_facets(waves, l) + mirrored_by_facets(waves, vec3(l.x, -l.y, l.z));
}

// A path at the sea's surface. Coming from above it meets waves, some of which a sample can tell apart; from below the
// surface is flat, as for light that is looked for through it.
void cross_sea(uint index, inout Path path, vec3 point, Sampler random, float footprint) {
    vec3 view = path.direction;
    vec3 u = vec3(sampled(random, 3u * push.turn + 4u), sampled(random, 3u * push.turn + 5u).x);
    path.origin = vec3(point.x, frame.sea_level, point.z);
    if (path.medium == WATER) {
        float mirrored = fresnel_dielectric(view.y, 1.0 / WATER_INDEX);
        if (u.z < mirrored) {
            path.direction = vec3(view.x, -view.y, view.z);
            path.density = 0.0;
            return;
        }
        vec3 above = refract(view, vec3(0.0, -1.0, 0.0), WATER_INDEX);
        path.density *= (1.0 - mirrored) * above.y / (WATER_INDEX * WATER_INDEX * view.y);
        path.throughput *= WATER_INDEX * WATER_INDEX;
        path.direction = above;
        path.medium = AIR;
        return;
    }
    Ripples found = ripples(point.xz, footprint);
    Waves waves;
    waves.axes = frame_of(normal_from_slope(found.slope));
    waves.v = -view * waves.axes;
    waves.v.z = max(waves.v.z, 0.02);
    waves.v = normalize(waves.v);
    // α of Beckmann's facets is √2 times the deviation of their slopes.
    waves.width = clamp(1.414 * found.deviation, 0.002, 0.5);

    float sky = frame.sky == SKY_NONE ? 0.0 : 0.05 * luminance(sky_irradiance(vec3(0.0, 1.0, 0.0)));
    float sun = luminance(frame.sun_irradiance) * mirrored_by_waves(waves, frame.sun_direction);
    path.sky_share = sky + sun > 0.0 ? sky / (sky + sun) : 1.0;
    Light light = find_light(path, frame.sea_level, random);
    float value = mirrored_by_waves(waves, light.direction);
    look(index, path, path.origin, light, vec3(value), value);

    vec3 facet = visible_facet(waves.width, waves.v, u.xy);
    if (u.z < fresnel_dielectric(dot(waves.v, facet), WATER_INDEX)) {
        path.direction = waves.axes * reflect(-waves.v, facet);
        path.direction.y = max(abs(path.direction.y), 1e-5);
        path.density = mirrored_by_waves(waves, path.direction);
        return;
    }
    vec3 below = waves.axes * refract(-waves.v, facet, 1.0 / WATER_INDEX);
    below.y = min(below.y, -1e-2);
    path.direction = normalize(below);
    path.throughput /= WATER_INDEX * WATER_INDEX;
    path.density = 0.0;
    path.medium = WATER;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.turn].paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    Hit hit = hits[index];
    int pixel = push.first + int(index);
    ivec2 at = push.origin + ivec2(pixel % push.columns, pixel / push.columns);
    Sampler random = sampler_of(push.seed, at, push.index);
    vec3 view = path.direction;

    if (hit.triangle == NOTHING) {
        if (push.turn == 0u) features[index] = Feature(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0u);
        paths[index].radiance = path.radiance + path.throughput * beyond(path);
        return;
    }

    vec3 point = path.origin + hit.range * view;
    float footprint = max(path.width + path.spread * hit.range, 1e-4);
    if (path.medium == WATER) {
        vec3 left = exp(-frame.attenuation * hit.range);
        if (view.y < 0.0) {
            // What the water itself scatters back, as from an endless depth, less what lies below the bottom.
            vec3 open_light = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
            vec3 round_trip = left * exp(1.1 * frame.attenuation * view.y * hit.range);
            path.radiance += path.throughput * WATER_INDEX * WATER_INDEX * frame.deep_colour / PI * open_light * (1.0 - round_trip);
        }
        path.throughput *= left;
    } else if (frame.molecule_extinction != vec3(0.0)) {
        Veil air = veil_of(path.origin.y, view, hit.range);
        path.radiance += path.throughput * air.light;
        path.throughput *= air.transmittance;
    }
    path.width = footprint;

    if (hit.triangle == SEA) {
        if (push.turn == 0u) features[index] = Feature(vec3(0.0), vec3(0.0, 1.0, 0.0), point, hit.range, 0u);
        paths[index].radiance = path.radiance;
        if (push.turn >= push.bounces) return;
        cross_sea(index, path, point, random, footprint * inversesqrt(max(abs(view.y), 0.02)));
    } else {
        Spot spot = spot_at(hit, view, footprint);
        if (push.turn == 0u) features[index] = Feature(spot.albedo, spot.normal, spot.point, hit.range, spot.object);
        path.radiance += path.throughput * spot.emission;
        paths[index].radiance = path.radiance;
        if (push.turn >= push.bounces) return;
        path.sky_share = sky_share(spot);
        Light light = find_light(path, spot.point.y, random);
        float scattering;
        vec3 value = leaving(spot, view, light.direction, scattering);
        look(index, path, start(spot.point, spot.outward, light.direction), light, value, scattering);

        mat3 axes = frame_of(spot.normal);
        vec3 v = -view * axes;
        v.z = max(v.z, 1e-3);
        float which = sampled(random, 3u * push.turn + 5u).x;
        Scattered way = scatter(spot.bsdf, normalize(v), sampled(random, 3u * push.turn + 4u), which);
        vec3 direction = axes * way.direction;
        if (way.density <= 0.0 || (way.direction.z > 0.0) != (dot(direction, spot.outward) > 0.0)) return;
        path.origin = start(spot.point, spot.outward, direction);
        path.direction = direction;
        path.throughput *= way.weight;
        path.density = way.density;
        path.spread = 0.3;
    }
    if (push.turn >= 3u) {
        float survives = clamp(largest(path.throughput), 0.05, 0.95);
        if (sampled(random, 3u * push.turn + 5u).y >= survives) return;
        path.throughput /= survives;
    }
    paths[index] = path;
    next[atomicAdd(turns[push.turn + 1u].paths, 1u)] = index;
}
