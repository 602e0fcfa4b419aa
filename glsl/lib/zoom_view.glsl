// What is between an eye and the ground of a zoom: haze that thickens with the octaves of distance, so that each scale looks as far as the next.
#ifndef ZOOM_VIEW_GLSL
#define ZOOM_VIEW_GLSL

#include "lib/frame.glsl"
#include "lib/sky.glsl"

// Radiance of ground that is so many octaves farther than the nearest. From `limit` on there is nothing but sky, exactly.
vec3 veiled(vec3 ground, vec3 sky, float octaves, float limit) {
    float haze = smoothstep(0.5 * limit, limit, octaves);
    return haze == 1.0 ? sky : mix(ground, sky, haze);
}

#endif
