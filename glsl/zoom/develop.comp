#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// From samples to pixels: the mean of a square of samples, times the exposure, in linear light. Where there is no ground there is sky.

#include "lib/frame.glsl"
#include "lib/sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, rgba32f) uniform readonly image2D radiance;
layout(binding = 2, rgba32f) uniform writeonly image2D picture;

layout(push_constant, scalar) uniform Push {
    int side;        // of the square, in samples
    float exposure;
} push;

vec3 background(ivec2 sample_) {
    vec3 view = camera_ray(vec2(sample_) + 0.5);
    return sky_radiance(view) + sun_disc_radiance(view);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(picture)))) return;
    vec3 sum = vec3(0.0);
    for (int row = 0; row < push.side; ++row) {
        for (int column = 0; column < push.side; ++column) {
            ivec2 sample_ = at * push.side + ivec2(column, row);
            vec4 ground = imageLoad(radiance, sample_);
            sum += ground.a > 0.0 ? ground.rgb : background(sample_);
        }
    }
    imageStore(picture, at, vec4(sum * (push.exposure / float(push.side * push.side)), 1.0));
}
