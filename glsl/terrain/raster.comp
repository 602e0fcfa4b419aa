#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// A raster stretched over the grid, interpolated by Catmull–Rom splines.

#include "lib/combine.glsl"
#include "lib/grid.glsl"
#include "lib/sample.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform image2D height;
layout(binding = 1, r32f) uniform readonly image2D raster;
layout(push_constant, scalar) uniform Push { float reference; } push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(height))) return;

    ivec2 size = imageSize(raster);
    Place at = place(cell, imageSize(height), size);
    vec4 across = cubic(at.fraction.x);
    vec4 down = cubic(at.fraction.y);
    float value = 0.0;
    for (int row = 0; row < 4; ++row) {
        vec4 texels;
        for (int column = 0; column < 4; ++column) {
            ivec2 texel = at.texel + ivec2(column, row) - 1;
            texels[column] = imageLoad(raster, clamp(texel, ivec2(0), size - 1)).x;
        }
        value += down[row] * dot(across, texels);
    }
    imageStore(height, cell, vec4(combine(imageLoad(height, cell).x, value, push.reference)));
}
