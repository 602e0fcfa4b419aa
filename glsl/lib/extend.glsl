// Finds what each path meets next, and sorts paths by it. The includer defines `trace`.
#ifndef EXTEND_GLSL
#define EXTEND_GLSL

#include "lib/hit.glsl"
#include "lib/lattice.glsl"
#include "lib/path.glsl"
#include "lib/tree.glsl"

layout(local_size_x = GROUP) in;

layout(binding = 2) uniform usamplerBuffer placements;

#include "lib/placements.glsl"

layout(binding = 3, scalar) buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Queue { uint queue[]; };
layout(binding = 5, scalar) readonly buffer Paths { Path paths[]; };
layout(binding = 6, scalar) writeonly buffer Hits { Hit hits[]; };
layout(binding = 7, scalar) writeonly buffer Escaped { uint escaped[]; };
layout(binding = 8, scalar) writeonly buffer Land { uint land[]; };
layout(binding = 9, scalar) writeonly buffer Models { uint models[]; };
layout(binding = 10, scalar) writeonly buffer Sea { uint sea[]; };

layout(push_constant, scalar) uniform Push {
    uint turn;
    float sea_level;
    Lattice lattice;
} push;

// The nearest triangle before `reach`; any of them if `any_`.
Hit trace(vec3 origin, vec3 direction, float reach, const bool any_);

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.turn].paths.paths) return;
    uint index = queue[slot];
    Path path = paths[index];
    // The sea is flat and ends nowhere near. A path starts off it, on its own side.
    float to_sea = (push.sea_level - path.origin.y) / path.direction.y;
    bool meets_sea = to_sea > 0.0 && to_sea < HORIZON && (path.medium == WATER) == (path.direction.y > 0.0);
    Hit hit = trace(path.origin, path.direction, meets_sea ? to_sea : ENDLESS, false);
    hits[index] = hit;
    if (hit.triangle == NOTHING) {
        if (meets_sea) {
            ENQUEUE(sea, turns[push.turn].sea, index)
        } else {
            ENQUEUE(escaped, turns[push.turn].escaped, index)
        }
    } else if (placement_at(hit.placement).object == 0u) {
        ENQUEUE(land, turns[push.turn].land, index)
    } else {
        ENQUEUE(models, turns[push.turn].models, index)
    }
}

#endif
