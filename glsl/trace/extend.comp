#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Finds what each path meets next, through our own trees.

#include "lib/tree.glsl"

layout(binding = 0, scalar) readonly buffer Nodes { Node nodes[]; };
layout(binding = 1, scalar) readonly buffer Triangles { Triangle triangles[]; };
layout(binding = 2, scalar) readonly buffer Placements { Placement placements[]; };

#include "lib/bvh.glsl"
#include "lib/extend.glsl"
