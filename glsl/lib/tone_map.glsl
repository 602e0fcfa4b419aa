// From scene to screen: twin of `core/color.rs`.
#ifndef TONE_MAP_GLSL
#define TONE_MAP_GLSL

#include "lib/srgb.glsl"

const uint CLAMP = 0u;
const uint FILMIC = 1u;

// The scene value that becomes white, in units of the film's white; middle grey, which stays; the slope there in log-log scale.
const float WHITE = 6.0;
const float MIDDLE_GREY = 0.18;
const float CONTRAST = 1.3;

// Columns of red, green and blue.
const mat3 MIX = mat3(0.88, 0.06, 0.04, 0.09, 0.80, 0.08, 0.03, 0.14, 0.88);
const mat3 UNMIX = mat3(1.243808, -0.130031, -0.071981, -0.176471, 1.294118, -0.176471, -0.067337, -0.164087, 1.248452);

vec3 filmic_curve(vec3 x) {
    float grey = pow(MIDDLE_GREY, CONTRAST);
    float white = pow(WHITE, CONTRAST);
    float b = (grey / MIDDLE_GREY - white) / (grey - white);
    float c = white - b * white;
    x = pow(max(x, 0.0), vec3(CONTRAST));
    return x / (b * x + c);
}

// 0…1, encoded, of linear light in which 1 is the film's white.
vec3 shown(vec3 linear, uint tone_map) {
    // A float that is infinite, or no number, must not spread.
    linear = clamp(linear, 0.0, 1e6);
    if (tone_map == FILMIC) linear = UNMIX * filmic_curve(MIX * linear);
    return encoded(clamp(linear, 0.0, 1.0));
}

#endif
