// What all stages know that draw tiles of the zoom. Lengths are in cells of the level that the surface is about as far away as its cells are large.
#ifndef ZOOM_VIEW_GLSL
#define ZOOM_VIEW_GLSL

layout(push_constant, scalar) uniform Push {
    float unit;         // of places in whole numbers: a power of two
    float near;         // distance of the near plane
    float altitude;     // to the surface
    float octaves;      // from the altitude to where there is nothing but sky
    vec2 fade;          // where the newest octave begins to go and where it is gone, spacings of its vertices
    float slope;        // of one unit of height a spacing
} push;

#endif
