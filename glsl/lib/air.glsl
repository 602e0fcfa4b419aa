// The air between the eye and what it sees: two layers that thin exponentially with height
// (Preetham, Shirley & Smits 1999, section 3.2).
#ifndef AIR_GLSL
#define AIR_GLSL

// Length of a path through a layer of density exp(−y/scale), in metres of air at the datum.
float air_column(float from_height, float to_height, float path, float scale) {
    float fall = (to_height - from_height) / scale;
    float here = exp(-from_height / scale);
    float there = exp(-to_height / scale);
    return path * (abs(fall) < 1e-3 ? 0.5 * (here + there) : (here - there) / fall);
}

// Veils `radiance` seen over the distance `path` along `view`. Whatever the air takes it replaces by its own light,
// which is that of the horizon: there the path is long enough to have become nothing but air.
vec3 veil(vec3 radiance, vec3 view, float path) {
    float from_height = frame.eye.y;
    float to_height = frame.eye.y + view.y * path;
    vec3 depth = frame.molecule_extinction * air_column(from_height, to_height, path, frame.molecule_height)
               + frame.haze_extinction * air_column(from_height, to_height, path, frame.haze_height);
    vec3 transmittance = exp(-depth);
    vec3 horizon = sky_radiance(normalize(vec3(view.x, 0.02, view.z)));
    return mix(horizon, radiance, transmittance);
}

#endif
