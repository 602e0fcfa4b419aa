#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Light on the zoom's surface.

#include "lib/frame.glsl"
#include "lib/sky.glsl"

layout(location = 0) in vec3 place;
layout(location = 1) in vec2 slope;
layout(location = 2) in vec3 albedo;
layout(location = 3) in float relief;

// Radiance, cd/m², and the distance.
layout(location = 0) out vec4 radiance;

// What lies in the open has all of the sky, hollows have half of it and what the ground around sends.
vec3 light(vec3 normal) {
    float openness = mix(0.45, 1.0, smoothstep(-0.7, 0.3, relief)) * (0.5 + 0.5 * normal.y);
    vec3 sun = frame.sun_irradiance * max(dot(normal, frame.sun_direction), 0.0);
    vec3 around = albedo * (frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0)));
    return sun + sky_irradiance(normal) * openness + around * (1.0 - openness);
}

void main() {
    vec3 normal = normalize(vec3(-slope.x, 1.0, -slope.y));
    radiance = vec4(albedo / PI * light(normal), length(place));
}
