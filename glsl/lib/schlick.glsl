// Fresnel's reflectance, approximately.
#ifndef SCHLICK_GLSL
#define SCHLICK_GLSL

// Share of light that a surface of this refractive index mirrors (Schlick 1994).
float schlick(float refractive_index, float cosine) {
    float normal = (refractive_index - 1.0) / (refractive_index + 1.0);
    normal *= normal;
    float grazing = clamp(1.0 - cosine, 0.0, 1.0);
    float square = grazing * grazing;
    // Without a layer there is nothing to mirror, at no angle.
    return refractive_index <= 1.0 ? 0.0 : normal + (1.0 - normal) * square * square * grazing;
}

#endif
