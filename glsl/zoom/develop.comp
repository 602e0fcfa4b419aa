#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// From samples to pixels: the mean of a square of samples, times the exposure, in linear light. Ground is seen through haze, which is the same law for
// the foreground and for the background behind it; where there is no ground there is sky.

#include "lib/frame.glsl"
#include "lib/sky.glsl"
#include "lib/zoom_view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, rgba32f) uniform readonly image2D radiance;
layout(binding = 2, rgba16f) uniform readonly image2DArray background;
layout(binding = 3, rgba32f) uniform writeonly image2D picture;

layout(push_constant, scalar) uniform Push {
    float exposure;
    float altitude;     // distance of the nearest ground
    vec2 veil;          // octaves from there to where haze begins, and to where there is nothing but sky
    float offset;       // octaves from the altitude to the unit of the background's distances
    int has_background;
    int row;            // the first one
} push;

// The face of the background in a direction, and where on it, −1…1. Twin of `faces` in zoom/background.rs.
vec3 on_face(vec3 view) {
    vec3 size = abs(view);
    if (size.x >= size.y && size.x >= size.z) {
        return vec3(sign(view.x) * view.z, -view.y, view.x > 0.0 ? 0.0 : 1.0) / vec3(size.xx, 1.0);
    }
    if (size.y >= size.z) {
        return vec3(view.x, -sign(view.y) * view.z, view.y > 0.0 ? 2.0 : 3.0) / vec3(size.yy, 1.0);
    }
    return vec3(-sign(view.z) * view.x, -view.y, view.z > 0.0 ? 4.0 : 5.0) / vec3(size.zz, 1.0);
}

vec3 behind(vec3 view) {
    vec3 sky = sky_radiance(view);
    vec3 open = sky + sun_disc_radiance(view);
    if (push.has_background == 0) return open;
    vec3 face = on_face(view);
    // A face has one more texel all around than it needs, so that it alone is asked.
    float side = float(imageSize(background).x);
    vec2 at = 0.5 * side + face.xy * (0.5 * side - 1.0) - 0.5;
    ivec2 first = ivec2(floor(at));
    vec2 share = at - vec2(first);
    vec3 sum = vec3(0.0);
    for (int corner = 0; corner < 4; ++corner) {
        ivec2 step_ = ivec2(corner & 1, corner >> 1);
        vec2 weight = mix(1.0 - share, share, vec2(step_));
        vec4 ground = imageLoad(background, ivec3(first + step_, int(face.z)));
        vec3 seen = ground.a > 0.0 ? veiled(ground.rgb, sky, open, ground.a + push.offset, push.veil) : open;
        sum += weight.x * weight.y * seen;
    }
    return sum;
}

vec3 seen(ivec2 sample_) {
    vec3 view = camera_ray(vec2(sample_) + 0.5);
    vec4 ground = imageLoad(radiance, sample_);
    if (ground.a == 0.0) return behind(view);
    float octaves = log2(ground.a / push.altitude);
    // Most of the ground is near.
    if (octaves <= push.veil.x) return ground.rgb;
    vec3 sky = sky_radiance(view);
    return veiled(ground.rgb, sky, sky + sun_disc_radiance(view), octaves, push.veil);
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, push.row);
    if (any(greaterThanEqual(at, imageSize(picture)))) return;
    vec3 sum = vec3(0.0);
    int side = imageSize(radiance).x / imageSize(picture).x;   // of the square, in samples
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) {
            sum += seen(at * side + ivec2(column, row));
        }
    }
    imageStore(picture, at, vec4(sum * (push.exposure / float(side * side)), 1.0));
}
