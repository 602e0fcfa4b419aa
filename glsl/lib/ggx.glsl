// The facets of a rough surface.
#ifndef GGX_GLSL
#define GGX_GLSL

#include "lib/pi.glsl"

// Density of facets whose normals lie at this cosine to the surface's: weighted with that cosine its integral over directions is 1.
// `square` is α², how wide they are scattered (GGX: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces",
// equation 33).
float ggx(float square, float cosine) {
    float spread = cosine * cosine * (square - 1.0) + 1.0;
    return square / (PI * spread * spread);
}

#endif
