// Where a ray ends.
#ifndef HIT_GLSL
#define HIT_GLSL

struct Hit {
    float range;     // in lengths of the ray's direction
    float u;         // weights of the triangle's second and third corner
    float v;
    uint placement;
    uint triangle;   // NOTHING if there is none
};

const uint NOTHING = 0xffffffffu;

#endif
