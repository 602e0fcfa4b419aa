#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require

// Makes tiles of the zoom's surface: each from the tile that it is a quarter of, in whole numbers, or from numbers that are given. The twin of
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
// Gradients, the parts to the east and to the south.
layout(binding = 1, scalar) buffer East { int east[]; };
layout(binding = 2, scalar) buffer South { int south[]; };
// Of each seed all heights, then all gradients to the east, and those to the south.
layout(binding = 3, scalar) readonly buffer Seeds { int seeds[]; };
layout(binding = 4, scalar) readonly buffer Jobs { TileJob jobs[]; };

const uint SIDE = (1u << BITS) + 3u;
const uint VERTICES = SIDE * SIDE;

int noise_at(TileJob job, uvec2 at) {
    return noise(job.key, plus(uvec2(job.x[0], job.x[1]), at.x), plus(uvec2(job.z[0], job.z[1]), at.y));
}

// What vertices of the next level get their gradients from, at a vertex that is not in the ring.
ivec2 settled_at(uint slot, uvec2 at) {
    uint index = slot * VERTICES + at.y * SIDE + at.x;
    ivec2 slope = ivec2(heights[index + 1u] - heights[index - 1u], heights[index + SIDE] - heights[index - SIDE]);
    return settled(ivec2(east[index], south[index]), slope);
}

void main() {
    uint vertex = gl_GlobalInvocationID.x;
    if (vertex >= VERTICES) return;
    TileJob job = jobs[gl_GlobalInvocationID.y];
    uint target = job.slot * VERTICES + vertex;
    if (job.seeded == 1u) {
        uint seed = job.source * 3u * VERTICES + vertex;
        heights[target] = seeds[seed];
        east[target] = seeds[seed + VERTICES];
        south[target] = seeds[seed + 2u * VERTICES];
        return;
    }
    uvec2 own = uvec2(vertex % SIDE, vertex / SIDE);
    // Vertex 0 is one step outside, in the parent too.
    uvec2 fine = uvec2(job.quarter[0], job.quarter[1]) * (1u << BITS) + 1u + own;
    uvec2 coarse = fine / 2u;
    uvec2 odd = fine & 1u;
    // Both coordinates of the parent's first vertex are odd.
    bool rises = ((coarse.x ^ coarse.y) & 1u) == 0u;
    uint corner = job.source * VERTICES + coarse.y * SIDE + coarse.x;
    int twofold = twice(BILINEAR, equal(odd, uvec2(1u)), rises, heights[corner], heights[corner + 1u],
                        heights[corner + SIDE], heights[corner + SIDE + 1u]);
    heights[target] = twofold + noise_at(job, own) - job.shift;

    // The ring has no gradients.
    ivec2 gradient = ivec2(0);
    if (all(greaterThan(own, uvec2(0u))) && all(lessThan(own, uvec2(SIDE - 1u)))) {
        uvec2 near, far;
        ends(odd, rises, near, far);
        ivec2 first = settled_at(job.source, coarse + near);
        ivec2 second = settled_at(job.source, coarse + far);
        const uvec2 EAST = uvec2(1u, 0u), SOUTH = uvec2(0u, 1u);
        ivec2 octave = ivec2(noise_at(job, own + EAST) - noise_at(job, own - EAST),
                             noise_at(job, own + SOUTH) - noise_at(job, own - SOUTH));
        gradient = first + (second - first >> 1) + octave;
    }
    east[target] = gradient.x;
    south[target] = gradient.y;
}
