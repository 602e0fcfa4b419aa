#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Sends one path from the eye through each of some pixels.

#include "lib/frame.glsl"
#include "lib/path.glsl"
#include "lib/sampler.glsl"

layout(local_size_x = GROUP) in;

layout(binding = 1, scalar) writeonly buffer Paths { Path paths[]; };
layout(binding = 2, scalar) writeonly buffer Queue { uint queue[]; };
layout(binding = 3, scalar) writeonly buffer Turns { Turn turns[]; };

layout(push_constant, scalar) uniform Push {
    uint seed;
    uint index;         // of the sample
    ivec2 origin;       // first pixel of the block, in all of the picture
    int columns;        // of the block
    int first;          // of its pixels that are at work
    int count;
    float aperture;     // radius of the lens, metres
    float focus;        // distance of what is sharp, metres
} push;

// Offset from a pixel's middle, in pixels: a tent, as wide as two pixels, by inversion.
vec2 tent(vec2 u) {
    vec2 v = 2.0 * u - 1.0;
    return sign(v) * (1.0 - sqrt(max(1.0 - abs(v), 0.0)));
}

void main() {
    int slot = int(gl_GlobalInvocationID.x);
    if (slot < turns.length()) turns[slot] = Turn(NONE, NONE, NONE, NONE, NONE, NONE);
    if (slot == 0) turns[0].paths = Waiting(uint(push.count), uvec3((uint(push.count) + GROUP - 1u) / GROUP, 1u, 1u));
    if (slot >= push.count) return;
    int pixel = push.first + slot;
    ivec2 at = push.origin + ivec2(pixel % push.columns, pixel / push.columns);
    Sampler random = sampler_of(push.seed, at, push.index);
    vec2 offset = tent(sampled(random, 0u));
    vec3 along = camera_ray(vec2(at) + 0.5 + offset);
    vec3 eye = frame.eye;
    if (push.aperture > 0.0) {
        vec2 u = sampled(random, 1u);
        float radius = push.aperture * sqrt(u.x);
        vec2 lens = radius * vec2(cos(2.0 * PI * u.y), sin(2.0 * PI * u.y));
        vec3 sharp = along * (push.focus / dot(along, frame.forward));
        vec3 shift = lens.x * frame.right + lens.y * frame.up;
        eye += shift;
        along = normalize(sharp - shift);
    }
    uint medium = eye.y < frame.sea_level ? WATER : AIR;
    paths[slot] = Path(eye, along, vec3(1.0), vec3(0.0), 0.0, 0.0, 0.0, frame.sample_angle, medium);
    queue[slot] = uint(slot);
}
