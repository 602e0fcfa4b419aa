// What waves that no sample can tell apart do to a path that comes from above.
#ifndef WAVES_GLSL
#define WAVES_GLSL

#include "lib/bsdf.glsl"
#include "lib/fresnel.glsl"
#include "lib/path.glsl"
#include "lib/water.glsl"

// What waves mirror: facets round the normal of those that a sample can tell apart, in whose frame the path leaves towards `v`.
// Light that a facet sends down meets another wave and is taken to come up, as if it had been mirrored by the level sea.
struct Waves {
    mat3 axes;
    vec3 v;
    float width;
};

// Those with the mean `slope`, whose own slopes have this standard deviation, for a path in direction `view`.
Waves waves_of(vec2 slope, float deviation, vec3 view) {
    mat3 axes = frame_of(normalize(vec3(-slope.x, 1.0, -slope.y)));
    vec3 v = -view * axes;
    // α of Beckmann's facets is √2 times the deviation of their slopes.
    return Waves(axes, normalize(vec3(v.xy, max(v.z, 0.02))), clamp(1.414 * deviation, 0.002, 0.5));
}

// How often a path is mirrored by a facet that mirrors this share of light: more often than that, for the sky is brighter
// than the deep.
float mirrored_share(float fresnel) {
    const float BRIGHTER = 8.0;
    return BRIGHTER * fresnel / (BRIGHTER * fresnel + 1.0 - fresnel);
}

// Value times cosine for light from `l`, and the density with which paths take it.
vec2 mirrored_by_facets(Waves waves, vec3 l) {
    vec3 local = l * waves.axes;
    vec3 sum = waves.v + local;
    if (sum.z <= 0.0) return vec2(0.0);
    vec3 m = normalize(sum);
    float facing = dot(waves.v, m);
    if (facing <= 0.0) return vec2(0.0);
    float fresnel = fresnel_dielectric(facing, REFRACTIVE_INDEX);
    return vec2(fresnel, mirrored_share(fresnel)) * mirror_density(waves.width, waves.v, m);
}

// The same of all facets together, for light from above the sea.
vec2 mirrored_by_waves(Waves waves, vec3 l) {
    if (l.y <= 0.0) return vec2(0.0);
    return mirrored_by_facets(waves, l) + mirrored_by_facets(waves, vec3(l.x, -l.y, l.z));
}

// Where a path goes that came from above.
struct Crossing {
    vec3 direction;
    float density;   // 1/sr; 0 where only this direction could be taken
    float weight;    // of the light from there
    uint medium;
};

// From three numbers in [0, 1).
Crossing cross_waves(Waves waves, vec3 u) {
    vec3 facet = visible_facet(waves.width, waves.v, u.xy);
    float fresnel = fresnel_dielectric(dot(waves.v, facet), REFRACTIVE_INDEX);
    float share = mirrored_share(fresnel);
    if (u.z < share) {
        vec3 above = waves.axes * reflect(-waves.v, facet);
        above.y = max(abs(above.y), 1e-5);
        vec2 found = mirrored_by_waves(waves, above);
        return Crossing(above, found.y, found.y > 0.0 ? found.x / found.y : 0.0, AIR);
    }
    vec3 below = waves.axes * refract(-waves.v, facet, 1.0 / REFRACTIVE_INDEX);
    below.y = min(below.y, -1e-2);
    return Crossing(normalize(below), 0.0, (1.0 - fresnel) / (1.0 - share), WATER);
}

#endif
