#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Adds the lights that nothing hides, through our own trees.

#include "lib/tree.glsl"

layout(binding = 0) uniform usamplerBuffer nodes;
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 6, r32f) uniform readonly image2D height;

#include "lib/connect.glsl"
#include "lib/bvh.glsl"
