// The transfer curve of sRGB.
#ifndef SRGB_GLSL
#define SRGB_GLSL

// Linear 0…1 to encoded 0…1 (IEC 61966-2-1).
vec3 encoded(vec3 linear) {
    return mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

#endif
