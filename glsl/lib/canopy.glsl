// What the crowns above a place leave of the light.
#ifndef CANOPY_GLSL
#define CANOPY_GLSL

// How much longer the path of the sky's light through a level layer is than the layer is thick, on average.
const float MEAN_PATH = 1.4;

// Share of the light that arrives at height `y` through leaves whose area over the place is `leaves.x` times the ground's,
// from straight above a path of 1, along a slanting ray a longer one: leaves that face every way hide half their area
// (Beer & Lambert; Monsi & Saeki 1953). `leaves` also holds the height of their top and the depth of the crowns, each times
// the area.
float through_canopy(vec4 leaves, float y, float path) {
    if (leaves.x <= 1e-4) return 1.0;
    float above = clamp((leaves.y / leaves.x - y) / max(leaves.z / leaves.x, 0.1), 0.0, 1.0);
    return exp(-0.5 * leaves.x * above * path);
}

#endif
