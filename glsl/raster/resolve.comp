#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// From samples to pixels: the mean of a square of samples, times the exposure, in linear light.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D radiance;
layout(binding = 1, rgba32f) uniform writeonly image2D picture;

layout(push_constant, scalar) uniform Push {
    float exposure;
} push;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(picture)))) return;
    int side = imageSize(radiance).x / imageSize(picture).x;   // of the square, in samples
    vec3 sum = vec3(0.0);
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) {
            sum += imageLoad(radiance, at * side + ivec2(column, row)).rgb;
        }
    }
    imageStore(picture, at, vec4(sum * (push.exposure / float(side * side)), 1.0));
}
