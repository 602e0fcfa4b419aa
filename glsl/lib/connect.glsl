// Adds the lights that nothing hides. The includer has `trace`.
#ifndef CONNECT_GLSL
#define CONNECT_GLSL

#include "lib/path.glsl"

layout(local_size_x = 64) in;

layout(binding = 3, scalar) readonly buffer Turns { Turn turns[]; };
layout(binding = 4, scalar) readonly buffer Looks { Look looks[]; };
layout(binding = 5, scalar) buffer Paths { Path paths[]; };

layout(push_constant, scalar) uniform Push {
    uint turn;
} push;

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= turns[push.turn].looks) return;
    Look look = looks[slot];
    Hit hit = trace(look.origin, look.direction, 1e30, true);
    if (hit.triangle != NOTHING) return;
    // No path looks twice in one turn, so no other invocation adds to it.
    paths[look.path].radiance += look.radiance;
}

#endif
