// Fair-weather cumulus far out over the sea, drawn as three rings of backdrops round the eye.
#ifndef CLOUDS_GLSL
#define CLOUDS_GLSL

// How many samples wide their finest detail may be as little as; an includer that is in a hurry says more.
#ifndef CLOUD_FOOTPRINT
#define CLOUD_FOOTPRINT 1.0
#endif

const float CLOUD_BASE = 750.0;      // metres above the sea
const float CLOUD_DEPTH = 2300.0;    // of the tallest
const int CLOUD_RINGS = 4;

// One ring, `away` metres from the eye: (radiance, opacity).
vec4 cloud_ring(vec3 view, float away, uint stream) {
    float level = max(length(view.xz), 1e-3);
    vec2 outward = view.xz / level;
    float y = frame.eye.y + away * view.y / level - frame.sea_level;
    if (y < CLOUD_BASE - 100.0 || y > CLOUD_BASE + CLOUD_DEPTH) return vec4(0.0);
    // Height runs outwards in the pattern's plane: at right angles to the ring, so that it has no seam.
    float footprint = CLOUD_FOOTPRINT * away * frame.sample_angle;
    float cover = mottle(outward * away, 14000.0, 3, 0.6, footprint, stream).x;
    float depth = CLOUD_DEPTH * smoothstep(0.05, 0.95, cover + 1.3 * frame.clouds - 0.4);
    if (depth < 50.0) return vec4(0.0);
    vec3 puffs = billows(outward * (away + y), 1900.0, 8, 0.52, footprint, stream + 16u);
    float above = y - CLOUD_BASE;
    float density = 0.55 + 0.55 * puffs.x - above / depth;
    float opacity = smoothstep(0.0, 0.22, density) * smoothstep(-60.0, 90.0, above + 60.0 * puffs.x);
    if (opacity == 0.0) return vec4(0.0);

    // The pattern's slope stands for the cloud's own form.
    vec2 across = vec2(-outward.y, outward.x);
    vec2 gradient = vec2(0.55 * dot(puffs.yz, across), 0.55 * dot(puffs.yz, outward) - 1.0 / depth);
    vec3 normal = normalize(vec3(-480.0 * gradient, 1.0));
    vec3 sun = vec3(dot(frame.sun_direction.xz, across), frame.sun_direction.y, -dot(frame.sun_direction.xz, outward));
    // Inside the light is scattered many times: shadows are soft, and bases darker than tops.
    float lit = 0.35 + 0.75 * clamp(0.3 + 0.7 * dot(normal, sun), 0.0, 1.0);
    lit *= mix(0.5, 1.0, smoothstep(0.0, 0.5 * depth + 150.0, above));
    vec3 radiance = 0.75 / PI * (frame.sun_irradiance * lit + sky_irradiance(vec3(0.0, 1.0, 0.0)));
    return vec4(radiance, opacity);
}

// Draws the clouds that are nearer than `path` over `radiance`, far ones first, each behind its share of air.
vec3 with_clouds(vec3 radiance, vec3 view, float path) {
    if (!may_have_clouds(view)) return radiance;
    float away = 60000.0;
    int ring = 0;
    // Land hides most rings: a loop ends where none is left, while conditions within it cost what they skip on a device that
    // runs many samples in step.
    while (ring < CLOUD_RINGS && away >= path) {
        away *= 0.68;
        ++ring;
    }
    for (; ring < CLOUD_RINGS; ++ring) {
        vec4 cloud = cloud_ring(view, away, 501u + 32u * uint(ring));
        radiance = mix(radiance, veil(cloud.rgb, view, away), cloud.a);
        away *= 0.68;
    }
    return radiance;
}

#endif
