// A colour that noise mixes of two: mix(from, to, clamp(noise(p · position_factor) · value_factor, 0, 1)), the noise that of
// Perlin 2002 from 0 to 1 at the place p (Rudzki 2020, equation 2.1).
#ifndef TINT_GLSL
#define TINT_GLSL

#include "lib/perlin.glsl"

struct Tint {
    vec3 from;
    vec3 to;
    float position_factor;   // 1/m
    float value_factor;
};

vec3 tinted(Tint tint, float noise) {
    return mix(tint.from, tint.to, clamp(noise * tint.value_factor, 0.0, 1.0));
}

// At `point`, where a sample covers `footprint` metres. What the sample can't resolve is the mean of the noise.
vec3 tint_at(Tint tint, vec3 point, float footprint) {
    float seen = smoothstep(1.0, 3.0, 1.0 / max(tint.position_factor * footprint, 1e-9));
    float noise = 0.5;
    if (seen > 0.0) noise += 0.5 * seen * perlin(point * tint.position_factor);
    return tinted(tint, noise);
}

#endif
