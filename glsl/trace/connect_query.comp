#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require
// Adds the lights that nothing hides, where the device traces rays itself.

layout(binding = 0) uniform accelerationStructureEXT world;

#include "lib/connect.glsl"
#include "lib/query.glsl"
