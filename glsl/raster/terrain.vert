#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// One instance is one square patch of ground, one vertex is one of its corners.

#include "lib/frame.glsl"

layout(location = 0) flat out ivec2 corner;  // column and row of the patch corner, in patches

void main() {
    ivec2 origin = ivec2(gl_InstanceIndex % frame.patches, gl_InstanceIndex / frame.patches);
    corner = origin + ivec2(gl_VertexIndex & 1, gl_VertexIndex >> 1);
}
