#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// One pass of diamond–square (Fournier, Fussell & Carpenter 1982): the corners, the centres of squares, or the midpoints of
// their edges. Each point is set once, from points that earlier passes set.

#include "lib/grid.glsl"
#include "lib/hash.glsl"

layout(local_size_x = 128, local_size_y = 1) in;
layout(binding = 0, r32f) uniform image2D points;
// Corners, squares, diamonds.
layout(constant_id = 0) const uint PHASE = 0;
layout(push_constant, scalar) uniform Push {
    int spacing; // between the points that this pass considers
    float spread;
    uint seed;
} push;

float at(ivec2 point) {
    return imageLoad(points, point).x;
}

// The sum of a pair of neighbours and how many of them lie on the map.
vec2 pair(ivec2 point, ivec2 offset, int size) {
    ivec2 lo = point - offset;
    ivec2 hi = point + offset;
    bool has_lo = all(greaterThanEqual(lo, ivec2(0)));
    bool has_hi = all(lessThan(hi, ivec2(size)));
    return vec2((has_lo ? at(max(lo, ivec2(0))) : 0.0) + (has_hi ? at(min(hi, ivec2(size - 1))) : 0.0),
                float(has_lo) + float(has_hi));
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID.xy);
    ivec2 point = index * push.spacing;
    int size = imageSize(points).x;
    if (outside(point, ivec2(size))) return;

    float mean = 0.0;
    if (PHASE == 1u) {
        if (any(equal(index & 1, ivec2(0)))) return;
        int s = push.spacing;
        mean = ((at(point - s) + at(point + s)) + (at(point + ivec2(s, -s)) + at(point + ivec2(-s, s)))) / 4.0;
    } else if (PHASE == 2u) {
        if (((index.x ^ index.y) & 1) == 0) return;
        vec2 row = pair(point, ivec2(push.spacing, 0), size);
        vec2 column = pair(point, ivec2(0, push.spacing), size);
        mean = (row.x + column.x) / (row.y + column.y);
    }
    imageStore(points, point, vec4(mean + push.spread * signed_unit(hash(push.seed, point))));
}
