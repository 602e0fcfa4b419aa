#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Makes tiles of the zoom's surface: each from the tile that it is a quarter of, in whole numbers, or from heights that are given. The twin of
// `Tile::child`. A row of work is a tile.

#include "lib/zoom_height.glsl"

layout(local_size_x = 64, local_size_y = 1) in;
layout(constant_id = 0) const uint BITS = 7u;           // log2 of the quads along a side
layout(constant_id = 1) const bool BILINEAR = false;

struct TileJob {
    uint slot;          // where to
    uint source;        // the parent's slot, or which of the seeds
    uint seeded;        // 1: the heights are those of a seed
    uint key;           // of the level's random numbers
    uint quarter[2];    // 0 or 1 along x and z
    uint x[2];          // of the first vertex, outside the tile, modulo 2^64: the lower word first
    uint z[2];
    int shift;          // the tile's base less twice its parent's
};

layout(binding = 0, scalar) buffer Heights { int heights[]; };
layout(binding = 1, scalar) readonly buffer Seeds { int seeds[]; };
layout(binding = 2, scalar) readonly buffer Jobs { TileJob jobs[]; };

void main() {
    uint side = (1u << BITS) + 3u;
    uint vertices = side * side;
    uint vertex = gl_GlobalInvocationID.x;
    if (vertex >= vertices) return;
    TileJob job = jobs[gl_GlobalInvocationID.y];
    uint target = job.slot * vertices + vertex;
    if (job.seeded == 1u) {
        heights[target] = seeds[job.source * vertices + vertex];
        return;
    }
    uvec2 own = uvec2(vertex % side, vertex / side);
    // Vertex 0 is one step outside, in the parent too.
    uvec2 fine = uvec2(job.quarter[0], job.quarter[1]) * (1u << BITS) + 1u + own;
    uvec2 coarse = fine / 2u;
    bvec2 odd = equal(fine & 1u, uvec2(1u));
    // Both coordinates of the parent's first vertex are odd.
    bool rises = ((coarse.x ^ coarse.y) & 1u) == 0u;
    uint corner = job.source * vertices + coarse.y * side + coarse.x;
    int twofold = twice(BILINEAR, odd, rises, heights[corner], heights[corner + 1u],
                        heights[corner + side], heights[corner + side + 1u]);
    uvec2 x = plus(uvec2(job.x[0], job.x[1]), own.x);
    uvec2 z = plus(uvec2(job.z[0], job.z[1]), own.y);
    heights[target] = twofold + noise(job.key, x, z) - job.shift;
}
