// Blocks: an invocation works on ROWS cells of one column, from north to south, so that they share what they read and work out
// of their neighbours. A GPU's caches do that by themselves, and it wants many invocations: there blocks have one row.
#ifndef BLOCK_GLSL
#define BLOCK_GLSL

#include "lib/grid.glsl"

layout(constant_id = 15) const int ROWS = 1;

// Three cells of a row that touch a block, clamped to the grid.
struct Row {
    ivec2 west, middle, east;
};

// The northernmost cell of the block.
ivec2 first_cell() {
    return ivec2(gl_GlobalInvocationID.xy) * ivec2(1, ROWS);
}

// Row j of the ROWS + 2 that touch a block: 0 lies north of it, 1 to ROWS are its own.
Row row(ivec2 first, int j, ivec2 size) {
    int y = clamp(first.y + j - 1, 0, size.y - 1);
    return Row(ivec2(max(first.x - 1, 0), y), ivec2(first.x, y), ivec2(min(first.x + 1, size.x - 1), y));
}

// The values of a one-channel image in a row, from west to east.
#define ROW(image, at) vec3(imageLoad(image, at.west).x, imageLoad(image, at.middle).x, imageLoad(image, at.east).x)
// The same for four channels: one column per channel.
#define ROW4(image, at) \
    transpose(mat3x4(imageLoad(image, at.west), imageLoad(image, at.middle), imageLoad(image, at.east)))

// The neighbours of a cell among the rows north of it, its own and south of it.
vec4 axis_of(vec3 north, vec3 own, vec3 south) {
    return vec4(own.x, own.z, north.y, south.y);
}

vec4 diagonal_of(vec3 north, vec3 own, vec3 south) {
    return vec4(north.x, north.z, south.x, south.z);
}

#endif
