// What things that stand on the ground are made of.
#ifndef MATERIAL_GLSL
#define MATERIAL_GLSL

#include "lib/hash.glsl"
#include "lib/tint.glsl"

struct Material {
    Tint reflectance;
    vec3 transmittance;      // 0 for what light does not get through
    float refractive_index;  // of the thin layer of gloss
    float roughness;
    float relief;            // depth of furrows, metres
    vec3 emission;           // radiance of its own, cd/m²
};

struct Coat {
    vec3 reflectance;
    vec3 transmittance;
};

// Two numbers of mean 0 and variance 1, each the sum of two uniform ones.
vec2 spread(uint random) {
    uint a = mix_bits(random);
    uint b = mix_bits(a);
    vec4 u = vec4(a & 0xffffu, a >> 16, b & 0xffffu, b >> 16) / 65535.0 - 0.5;
    return vec2(u.x + u.y, u.z + u.w) * sqrt(6.0);
}

// How one of many differs from the others of its kind: a factor to its colour, brightness of deviation 0.10 and hue of
// deviation 0.06 in log space. A hue turns towards red or towards blue and keeps the green.
vec3 variation(uint random) {
    vec2 deviates = spread(random);
    return exp(0.10 * deviates.x + 0.06 * deviates.y * vec3(1.0, 0.0, -1.0));
}

// Height of a furrowed surface, 0…1: ridges that run upwards, and clefts where the noise is 0.
float ridge(vec3 at) {
    return min(3.0 * abs(perlin(at * vec3(1.0, 0.22, 1.0))), 1.0);
}

// Turns `normal` as furrows do; returns how much light gets into them, too. What a sample can't resolve is the mean.
float furrow(Material material, vec3 point, float footprint, inout vec3 normal) {
    const float DARKEST = 0.5;
    const float MEAN = 0.6;   // of `ridge`
    if (material.relief <= 0.0) return 1.0;
    float wavelength = 8.0 * material.relief;
    float seen = smoothstep(1.5, 5.0, wavelength / max(footprint, 1e-6));
    if (seen == 0.0) return mix(DARKEST, 1.0, MEAN);
    const float STEP = 0.1;
    vec3 at = point / wavelength;
    float here = ridge(at);
    vec3 slope = (vec3(ridge(at + vec3(STEP, 0.0, 0.0)), ridge(at + vec3(0.0, STEP, 0.0)),
                       ridge(at + vec3(0.0, 0.0, STEP))) - here) * (material.relief / (STEP * wavelength));
    normal = normalize(normal - 2.0 * seen * (slope - dot(slope, normal) * normal));
    return mix(DARKEST, 1.0, mix(MEAN, here, seen));
}

// Colours at `point`, where a sample covers `footprint` metres. Transmittance varies with the reflectance.
Coat coat(Material material, vec3 point, uint random, float footprint) {
    vec3 mean = tinted(material.reflectance, 0.5);
    vec3 here = tint_at(material.reflectance, point, footprint);
    vec3 varied = variation(random);
    vec3 share = (here + 1e-3) / (mean + 1e-3) * varied;
    Coat found = Coat(max(here * varied, 0.0), max(material.transmittance * share, 0.0));
    // Nothing sends out more than it gets, on both sides together.
    vec3 most = min(vec3(1.0), 0.95 / max(found.reflectance + found.transmittance, 1e-6));
    return Coat(most * found.reflectance, most * found.transmittance);
}

#endif
