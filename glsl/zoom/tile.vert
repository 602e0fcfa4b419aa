#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require

// Places the vertices of the zoom's tiles. Places are whole numbers until they are rounded once, so vertices that tiles share are the same bits,
// whatever the tiles' levels are, and there are no cracks.

#include "lib/frame.glsl"
#include "lib/zoom_height.glsl"
#include "lib/zoom_material.glsl"

layout(constant_id = 0) const uint BITS = 7u;           // log2 of the quads along a side
layout(constant_id = 1) const bool BILINEAR = false;

// Levels from a tile to the one that its heights are compared with.
const uint RELIEF_LEVELS = 6u;
const uint NO_SLOT = 0xffffffffu;

// The heights of a tile, and what they are compared with.
struct TileSource {
    uint slot;
    uint reference;     // slot of the tile RELIEF_LEVELS coarser, or none
    uint first[2];      // where the tile begins in that one, spacings of its own vertices
    int rise;           // its base less that one's, in its own unit
    float relief;       // of one unit of height
};

struct TileView {
    int64_t origin[3];  // from the eye to its first vertex at its base: east, up, south, in whole numbers
    TileSource own;
    TileSource parent;
    uint quarter[2];    // of its parent, 0 or 1 along x and z
    uint shift;         // log2 of the spacing of its vertices in whole numbers
    uint height_shift;  // log2 of a unit of height
    uint level;         // of its vertices
    uint key;           // of that level's random numbers
    uint x[2];          // of the first vertex modulo 2^64: the lower word first
    uint z[2];
    uint borders;       // as zoom/tree.rs has them; bit 16: it has no parent
    float spacing;      // of its vertices
};

layout(binding = 1, scalar) readonly buffer Heights { int heights[]; };
layout(binding = 2, scalar) readonly buffer Tiles { TileView tiles[]; };
// What the surface is shaded by, over two spacings.
layout(binding = 3, scalar) readonly buffer East { int east[]; };
layout(binding = 4, scalar) readonly buffer South { int south[]; };

// Lengths are in cells of a level that is as coarse as what is drawn is near.
layout(push_constant, scalar) uniform Push {
    float unit;         // of places in whole numbers: a power of two
    float near;         // distance of the near plane
    vec2 fade;          // where the newest octave begins to go and where it is gone, spacings of its vertices
    vec3 focus;         // what that is counted from: where the tiles have been selected for, from the eye
    float slope;        // of one unit of height a spacing
} push;

layout(location = 0) out vec3 place;
layout(location = 1) out vec2 slope;        // rise to the east and to the south
layout(location = 2) out vec3 albedo;
layout(location = 3) out float relief;
layout(location = 4) out vec2 grid;         // quads from the tile's first vertex
layout(location = 5) flat out uint level;   // of the tile

const int SIDE = 1 << int(BITS);

// Where a vertex is that is counted from the tile's first. There is a ring of one more around.
uint index(uint slot, ivec2 at) {
    uint side = uint(SIDE + 3);
    return slot * side * side + uint(at.y + 1) * side + uint(at.x + 1);
}

int height(uint slot, ivec2 at) {
    return heights[index(slot, at)];
}

// The surface at a vertex, as its level has it.
struct Ground {
    vec2 slope;
    float relief;       // above the surface some levels coarser, −1…1
    vec3 albedo;
};

// The height between the corners of a cell, 0 and b, c, d, as refinement has it: on two triangles or on a bilinear patch. Any other surface would leave
// traces of the coarse cells.
float between(bool rises, vec2 t, float b, float c, float d) {
    if (BILINEAR) return b * t.x + c * t.y + (d - b - c) * t.x * t.y;
    if (rises) return t.x > t.y ? b * t.x + (d - b) * t.y : c * t.y + (d - c) * t.x;
    return t.x + t.y < 1.0 ? b * t.x + c * t.y : d + (c - d) * (1.0 - t.x) + (b - d) * (1.0 - t.y);
}

Ground ground_at(TileSource source, ivec2 at, uint level) {
    uint vertex = index(source.slot, at);
    Ground ground;
    ground.slope = 0.5 * push.slope * vec2(east[vertex], south[vertex]);
    int here = heights[vertex] + source.rise;
    float above = float(here);
    if (source.reference != NO_SLOT) {
        ivec2 fine = ivec2(source.first[0], source.first[1]) + at;
        ivec2 coarse = fine >> RELIEF_LEVELS;
        vec2 t = vec2(fine - (coarse << RELIEF_LEVELS)) / float(1 << RELIEF_LEVELS);
        int a = height(source.reference, coarse);
        // Differences are small, so they are exact.
        float b = float(height(source.reference, coarse + ivec2(1, 0)) - a);
        float c = float(height(source.reference, coarse + ivec2(0, 1)) - a);
        float d = float(height(source.reference, coarse + ivec2(1, 1)) - a);
        float coarser = between(((coarse.x ^ coarse.y) & 1) == 0, t, b, c, d);
        above = float(here - (a << RELIEF_LEVELS)) - float(1 << RELIEF_LEVELS) * coarser;
    }
    ground.relief = clamp(above * source.relief, -1.0, 1.0);
    ground.albedo = reflectance(length(ground.slope), ground.relief, level);
    return ground;
}

