#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Scattering by itself, so that what it chooses can be held against the density that it claims: no picture needs this program.

#include "lib/sampler.glsl"
#include "lib/bsdf.glsl"
#include "lib/trial.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, scalar) buffer Trials { Trial trials[]; };

layout(push_constant, scalar) uniform Push {
    vec3 view;
    float reflectance;
    float transmittance;
    float refractive_index;
    float width;
    uint choose;      // whether directions are chosen, or are there and only judged
    uint count;
} push;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= push.count) return;
    Bsdf bsdf = Bsdf(vec3(push.reflectance), vec3(push.transmittance), push.refractive_index, push.width);
    Trial trial = trials[index];
    if (push.choose == 1u) {
        Sampler from = sampler_of(1u, ivec2(0), index);
        Scattered way = scatter(bsdf, push.view, sampled(from, 0u), sampled(from, 1u).x);
        trial = Trial(way.direction, way.density, way.weight);
    } else {
        trial.value = scattered(bsdf, push.view, trial.direction, trial.density);
    }
    trials[index] = trial;
}
