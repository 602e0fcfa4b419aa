// The neighbourhood of a cell. Column i grows east, row j grows south: L and R are columns i − 1 and i + 1, T and B
// rows j − 1 (north) and j + 1. What belongs to the four neighbours along the axes is a vec4 (L, R, T, B), what belongs to the
// diagonal ones a vec4 (TL, TR, BL, BR).
//
// Workgroups are rows, and wide. A GPU hardly minds; on a CPU, rows of a power of two bytes share their cache sets, and 8 × 8 takes
// twice the time. There, too, each channel that is stored costs two or three loads, and a load of four channels less than two of
// one: kernels recompute rather than store, and what is read together lies in one image. docs/kernels.md has the figures.
#ifndef GRID_GLSL
#define GRID_GLSL

const float SQRT2 = 1.41421356;

struct Stencil {
    ivec2 L, R, T, B, TL, TR, BL, BR; // clamped to the grid
    bvec4 axis, diagonal;             // which of them exist
};

Stencil stencil(ivec2 cell, ivec2 size) {
    ivec2 lo = max(cell - 1, ivec2(0));
    ivec2 hi = min(cell + 1, size - 1);
    Stencil at;
    at.L = ivec2(lo.x, cell.y);
    at.R = ivec2(hi.x, cell.y);
    at.T = ivec2(cell.x, lo.y);
    at.B = ivec2(cell.x, hi.y);
    at.TL = lo;
    at.TR = ivec2(hi.x, lo.y);
    at.BL = ivec2(lo.x, hi.y);
    at.BR = hi;
    bvec2 after = greaterThan(cell, ivec2(0));
    bvec2 before = lessThan(cell, size - 1);
    at.axis = bvec4(after.x, before.x, after.y, before.y);
    at.diagonal = bvec4(after.x && after.y, before.x && after.y, after.x && before.y, before.x && before.y);
    return at;
}

bool outside(ivec2 cell, ivec2 size) {
    return any(greaterThanEqual(uvec2(cell), uvec2(size))); // a negative index is a large one
}

// The values of a one-channel image at the neighbours.
#define AXIS(image, at) \
    vec4(imageLoad(image, at.L).x, imageLoad(image, at.R).x, imageLoad(image, at.T).x, imageLoad(image, at.B).x)
#define DIAGONAL(image, at) \
    vec4(imageLoad(image, at.TL).x, imageLoad(image, at.TR).x, imageLoad(image, at.BL).x, imageLoad(image, at.BR).x)

// The same for four channels: one column per channel.
#define AXIS4(image, at) \
    transpose(mat4(imageLoad(image, at.L), imageLoad(image, at.R), imageLoad(image, at.T), imageLoad(image, at.B)))
#define DIAGONAL4(image, at) \
    transpose(mat4(imageLoad(image, at.TL), imageLoad(image, at.TR), imageLoad(image, at.BL), imageLoad(image, at.BR)))

// Sums that keep every bit when the grid is flipped or turned by quarters: opposite neighbours are added first.
float sum(vec4 axis) {
    precise float total = (axis.x + axis.y) + (axis.z + axis.w);
    return total;
}

float sum(vec4 axis, vec4 diagonal) {
    precise float total =
        ((axis.x + axis.y) + (axis.z + axis.w)) + ((diagonal.x + diagonal.w) + (diagonal.y + diagonal.z));
    return total;
}

float min4(vec4 v) {
    return min(min(v.x, v.y), min(v.z, v.w));
}

float max4(vec4 v) {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// Length of the gradient of a field by central differences; a neighbour off the grid counts as the cell itself.
float gradient(vec4 axis, float cell_size) {
    precise vec2 slope = (axis.yw - axis.xz) / (2.0 * cell_size);
    precise float squared = slope.x * slope.x + slope.y * slope.y;
    return sqrt(squared);
}

#endif
