#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// How finely each edge is divided: by its length in the whole picture, whatever tile is being drawn. An edge's level
// depends on its two ends alone and in either order, so both patches at it agree and no cracks open.

#include "lib/frame.glsl"
#include "lib/patch.glsl"

layout(vertices = 4) out;

layout(binding = 1, r32f) uniform readonly image2D height;
layout(binding = 2, scalar) readonly buffer Patches { Patch patches[]; };

#include "lib/heightfield.glsl"
#include "lib/tile.glsl"

layout(location = 0) flat in ivec2 corner[];
layout(location = 0) patch out ivec2 origin;

// Samples of the picture that one divided edge should span.
const float TARGET = 5.0;
const float LEVEL_LIMIT = 64.0;

vec3 corner_position(ivec2 at) {
    vec2 xz = vec2(at) / float(frame.patches) * frame.extent - 0.5 * frame.extent;
    return vec3(xz.x, height_bilinear(xz), xz.y);
}

float level(vec3 from, vec3 to) {
    vec3 middle = 0.5 * (from + to);
    float pixels = distance(from, to) / max(distance(frame.eye, middle), frame.near) / frame.sample_angle;
    return clamp(pixels / TARGET, 1.0, LEVEL_LIMIT);
}

// Whether the patch's box lies wholly beyond one plane of the tile's frustum.
bool unseen(ivec2 at) {
    Patch bounds = patches[at.y * frame.patches + at.x];
    // A cubic may overshoot its samples by an eighth of their range on either axis.
    float margin = 0.3 * (bounds.greatest - bounds.least) + 0.01 * frame.cell_size;
    if (bounds.greatest + margin < frame.sea_level) return true;
    vec2 side = vec2(frame.extent / float(frame.patches));
    vec2 least = vec2(at) * side - 0.5 * frame.extent;
    // For each plane, whether some corner lies on its inner side.
    bvec4 within = bvec4(false);
    bool before = false;
    for (int index = 0; index < 8; ++index) {
        vec2 xz = least + vec2(index & 1, (index >> 1) & 1) * side;
        float y = (index & 4) == 0 ? bounds.least - margin : bounds.greatest + margin;
        vec4 clip = tile_clip(vec3(xz.x, y, xz.y));
        within.x = within.x || clip.x >= -clip.w;
        within.y = within.y || clip.x <= clip.w;
        within.z = within.z || clip.y >= -clip.w;
        within.w = within.w || clip.y <= clip.w;
        before = before || clip.w > 0.0;
    }
    return !(all(within) && before);
}

void main() {
    if (gl_InvocationID != 0) return;
    origin = corner[0];
    vec3 north_west = corner_position(corner[0]);
    vec3 north_east = corner_position(corner[1]);
    vec3 south_west = corner_position(corner[2]);
    vec3 south_east = corner_position(corner[3]);
    float west = level(north_west, south_west);
    float north = level(north_west, north_east);
    float east = level(north_east, south_east);
    float south = level(south_west, south_east);
    bool drop = unseen(corner[0]);
    gl_TessLevelOuter[0] = drop ? 0.0 : west;
    gl_TessLevelOuter[1] = drop ? 0.0 : north;
    gl_TessLevelOuter[2] = drop ? 0.0 : east;
    gl_TessLevelOuter[3] = drop ? 0.0 : south;
    gl_TessLevelInner[0] = max(north, south);
    gl_TessLevelInner[1] = max(west, east);
}
