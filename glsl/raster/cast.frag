#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// How far towards the sun lies what meets its light first.

layout(location = 0) in vec3 place;
layout(location = 0) out float nearest;

void main() {
    // Other maps lie beside this one.
    if (any(greaterThan(abs(place.xy), vec2(1.0)))) discard;
    nearest = place.z;
}
