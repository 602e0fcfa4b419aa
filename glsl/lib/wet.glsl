// Ground under water. `lib/sky.glsl` and `lib/sea.glsl` stand before.
#ifndef WET_GLSL
#define WET_GLSL

// Light from rivers and lakes: water over the bed mirrors as much of the sky as the valley leaves open.
vec3 wet(vec3 bed, vec3 view, float depth, float openness) {
    float film = smoothstep(0.08, 0.6, depth);
    vec3 mirror = normalize(vec3(view.x, max(-view.y, 0.15), view.z));
    vec3 mirrored = mix(bed, sky_radiance(mirror), openness * openness);
    vec3 through = bed * exp(-2.0 * frame.attenuation * depth) * 0.7;
    return mix(bed, mix(through, mirrored, fresnel(clamp(-view.y, 0.0, 1.0))), film);
}

// What the bottom of the sea sends up to the surface that is `depth` metres above it, where that much sunlight arrives. Refraction turns
// the sun upright; diffuse light travels 1.2 times the depth. Of what the bottom sends up 48 % is mirrored back down at a surface that
// it can't leave (Lee et al. 1998, "Hyperspectral remote sensing for shallow waters").
vec3 drowned(vec3 albedo, vec3 normal, vec3 sun, float openness, float depth) {
    float sine = length(frame.sun_direction.xz) / REFRACTIVE_INDEX;
    float cosine = sqrt(1.0 - sine * sine);
    vec3 sun_in_water = normalize(vec3(frame.sun_direction.xz / REFRACTIVE_INDEX, cosine)).xzy;
    vec3 light = sun * (1.0 - fresnel(max(frame.sun_direction.y, 0.0))) * max(dot(normal, sun_in_water), 0.0)
               * exp(-frame.attenuation * depth / cosine)
               + sky_irradiance(vec3(0.0, 1.0, 0.0)) * 0.934 * openness * exp(-1.2 * frame.attenuation * depth);
    vec3 returned = 1.0 - 0.48 * albedo * exp(-2.4 * frame.attenuation * depth);
    return albedo / PI * light / returned;
}

#endif
