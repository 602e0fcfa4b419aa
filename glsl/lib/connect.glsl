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
    // Under water first to the surface, where the way bends. A loop, since idle lanes of a device in software leave it.
    vec3 origin = look.origin;
    vec3 direction = look.direction;
    float reach = look.reach;
    for (int leg = reach < ENDLESS ? 0 : 1; leg < 2; ++leg) {
        if (trace(origin, direction, reach, true).triangle != NOTHING) return;
        origin += reach * direction;
        direction = look.above;
        reach = ENDLESS;
    }
    // No path looks twice in one turn, so no other invocation adds to it.
    paths[look.path].radiance += look.radiance;
}

#endif
