// Placements as they lie in memory. The includer declares the texel buffer `placements`.
#ifndef PLACEMENTS_GLSL
#define PLACEMENTS_GLSL

#include "lib/tree.glsl"

Placement placement_at(uint index) {
    int at = 3 * int(index);
    vec4 place = uintBitsToFloat(texelFetch(placements, at));
    vec4 rotation = uintBitsToFloat(texelFetch(placements, at + 1));
    uvec4 names = texelFetch(placements, at + 2);
    return Placement(place.xyz, place.w, rotation, names.x, names.y, names.z, names.w);
}

#endif
