#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// The sea bed settles to the mean of its four neighbours (Korošec & Lebar Bajec (23)).

#include "lib/grid.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(constant_id = 0) const bool CONTROLS = false;
layout(binding = 0, r32f) uniform readonly image2D height_in;
layout(binding = 1, r32f) uniform writeonly image2D height_out;
layout(binding = 2, r32f) uniform image2D change;
layout(binding = 3, rgba32f) uniform readonly image2D controls;
layout(push_constant, scalar) uniform Push { float sea_level; } push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height_in))) return;

    Stencil at = stencil(cell, imageSize(height_in));
    float h = imageLoad(height_in, cell).x;
    float settled = h < push.sea_level && all(at.axis) ? sum(AXIS(height_in, at)) / 4.0 : h;
    if (CONTROLS) {
        precise float masked = h + imageLoad(controls, cell).z * (settled - h);
        settled = masked;
    }
    precise float e = imageLoad(change, cell).x + (settled - h);
    imageStore(change, cell, vec4(e));
    imageStore(height_out, cell, vec4(settled));
}
