// What rays are traced through. It lies in texel buffers: a device in software reads these four numbers at a time.
#ifndef TREE_GLSL
#define TREE_GLSL

#include "lib/quaternion.glsl"

// Eight children in boxes of a common scale, in five texels. Laid out by the crate `obvhs`.
struct Node {
    vec3 origin;         // least corner of all boxes
    uint exponents;      // of the scale, three bytes; the fourth says which children are nodes
    uint first_child;
    uint first_leaf;     // of the triangles, or of the placements
    uvec2 meta;          // a byte a child: how many leaves and where, or 001 and its place plus 24
    uvec2 least_x;       // a byte a child
    uvec2 greatest_x;
    uvec2 least_y;
    uvec2 greatest_y;
    uvec2 least_z;
    uvec2 greatest_z;
};

// In three texels, and so is a placement; their twins are in `src/trace/tree.rs`.
struct Triangle {
    vec3 a;
    vec3 b;
    vec3 c;
    uint normals[3];     // of its corners: octahedral, two signed normalised 16-bit numbers
};

// A model where it stands.
struct Placement {
    vec3 position;       // of the model's origin
    float scale;
    vec4 rotation;       // unit quaternion
    uint root;           // node of the model's tree
    uint first;          // of its triangles
    uint random;
    uint object;         // 1 + index of the instance; 0 for the land
};

#endif