// The same as the coarser surface has it: the mean of the ends of the edge or diagonal that the vertex splits.
Ground coarse_ground(TileView tile, ivec2 at) {
    ivec2 fine = ivec2(tile.quarter[0], tile.quarter[1]) * SIDE + at;
    ivec2 first = fine >> 1;
    ivec2 odd = fine & 1;
    ivec2 last = first + odd;
    bool falls = ((first.x ^ first.y) & 1) == 1;
    if (odd == ivec2(1) && falls) {
        first.x += 1;
        last.x -= 1;
    }
    Ground ground = ground_at(tile.parent, first, tile.level - 1u);
    if (odd == ivec2(0)) return ground;
    Ground other = ground_at(tile.parent, last, tile.level - 1u);
    return Ground(0.5 * (ground.slope + other.slope), 0.5 * (ground.relief + other.relief),
                  0.5 * (ground.albedo + other.albedo));
}

bool has(uint borders, uint bit) {
    return (borders >> bit & 1u) == 1u;
}

// West, east, north, south.
bvec4 edges(ivec2 at) {
    return bvec4(at.x == 0, at.x == SIDE, at.y == 0, at.y == SIDE);
}

// How much of the newest octave a vertex has. Where tiles of several levels meet, it has what the coarsest of them has.
float share_at_borders(float share, ivec2 at, uint borders) {
    bvec4 on = edges(at);
    if (any(on.xy) && any(on.zw)) {
        uint corner = uint(on.y) + 2u * uint(on.w);
        return has(borders, 8u + corner) ? 0.0 : has(borders, 12u + corner) ? 1.0 : share;
    }
    for (uint edge = 0u; edge < 4u; ++edge) {
        if (on[edge]) return has(borders, edge) ? 0.0 : has(borders, 4u + edge) ? 1.0 : share;
    }
    return share;
}

void main() {
    TileView tile = tiles[gl_InstanceIndex];
    ivec2 at = ivec2(gl_VertexIndex % (SIDE + 1), gl_VertexIndex / (SIDE + 1));
    // Before some are moved: so edges of all triangles lie where whole numbers do, and on their cells' diagonals.
    grid = vec2(at);
    level = tile.level - BITS;
    // An edge that faces a coarser tile has its vertices only.
    bvec4 on = edges(at);
    if (on.x && has(tile.borders, 0u) || on.y && has(tile.borders, 1u)) at.y &= ~1;
    if (on.z && has(tile.borders, 2u) || on.w && has(tile.borders, 3u)) at.x &= ~1;

    int octave = noise(tile.key, plus(uvec2(tile.x[0], tile.x[1]), uint(at.x)), plus(uvec2(tile.z[0], tile.z[1]), uint(at.y)));
    int64_t eastward = tile.origin[0] + (int64_t(at.x) << tile.shift);
    int64_t southward = tile.origin[2] + (int64_t(at.y) << tile.shift);
    int64_t coarse_up = tile.origin[1] + (int64_t(height(tile.own.slot, at) - octave) << tile.height_shift);
    precise vec3 coarse_place = push.unit * vec3(float(eastward), float(coarse_up), float(southward));

    float share = 1.0;
    if (!has(tile.borders, 16u)) {
        precise float range = length(coarse_place - push.focus);
        share = 1.0 - smoothstep(push.fade.x * tile.spacing, push.fade.y * tile.spacing, range);
    }
    share = share_at_borders(share, at, tile.borders);
    // Exact for all of the octave and for nothing of it.
    precise float newest = share * float(int64_t(octave) << tile.height_shift);
    int64_t up = coarse_up + int64_t(newest);
    place = vec3(coarse_place.x, push.unit * float(up), coarse_place.z);

    Ground here = ground_at(tile.own, at, tile.level);
    if (share < 1.0) {
        Ground coarse = coarse_ground(tile, at);
        here.slope = mix(coarse.slope, here.slope, share);
        here.relief = mix(coarse.relief, here.relief, share);
        here.albedo = mix(coarse.albedo, here.albedo, share);
    }
    slope = here.slope;
    relief = here.relief;
    albedo = here.albedo;

    precise vec3 seen = vec3(dot(frame.right, place), dot(frame.up, place), dot(frame.forward, place));
    gl_Position = vec4(seen.xy / frame.tangent, push.near, seen.z);
}
