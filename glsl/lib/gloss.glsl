// The thin layer of gloss on leaves and bark.
#ifndef GLOSS_GLSL
#define GLOSS_GLSL

#include "lib/ggx.glsl"
#include "lib/schlick.glsl"

// Share of light from all sides that the layer mirrors: a rough layer mirrors little at grazing angles, for its facets hide each other there
// (Lagarde 2011, "Adopting a physically based shading model").
float rough_schlick(Material material, float cosine) {
    float normal = schlick(material.refractive_index, 1.0);
    float grazing = max(1.0 - material.roughness, normal);
    float smooth_ = schlick(material.refractive_index, cosine);
    return normal + (smooth_ - normal) * (grazing - normal) / max(1.0 - normal, 1e-3);
}

// Radiance towards `eye` over the irradiance on a plane that faces `light`: microfacets (Walter et al. 2007, "Microfacet
// Models for Refraction through Rough Surfaces", with the distribution GGX and its shadowing).
float highlight(Material material, vec3 normal, vec3 eye, vec3 light, float footprint) {
    float to_light = dot(normal, light);
    float to_eye = max(dot(normal, eye), 1e-3);
    if (to_light <= 0.0 || material.refractive_index <= 1.0) return 0.0;
    vec3 middle = normalize(eye + light);
    // A mirror would show the sun as a point; no leaf is one.
    float width = max(material.roughness * material.roughness, 0.01);
    // No leaf is flat, and a sample that covers some centimetres sees it lean this way and that: without this, blades that
    // are finer than a sample glitter.
    width = max(width, 0.45 * smoothstep(0.0, 0.03, footprint));
    float square = width * width;
    float density = ggx(square, dot(normal, middle));
    // G/(4 cos cos), both sides' shadowing in one (Heitz 2014).
    float shadowing = 0.5 / (to_eye * sqrt(square + (1.0 - square) * to_light * to_light)
                             + to_light * sqrt(square + (1.0 - square) * to_eye * to_eye));
    return rough_schlick(material, dot(eye, middle)) * density * shadowing * to_light;
}

#endif
