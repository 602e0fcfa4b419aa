// What is between an eye and the ground of a zoom: haze that thickens with the octaves of distance, so that each scale looks as far as the next.
#ifndef ZOOM_VIEW_GLSL
#define ZOOM_VIEW_GLSL

#include "lib/frame.glsl"
#include "lib/sky.glsl"

// Radiance of ground that is so many octaves farther than the nearest. There is haze from `veil.x` octaves on, and from `veil.y` on nothing but the open
// sky, as if there were no ground: what lies there may or may not have been drawn.
vec3 veiled(vec3 ground, vec3 sky, vec3 open, float octaves, vec2 veil) {
    float haze = smoothstep(veil.x, veil.y, octaves);
    return haze == 1.0 ? open : mix(ground, sky, haze);
}

#endif
