#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_ray_query : require
#extension GL_GOOGLE_include_directive : require
// Finds what each path meets next, where the device traces rays itself.

#include "lib/tree.glsl"

layout(binding = 0) uniform accelerationStructureEXT world;
layout(binding = 2, scalar) readonly buffer Placements { Placement placements[]; };

#include "lib/query.glsl"
#include "lib/extend.glsl"
