#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// What a sample sees of a plant, to be lit later, once a sample.

#include "lib/frame.glsl"
#include "lib/octahedron.glsl"

layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 openness;
layout(location = 3) flat in uvec2 identity;

layout(location = 0) out float range;
layout(location = 1) out uvec4 plant;  // material; random number; normal; openness

void main() {
    range = -distance(frame.eye, point);
    plant = uvec4(identity.x, identity.y, pack_direction(normalize(normal)), packUnorm2x16(openness));
}
