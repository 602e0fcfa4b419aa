#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Finds what each path meets next.

#include "lib/path.glsl"
#include "lib/tree.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, scalar) readonly buffer Nodes { Node nodes[]; };
layout(binding = 1, scalar) readonly buffer Triangles { Triangle triangles[]; };
layout(binding = 2, scalar) readonly buffer Placements { Placement placements[]; };
layout(binding = 3, scalar) readonly buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Queue { uint queue[]; };
layout(binding = 5, scalar) readonly buffer Paths { Path paths[]; };

#include "lib/bvh.glsl"

layout(binding = 6, scalar) writeonly buffer Hits { Hit hits[]; };

layout(push_constant, scalar) uniform Push {
    uint turn;
    float sea_level;
} push;

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.turn].paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    // The sea is flat and has no end. A path starts off it, on its own side.
    float to_sea = (push.sea_level - path.origin.y) / path.direction.y;
    bool meets_sea = to_sea > 0.0 && (path.medium == WATER) == (path.direction.y > 0.0);
    Hit hit = trace(path.origin, path.direction, meets_sea ? to_sea : 1e30, false);
    if (hit.triangle == NOTHING && meets_sea) hit.triangle = SEA;
    hits[index] = hit;
}
