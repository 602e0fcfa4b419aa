// How columns and rows of the land's grid become metres.
#ifndef LATTICE_GLSL
#define LATTICE_GLSL

struct Lattice {
    float cell_size;
    float half_extent;
};

#endif
