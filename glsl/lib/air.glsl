// The air between the eye and what it sees: two layers that thin exponentially with height
// (Preetham, Shirley & Smits 1999, section 3.2).
#ifndef AIR_GLSL
#define AIR_GLSL

#include "lib/luminance.glsl"

// Length of a path through a layer of density exp(−y/scale), in metres of air at the datum.
float air_column(float from_height, float to_height, float path, float scale) {
    float fall = (to_height - from_height) / scale;
    float here = exp(-from_height / scale);
    float there = exp(-to_height / scale);
    return path * (abs(fall) < 1e-3 ? 0.5 * (here + there) : (here - there) / fall);
}

// What the air does to light on its way.
struct Veil {
    vec3 transmittance;
    vec3 light;          // its own, that reaches the end, cd/m²
};

// Of the air over the distance `path` from the height `from_height` along `view`. Whatever it takes it replaces by its own
// light. On a short path that is sunlight scattered once: as bright as the horizon but white, and blue only because more of
// the blue is scattered. A long path has the horizon's colour, for it has become nothing but air.
Veil veil_of(float from_height, vec3 view, float path) {
    float to_height = from_height + view.y * path;
    vec3 depth = frame.molecule_extinction * air_column(from_height, to_height, path, frame.molecule_height)
               + frame.haze_extinction * air_column(from_height, to_height, path, frame.haze_height);
    vec3 transmittance = exp(-depth);
    vec3 horizon = sky_radiance(normalize(vec3(view.x, 0.02 * length(view.xz), view.z)));
    vec3 once = vec3(luminance(horizon));
    return Veil(transmittance, (1.0 - transmittance) * mix(horizon, once, transmittance.g));
}

// Veils `radiance` that the eye sees over the distance `path` along `view`.
vec3 veil(vec3 radiance, vec3 view, float path) {
    Veil air = veil_of(frame.eye.y, view, path);
    return radiance * air.transmittance + air.light;
}

#endif
