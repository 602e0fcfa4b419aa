// Unit vectors in 32 bits, by an octahedron unfolded onto a square (Cigolle et al. 2014, "A Survey of Efficient
// Representations for Independent Unit Vectors").
#ifndef OCTAHEDRON_GLSL
#define OCTAHEDRON_GLSL

vec2 unfolded(vec3 v) {
    vec2 side = vec2(v.x >= 0.0 ? 1.0 : -1.0, v.z >= 0.0 ? 1.0 : -1.0);
    vec2 flat_ = v.xz / (abs(v.x) + abs(v.y) + abs(v.z));
    return v.y >= 0.0 ? flat_ : (1.0 - abs(flat_.yx)) * side;
}

uint pack_direction(vec3 v) {
    return packSnorm2x16(unfolded(v));
}

vec3 unpack_direction(uint bits) {
    vec2 at = unpackSnorm2x16(bits);
    vec3 v = vec3(at.x, 1.0 - abs(at.x) - abs(at.y), at.y);
    vec2 side = vec2(v.x >= 0.0 ? 1.0 : -1.0, v.z >= 0.0 ? 1.0 : -1.0);
    v.xz -= max(-v.y, 0.0) * side;
    return normalize(v);
}

#endif
