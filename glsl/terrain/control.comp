#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// A raster stretched over one channel of the controls, interpolated bilinearly.

#include "lib/grid.glsl"
#include "lib/sample.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, rgba32f) uniform image2D controls;
layout(binding = 1, r32f) uniform readonly image2D raster;
layout(push_constant, scalar) uniform Push { uint channel; } push;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (outside(cell, imageSize(controls))) return;

    ivec2 size = imageSize(raster);
    Place at = place(cell, imageSize(controls), size);
    ivec2 next = min(at.texel + 1, size - 1);
    float north = mix(imageLoad(raster, at.texel).x, imageLoad(raster, ivec2(next.x, at.texel.y)).x, at.fraction.x);
    float south = mix(imageLoad(raster, ivec2(at.texel.x, next.y)).x, imageLoad(raster, next).x, at.fraction.x);
    vec4 value = imageLoad(controls, cell);
    value[push.channel] = mix(north, south, at.fraction.y);
    imageStore(controls, cell, value);
}
