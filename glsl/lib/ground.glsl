// The land's triangles, two in each cell of the grid, worked out from its heights. The includer declares `height`, the r32f image of
// metres above the datum.
#ifndef GROUND_GLSL
#define GROUND_GLSL

#include "lib/lattice.glsl"

// Flag of their numbers: other triangles lie in a buffer.
const uint GRID = 0x80000000u;

// Cells of a leaf of the land's tree, across and down, and of the eight leaves of a node.
const ivec2 TILE = ivec2(2, 1);
const ivec2 BLOCK = ivec2(4, 4);

// Bits of a block's column in what names its leaves (`src/trace/ground.rs`).
const uint COLUMN_BITS = 13u;

vec3 ground_corner(ivec2 at, Lattice lattice) {
    precise vec2 xz = vec2(at) * lattice.cell_size - lattice.half_extent;
    return vec3(xz.x, imageLoad(height, at).x, xz.y);
}

// Corners of the land's triangle of this number.
mat3 ground_corners(uint number, Lattice lattice) {
    int columns = imageSize(height).x - 1;
    int cell = int((number & ~GRID) >> 1);
    ivec2 nw = ivec2(cell % columns, cell / columns);
    vec3 ne = ground_corner(nw + ivec2(1, 0), lattice);
    vec3 sw = ground_corner(nw + ivec2(0, 1), lattice);
    if ((number & 1u) == 0u) return mat3(ground_corner(nw, lattice), sw, ne);
    return mat3(ne, sw, ground_corner(nw + ivec2(1, 1), lattice));
}

// First cell of a leaf.
ivec2 tile_cell(uint leaf) {
    uint block = leaf >> 3;
    ivec2 at = BLOCK * ivec2(block & ((1u << COLUMN_BITS) - 1u), block >> COLUMN_BITS);
    return at + TILE * ivec2(leaf & 1u, leaf >> 1 & 3u);
}

#endif
