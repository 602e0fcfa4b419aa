// Paths of light, from the eye on: what the passes of the tracer hand to each other.
#ifndef PATH_GLSL
#define PATH_GLSL

struct Path {
    vec3 origin;
    vec3 direction;
    vec3 throughput;
    vec3 radiance;       // gathered so far
    float density;       // of the direction, 1/sr; 0 where only this direction could be taken
    float sky_share;     // how often the last place looked for the sky rather than for the sun
    float width;         // of the cone that the path stands for, metres
    float spread;        // by how much it widens in one metre
    uint medium;         // AIR or WATER
};

const uint AIR = 0u;
const uint WATER = 1u;

// A look at a light that may be hidden.
struct Look {
    vec3 origin;
    vec3 direction;
    float reach;         // to the surface of the sea; ENDLESS in the air
    vec3 above;          // direction from there on
    vec3 radiance;       // if it is not hidden
    uint path;
};

const float ENDLESS = 1e30;

// What the eye sees first.
struct Feature {
    vec3 albedo;
    vec3 normal;
    vec3 position;
    float depth;         // distance from the eye, metres; 0 for the sky
    uint object;         // as in Placement
};

// Paths that a workgroup serves.
const uint GROUP = 64u;

// How many wait in a queue, and the workgroups that serve them: an indirect dispatch reads these. Exactly as many lanes run as there is
// work for: a device in software computes idle ones to their end.
struct Waiting {
    uint paths;
    uvec3 groups;
};

const Waiting NONE = Waiting(0u, uvec3(0u, 1u, 1u));

#define ENQUEUE(queue, waiting, index)                                  \
    {                                                                   \
        uint place = atomicAdd(waiting.paths, 1u);                      \
        if (place % GROUP == 0u) atomicAdd(waiting.groups.x, 1u);       \
        queue[place] = index;                                           \
    }

// The paths that are at work in a turn, and what becomes of them.
struct Turn {
    Waiting paths;
    Waiting escaped;
    Waiting land;
    Waiting models;
    Waiting sea;
    Waiting looks;
};

// Distance beyond which the sea is not seen, metres.
const float HORIZON = 1e6;

// What the programs that turn paths are to do.
struct Work {
    uint seed;
    uint index;          // of the sample
    ivec2 origin;        // first pixel of the block, in all of the picture
    int columns;         // of the block
    int first;           // of its pixels that are at work
    uint turn;           // scatterings so far
    uint bounces;        // scatterings that a path may have
    uint plain;          // 1: materials have their mean colour and nothing else
    float sea_level;     // least of numbers where there is none
};

#endif
