// Fresnel's reflectance, approximately.
#ifndef SCHLICK_GLSL
#define SCHLICK_GLSL

// Share of light that a surface mirrors at this cosine to its normal, and `normal` of what comes along that (Schlick 1994, "An
// Inexpensive BRDF Model for Physically-based Rendering", equation 15).
float schlick_from(float normal, float cosine) {
    float grazing = clamp(1.0 - cosine, 0.0, 1.0);
    float square = grazing * grazing;
    return normal + (1.0 - normal) * square * square * grazing;
}

// Of a surface of this refractive index.
float schlick(float refractive_index, float cosine) {
    float normal = (refractive_index - 1.0) / (refractive_index + 1.0);
    normal *= normal;
    // Without a layer there is nothing to mirror, at no angle.
    return refractive_index <= 1.0 ? 0.0 : schlick_from(normal, cosine);
}

#endif
