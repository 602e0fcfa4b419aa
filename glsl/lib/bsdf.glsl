// How surfaces scatter light: diffusely on both sides, with a thin rough coat on each.
#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "lib/ggx.glsl"
#include "lib/pi.glsl"
#include "lib/schlick.glsl"

// In the frame of its normal, which is on the side of the eye.
struct Bsdf {
    vec3 reflectance;
    vec3 transmittance;
    float refractive_index;   // of the coat; 1 is none
    float width;              // α of the coat's facets: the square of the roughness
};

// A direction of light that was chosen.
struct Scattered {
    vec3 direction;   // in the frame of the normal
    vec3 weight;      // value times cosine over density
    float density;    // 1/sr
};

// Two directions that make a frame with the unit vector `n` (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
mat3 frame_of(vec3 n) {
    float side = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), vec3(b, side + n.y * n.y * a, -n.y), n);
}

float largest(vec3 v) {
    return max(v.x, max(v.y, v.z));
}

// Density of the coat's facets with the normal `m`.
float facets(float width, vec3 m) {
    return ggx(width * width, m.z);
}

// Of Smith's shadowing: G₁ = 1/(1 + Λ).
float smith_lambda(float width, vec3 v) {
    float cosine = v.z * v.z;
    return 0.5 * (sqrt(1.0 + width * width * max(1.0 - cosine, 0.0) / max(cosine, 1e-12)) - 1.0);
}

// A facet that is seen from `v`, by how much of it is (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
vec3 visible_facet(float width, vec3 v, vec2 u) {
    vec3 stretched = normalize(vec3(width * v.xy, v.z));
    float level = dot(stretched.xy, stretched.xy);
    vec3 across = level > 0.0 ? vec3(-stretched.y, stretched.x, 0.0) * inversesqrt(level) : vec3(1.0, 0.0, 0.0);
    vec3 up = cross(stretched, across);
    float radius = sqrt(u.x);
    float angle = 2.0 * PI * u.y;
    float x = radius * cos(angle);
    float y = radius * sin(angle);
    float share = 0.5 * (1.0 + stretched.z);
    y = mix(sqrt(max(1.0 - x * x, 0.0)), y, share);
    vec3 facet = x * across + y * up + sqrt(max(1.0 - x * x - y * y, 0.0)) * stretched;
    return normalize(vec3(width * facet.xy, max(facet.z, 1e-6)));
}

// Density of directions mirrored by visible facets, 1/sr.
float mirror_density(float width, vec3 v, vec3 m) {
    return facets(width, m) / (1.0 + smith_lambda(width, v)) / (4.0 * v.z);
}

// How often each kind of scattering is tried: mirror, reflection, transmission. They sum to 1, or are all 0.
vec3 shares(Bsdf bsdf, vec3 v) {
    float mirrored = schlick(bsdf.refractive_index, v.z);
    vec3 all = vec3(mirrored, (1.0 - mirrored) * vec2(largest(bsdf.reflectance), largest(bsdf.transmittance)));
    float sum = all.x + all.y + all.z;
    return sum > 0.0 ? all / sum : vec3(0.0);
}

// Value times cosine for light from `l` that leaves towards `v`; `density` is that with which `l` is chosen.
vec3 scattered(Bsdf bsdf, vec3 v, vec3 l, out float density) {
    vec3 share = shares(bsdf, v);
    float facing = abs(l.z);
    // What the coat mirrors on the way in and out does not get below it.
    float through = (1.0 - schlick(bsdf.refractive_index, v.z)) * (1.0 - schlick(bsdf.refractive_index, facing));
    vec3 below = l.z > 0.0 ? bsdf.reflectance : bsdf.transmittance;
    vec3 value = below * (through * facing / PI);
    density = (l.z > 0.0 ? share.y : share.z) * facing / PI;
    if (share.x > 0.0 && l.z > 0.0) {
        vec3 m = normalize(v + l);
        float masking = 1.0 + smith_lambda(bsdf.width, v) + smith_lambda(bsdf.width, l);
        value += schlick(bsdf.refractive_index, dot(v, m)) * facets(bsdf.width, m) / (4.0 * v.z * masking);
        density += share.x * mirror_density(bsdf.width, v, m);
    }
    return value;
}

// A direction of light for `v`, from three numbers in [0, 1). The weight is 0 where there is none.
Scattered scatter(Bsdf bsdf, vec3 v, vec2 u, float which) {
    vec3 share = shares(bsdf, v);
    vec3 l;
    if (which < share.x) {
        l = reflect(-v, visible_facet(bsdf.width, v, u));
        if (l.z <= 0.0) return Scattered(l, vec3(0.0), 0.0);
    } else {
        // Uniform on the disc below (Shirley & Chiu 1997 keep neighbours together; a polar map is enough for nets).
        float radius = sqrt(u.x);
        float angle = 2.0 * PI * u.y;
        l = vec3(radius * cos(angle), radius * sin(angle), sqrt(max(1.0 - u.x, 1e-7)));
        if (which >= share.x + share.y) l.z = -l.z;
    }
    float density;
    vec3 value = scattered(bsdf, v, l, density);
    return Scattered(l, density > 0.0 ? value / density : vec3(0.0), density);
}

#endif
