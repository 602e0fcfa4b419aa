#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Lays false colours over a developed picture: what a layer of the land holds where a sample sees ground, or water over it.

#include "lib/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 1, r32f) uniform readonly image2D range;
layout(binding = 2, r32f) uniform readonly image2D values;
layout(binding = 3, rgba32f) uniform readonly image2D weights;
layout(binding = 4, scalar) readonly buffer Colours { vec3 colours[]; };   // encoded
layout(binding = 5, rgba8) uniform image2D picture;

layout(push_constant, scalar) uniform Push {
    vec2 bounds;     // values of the first colour and of the last one
    float opacity;
    uint scale;      // of the values: LINEAR, LOGARITHMIC; WEIGHTS mixes a colour for each weight
    int first;       // row of pixels that the first invocations are of
} push;

const uint LINEAR = 0u;
const uint LOGARITHMIC = 1u;
const uint WEIGHTS = 2u;

#include "lib/fields.glsl"

vec3 colour_of(float value) {
    vec2 bounds = push.bounds;
    if (push.scale == LOGARITHMIC) {
        value = log(max(value, bounds.x));
        bounds = log(bounds);
    }
    int last = colours.length() - 1;
    float at = clamp((value - bounds.x) / (bounds.y - bounds.x), 0.0, 1.0) * float(last);
    int below = min(int(at), last - 1);
    return mix(colours[below], colours[below + 1], at - float(below));
}

vec3 colour_at(vec2 xz) {
    Stencil s = stencil(xz, frame.cells);
    if (push.scale != WEIGHTS) return colour_of(BILINEAR(values, s).x);
    vec4 share = BILINEAR(weights, s);
    return share.x * colours[0] + share.y * colours[1] + share.z * colours[2] + share.w * colours[3];
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, push.first);
    if (any(greaterThanEqual(at, imageSize(picture)))) return;
    vec3 sum = vec3(0.0);
    float covered = 0.0;
    int side = imageSize(range).x / imageSize(picture).x;   // of the square of samples in a pixel
    for (int index = 0; index < side * side; ++index) {
        ivec2 sample_ = at * side + ivec2(index % side, index / side);
        vec3 view = camera_ray(vec2(sample_) + 0.5);
        float path = abs(imageLoad(range, sample_).x);
        float sea = range_of_sea(view);
        if (sea > 0.0 && (path == 0.0 || sea < path)) path = sea;
        vec2 xz = frame.eye.xz + path * view.xz;
        if (path == 0.0 || any(greaterThan(abs(xz), vec2(0.5 * frame.extent)))) continue;
        sum += colour_at(xz);
        covered += 1.0;
    }
    if (covered == 0.0) return;
    float opacity = push.opacity * covered / float(side * side);
    imageStore(picture, at, vec4(mix(imageLoad(picture, at).rgb, sum / covered, opacity), 1.0));
}
