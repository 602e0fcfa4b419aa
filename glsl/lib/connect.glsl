// Adds the lights that nothing hides. The includer defines `trace`.
#ifndef CONNECT_GLSL
#define CONNECT_GLSL

#include "lib/hit.glsl"
#include "lib/lattice.glsl"
#include "lib/path.glsl"
#include "lib/tree.glsl"

layout(local_size_x = GROUP) in;

layout(binding = 2) uniform usamplerBuffer placements;
layout(binding = 3, scalar) readonly buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Looks { Look looks[]; };
layout(binding = 5, scalar) buffer Paths { Path paths[]; };

layout(push_constant, scalar) uniform Push {
    uint turn;
    Lattice lattice;
} push;

// The nearest triangle before `reach`; any of them if `any_`.
Hit trace(vec3 origin, vec3 direction, float reach, const bool any_);

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.turn].looks.paths) return;
    Look look = looks[slot];
    Hit hit = trace(look.origin, look.direction, 1e30, true);
    if (hit.triangle != NOTHING) return;
    // No path looks twice in one turn, so no other invocation adds to it.
    paths[look.path].radiance += look.radiance;
}

#endif
