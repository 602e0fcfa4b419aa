#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Gives the corners of the land's triangles the normals and colours that pictures with constant materials have.

#include "lib/frame.glsl"

layout(local_size_x = 64) in;

layout(binding = 2, r32f) uniform readonly image2D height;
layout(binding = 3, r32f) uniform readonly image2D wetness;
layout(binding = 4, r32f) uniform readonly image2D reef;
layout(binding = 5, r32f) uniform readonly image2D openness;

#include "lib/heightfield.glsl"
#include "lib/fields.glsl"
#include "lib/texture.glsl"
#include "lib/surface.glsl"
#include "lib/corner.glsl"

layout(binding = 1, scalar) buffer Corners { Corner corners[]; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= corners.length()) return;
    corners[index] = corner_at(corners[index].point);
}
