#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// How far from the eye the ground is; shading comes later, once a sample.

#include "lib/frame.glsl"

layout(location = 0) in vec3 point;
layout(location = 0) out float range;

void main() {
    range = distance(frame.eye, point);
}
