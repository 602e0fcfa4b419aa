#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// How far towards the sun lies what meets its light first.

layout(location = 0) in float along;
layout(location = 0) out float nearest;

void main() {
    nearest = along;
}
