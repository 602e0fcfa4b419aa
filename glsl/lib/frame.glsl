// What every pass of a picture knows: camera, ground, light, sea, surface. Uploaded once a picture.
#ifndef FRAME_GLSL
#define FRAME_GLSL

#include "lib/pi.glsl"
#include "lib/tint.glsl"

const uint SKY_NONE = 0;
const uint SKY_CONSTANT = 1;
const uint SKY_PREETHAM = 2;
const uint SKY_HOSEK_WILKIE = 3;
const uint SKY_MAP = 4;

layout(binding = 0, scalar) uniform Frame {
    // Camera.
    vec3 eye;
    vec3 right;
    vec3 up;
    vec3 forward;
    vec2 tangent;            // of half the field of view, across and up
    vec2 samples;            // size of the whole picture
    float sample_angle;      // radians between neighbouring samples at the picture's centre
    float near;              // distance of the near plane

    // Ground.
    float extent;
    float cell_size;
    int cells;
    int patches;             // along one side
    float sea_level;
    float top;               // the highest ground

    // Light.
    vec3 sun_direction;
    vec3 sun_irradiance;     // on a plane that faces it, lux; 0 without a sun
    float sun_radius;        // of the disc, radians
    uint sky;
    vec3 sky_constant;       // cd/m²
    vec3 perez_zenith;       // Y (cd/m²), x, y at the zenith over F(0, θs)
    vec3 perez_a;            // of Y, x and y
    vec3 perez_b;
    vec3 perez_c;
    vec3 perez_d;
    vec3 perez_e;
    vec3 perez_sun;          // of Hosek and Wilkie's sky, too
    vec3 hosek_wilkie[9];    // A, B, C, D, E, F, G, I, H of its equation 8, each for red, green and blue
    vec3 hosek_wilkie_radiance; // cd/m²
    ivec2 sky_map_size;      // columns and rows
    float sky_map_turn;      // of its left edge, clockwise from north
    ivec2 dome_size;         // of the table that the sky is looked for by
    vec3 sky_irradiance[9];  // spherical harmonics of what a plane receives from the sky, by its normal
    vec3 molecule_extinction;
    vec3 haze_extinction;
    float molecule_height;
    float haze_height;
    float clouds;            // how much of the horizon they cover, 0…1

    // Sea.
    vec3 attenuation;
    vec3 deep_colour;
    float roughness;

    // Surface.
    vec3 grass;
    vec3 dry_grass;
    vec3 rock;
    vec3 sand;
    vec3 sea_floor;
    vec3 reef;
    vec2 rock_slope;
    vec2 dry_height;
    float beach_height;
    float beach_slope;
    float patch_size;
    float crowns;            // how far grass is painted as a forest, 0…1
    vec3 snow;
    vec2 snow_height;
    vec2 snow_slope;
    vec2 by_height;          // where rock begins, and where only rock is left; equal where height alone does not decide
    Tint low;                // ground
    Tint high;               // rock
} frame;

// Unit vector through the point `at` of the picture, in samples from its upper left corner.
vec3 camera_ray(vec2 at) {
    vec2 screen = (2.0 * at / frame.samples - 1.0) * frame.tangent;
    return normalize(frame.forward + screen.x * frame.right - screen.y * frame.up);
}

// How far away the sea is along `view`, metres; 0 where it isn't.
float range_of_sea(vec3 view) {
    return view.y < 0.0 && frame.eye.y > frame.sea_level ? (frame.sea_level - frame.eye.y) / view.y : 0.0;
}

// Whether clouds may stand there: all of them are near the horizon. It is a choice of numbers and no branch on the frame alone, for which
// lavapipe may compile the program anew each time it is run (docs/kernels.md).
bool may_have_clouds(vec3 view) {
    float steepest = frame.clouds == 0.0 ? -1.0 : 0.35;
    return abs(view.y) <= steepest;
}

#endif
