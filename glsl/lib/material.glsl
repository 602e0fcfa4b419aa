// What things that stand on the ground are made of.
#ifndef MATERIAL_GLSL
#define MATERIAL_GLSL

#include "lib/hash.glsl"
#include "lib/perlin.glsl"

struct Material {
    vec3 reflectance_from;   // the two colours that noise mixes
    vec3 reflectance_to;
    vec3 transmittance;      // 0 for what light does not get through
    float position_factor;   // 1/m
    float value_factor;
    float refractive_index;  // of the thin layer of gloss
    float roughness;
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

vec3 mixed(Material material, float noise) {
    float share = clamp(noise * material.value_factor, 0.0, 1.0);
    return mix(material.reflectance_from, material.reflectance_to, share);
}

// The noise at `point`, 0…1, where a sample covers `footprint` metres. What the sample can't resolve is the mean.
float seen_noise(Material material, vec3 point, float footprint) {
    float seen = smoothstep(1.0, 3.0, 1.0 / max(material.position_factor * footprint, 1e-9));
    return seen > 0.0 ? 0.5 + 0.5 * seen * perlin(point * material.position_factor) : 0.5;
}

// Colours at `point`, where a sample covers `footprint` metres: mix(from, to, clamp(noise(p · position_factor) ·
// value_factor, 0, 1)) (Rudzki 2020, equation 2.1).
Coat coat(Material material, vec3 point, uint random, float footprint) {
    float noise = seen_noise(material, point, footprint);
    vec3 mean = mixed(material, 0.5);
    vec3 here = mixed(material, noise);
    vec3 varied = variation(random);
    vec3 share = (here + 1e-3) / (mean + 1e-3) * varied;
    return Coat(clamp(here * varied, 0.0, 0.95), clamp(material.transmittance * share, 0.0, 0.95));
}

#endif
