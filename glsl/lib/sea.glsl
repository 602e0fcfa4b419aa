// Optics of the sea's surface and of its water.
#ifndef SEA_GLSL
#define SEA_GLSL

#include "lib/schlick.glsl"
#include "lib/water.glsl"

const float NORMAL_REFLECTANCE = 0.02112;  // ((1.34 − 1)/(1.34 + 1))²

// Share of light that waves with this standard deviation of slope reflect on average
// (Bruneton, Neyret & Holzschuch 2010, "Real-time Realistic Ocean Lighting", equation 16).
float mean_fresnel(float cosine, float deviation) {
    float grazing = pow(max(1.0 - cosine, 1e-6), 5.0 * exp(-2.69 * deviation)) / (1.0 + 22.7 * deviation * sqrt(deviation));
    return NORMAL_REFLECTANCE + (1.0 - NORMAL_REFLECTANCE) * grazing;
}

float fresnel(float cosine) {
    return schlick_from(NORMAL_REFLECTANCE, cosine);
}

struct Ripples {
    vec2 slope;        // of the waves that a sample can resolve
    float deviation;   // standard deviation of the slope of the rest
};

// Waves of 48 m to 0.75 m, all of the same mean slope.
Ripples ripples(vec2 xz, float footprint) {
    const int octaves = 7;
    // The slope of `noise` has standard deviation 1.3 per unit of wavelength.
    float amplitude = frame.roughness / (1.3 * sqrt(2.0 * float(octaves)));
    // Gusts: the wind is not the same everywhere.
    float gusts = 1.0 + 0.35 * mottle(xz * vec2(1.0, 0.6), 900.0, 3, 0.6, footprint, 211u).x;
    Ripples found = Ripples(vec2(0.0), 0.0);
    float wavelength = 48.0;
    float variance = 0.0;
    mat2 octave_frame = mat2(1.0);
    for (int octave = 0; octave < octaves; ++octave) {
        float weight = resolved(wavelength, footprint);
        if (weight > 0.0) {
            vec3 wave = noise(octave_frame * xz / wavelength, 201u + uint(octave));
            found.slope += weight * amplitude * (wave.yz * octave_frame);
        }
        variance += (1.0 - weight * weight) / float(octaves);
        wavelength *= 0.5;
        octave_frame = mat2(0.6, 0.8, -0.8, 0.6) * octave_frame;
    }
    found.slope *= gusts;
    found.deviation = gusts * frame.roughness * sqrt(variance);
    return found;
}

// Radiance of the sun mirrored by waves of Gaussian slopes (Cox & Munk 1954; Bruneton et al. 2010, equation 17).
vec3 glitter(vec3 view, Ripples waves) {
    vec3 facet = frame.sun_direction - view;
    // No wave is so steep as to mirror the sun from further down.
    if (facet.y <= max(1e-3 * length(facet), 1e-9)) return vec3(0.0);
    facet = normalize(facet);
    vec2 slope = -facet.xz / facet.y - waves.slope;
    // The disc is as wide as this much roughness.
    float variance = 0.5 * waves.deviation * waves.deviation + frame.sun_radius * frame.sun_radius;
    float density = exp(-0.5 * dot(slope, slope) / variance) / (2.0 * PI * variance);
    float facing = max(-view.y, 0.03);
    return frame.sun_irradiance * fresnel(dot(facet, frame.sun_direction)) * density
         / (4.0 * facing * facet.y * facet.y * facet.y * facet.y);
}

#endif
