// Light at a smooth surface between two media.
#ifndef FRESNEL_GLSL
#define FRESNEL_GLSL

// Fresnel's reflectance of unpolarised light that comes at `cosine` into what is `index` times as dense.
float fresnel_dielectric(float cosine, float index) {
    float sine = 1.0 - (1.0 - cosine * cosine) / (index * index);
    if (sine <= 0.0) return 1.0;
    float inside = sqrt(sine);
    float parallel = (index * cosine - inside) / (index * cosine + inside);
    float across = (cosine - index * inside) / (cosine + index * inside);
    return 0.5 * (parallel * parallel + across * across);
}

#endif
