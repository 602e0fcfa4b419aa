#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Waves by themselves, so that where they send paths can be held against the density that they claim: no picture needs this program.

#include "lib/sampler.glsl"
#include "lib/trial.glsl"
#include "lib/waves.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, scalar) buffer Trials { Trial trials[]; };

layout(push_constant, scalar) uniform Push {
    vec3 view;        // of the path, downwards
    vec2 slope;
    float deviation;
    uint choose;      // whether directions are chosen, or are there and only judged
    uint count;
} push;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.count) return;
    Waves waves = waves_of(push.slope, push.deviation, push.view);
    Trial trial = trials[index];
    if (push.choose == 1u) {
        Sampler from = sampler_of(1u, ivec2(0), index);
        Crossing way = cross_waves(waves, vec3(sampled(from, 0u), sampled(from, 1u).x));
        trial = Trial(way.direction, way.density, vec3(way.weight));
    } else {
        vec2 mirrored = mirrored_by_waves(waves, trial.direction);
        trial = Trial(trial.direction, mirrored.y, vec3(mirrored.x));
    }
    trials[index] = trial;
}
