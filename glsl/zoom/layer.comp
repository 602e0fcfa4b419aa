#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Lays what was drawn of a face of the zoom's background over what lies farther away. Texels are never resampled, so errors don't add up.

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, rgba32f) uniform readonly image2D drawn;                  // radiance and distance; 0: none
layout(binding = 1, rgba16f) uniform readonly image2DArray farther;
// Radiance, and log2 of the distance in the layer's unit: more than 0, or 0 where there is no ground.
layout(binding = 2, rgba16f) uniform writeonly image2DArray composite;

layout(push_constant, scalar) uniform Push {
    int face;
    int has_farther;
    float levels;       // from the layer that is farther to this one
} push;

// The largest half float.
const float HIGHEST = 65504.0;
// Distances are told in parts of octaves that half floats have up to 2^7 octaves.
const float PARTS = 16.0;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(drawn)))) return;
    vec4 near = imageLoad(drawn, at);
    vec4 texel = vec4(0.0);
    if (near.a > 0.0) {
        float octaves = round(log2(near.a) * PARTS) / PARTS;
        texel = vec4(min(near.rgb, HIGHEST), max(octaves, 1.0 / PARTS));
    } else if (push.has_farther == 1) {
        texel = imageLoad(farther, ivec3(at, push.face));
        if (texel.a > 0.0) texel.a += push.levels;
    }
    imageStore(composite, ivec3(at, push.face), texel);
}
