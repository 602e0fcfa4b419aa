#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// From samples to what a screen shows: the mean of a square of samples, times the exposure, through a tone map, as sRGB of 8 bits. Steps
// of one value are dithered, as in `scene/picture.rs`.

#include "lib/tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D radiance;
layout(binding = 1, rgba8) uniform writeonly image2D picture;

// A constant, and the side of the square is asked from the images: nothing branches on push constants alone (docs/kernels.md).
layout(constant_id = 0) const uint TONE_MAP = 0;

layout(push_constant, scalar) uniform Push {
    float exposure;
    int first;       // row of pixels that the first invocations are of
} push;

// Evenly spread over 0…1 in every small neighbourhood (Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare").
float dither(ivec2 at) {
    return fract(52.9829189 * fract(dot(vec2(at), vec2(0.06711056, 0.00583715))));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, push.first);
    if (any(greaterThanEqual(at, imageSize(picture)))) return;
    int side = imageSize(radiance).x / imageSize(picture).x;
    vec3 sum = vec3(0.0);
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) {
            sum += imageLoad(radiance, at * side + ivec2(column, row)).rgb;
        }
    }
    vec3 linear = sum * (push.exposure / float(side * side));
    imageStore(picture, at, vec4(floor(shown(linear, TONE_MAP) * 255.0 + dither(at)) / 255.0, 1.0));
}
