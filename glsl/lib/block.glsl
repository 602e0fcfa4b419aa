// Blocks: an invocation works on a block of COLUMNS × ROWS cells, so that they share what they read and work out of their
// neighbours. A GPU's caches do that by themselves, and it wants many invocations: there a block is a single cell.
//
// What a block and the cells round it hold lies in arrays [ROWS + 2][COLUMNS + 2], from north-west to south-east: its own cells
// are those from [1][1] on. What no cell needs of them is never loaded, since all loops are unrolled.
#ifndef BLOCK_GLSL
#define BLOCK_GLSL

#include "lib/grid.glsl"

layout(constant_id = 14) const int COLUMNS = 1;
layout(constant_id = 15) const int ROWS = 1;

// The north-western cell of the block.
ivec2 first_cell() {
    return ivec2(gl_GlobalInvocationID.xy) * ivec2(COLUMNS, ROWS);
}

// Row j and column i of the block's own cells, or of all with a rim of so many cells round it.
#define EACH_OWN(j, i) \
    [[unroll]] for (int j = 1; j <= ROWS; ++j) [[unroll]] for (int i = 1; i <= COLUMNS; ++i)
#define EACH_WITH_RIM(rim, j, i) \
    [[unroll]] for (int j = 0; j < ROWS + 2 * rim; ++j) [[unroll]] for (int i = 0; i < COLUMNS + 2 * rim; ++i)

// The neighbours of a cell in such an array.
#define AXIS_OF(values, j, i) vec4(values[j][i - 1], values[j][i + 1], values[j - 1][i], values[j + 1][i])
#define DIAGONAL_OF(values, j, i) \
    vec4(values[j - 1][i - 1], values[j - 1][i + 1], values[j + 1][i - 1], values[j + 1][i + 1])

#endif
