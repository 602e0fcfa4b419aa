#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// The sky by itself, so that it can be held against its formulas: no picture needs this program.

#include "lib/frame.glsl"
#include "lib/sky.glsl"

layout(local_size_x = 64) in;

// Unit vectors, and then the radiance from there.
layout(binding = 1, scalar) buffer Looks { vec3 looks[]; };

layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < push.count) looks[index] = sky_radiance(looks[index]);
}
