// Improved noise (Perlin 2002, "Improving Noise"), with his permutation and his twelve gradients.
#ifndef PERLIN_GLSL
#define PERLIN_GLSL

// Four a word, the lowest byte first.
const uint PERMUTATION[64] = uint[64](
    0x5b89a097u, 0x0d830f5au, 0x35605fc9u, 0xe107e9c2u, 0x1e67248cu, 0x63088e45u, 0x0a15f025u, 0x9406be17u,
    0x4bea78f7u, 0x3ec51a00u, 0xcbdbfc5eu, 0x200b2375u, 0x5821b139u, 0x573895edu, 0x887d14aeu, 0xaf44a8abu,
    0x8647a54au, 0xa61b308bu, 0xe79e924du, 0x7ae56f53u, 0xe685d33cu, 0x295c69dcu, 0x28f52e37u, 0x368f66f4u,
    0xa13f1941u, 0x4950d801u, 0xbb844cd1u, 0xa91259d0u, 0x8287c4c8u, 0x569fbc74u, 0xc66d64a4u, 0x4003baadu,
    0xfae2d934u, 0xca057b7cu, 0x7e769326u, 0xd45552ffu, 0xe33bcecfu, 0x113a102fu, 0x2a1cbdb6u, 0xd5aab7dfu,
    0x0298f877u, 0x46a39a2cu, 0x9b6599ddu, 0x09ac2ba7u, 0xfd271681u, 0x6e6c6213u, 0xe8e0714fu, 0x6870b9b2u,
    0xe461f6dau, 0xc1f222fbu, 0x0c90d2eeu, 0xf1a2b3bfu, 0xeb913351u, 0x6bef0ef9u, 0x1fd6c031u, 0x9d6ac7b5u,
    0xb0cc54b8u, 0x2d327973u, 0xfe96047fu, 0x5dcdec8au, 0x1d4372deu, 0x8df34818u, 0x424ec380u, 0xb49c3dd7u);

uint permuted(uint index) {
    return (PERMUTATION[(index >> 2) & 63u] >> (8u * (index & 3u))) & 255u;
}

// Along the gradient that the four lowest bits choose: an edge of the cube, four of them twice.
float along_gradient(uint bits, vec3 offset) {
    uint edge = bits & 15u;
    float u = edge < 8u ? offset.x : offset.y;
    float v = edge < 4u ? offset.y : edge == 12u || edge == 14u ? offset.x : offset.z;
    return ((edge & 1u) == 0u ? u : -u) + ((edge & 2u) == 0u ? v : -v);
}

// About −1 … 1, 0 on the lattice; it repeats after 256.
float perlin(vec3 at) {
    vec3 corner = floor(at);
    uvec3 cell = uvec3(ivec3(corner)) & 255u;
    vec3 t = at - corner;
    vec3 fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    vec4 edges;   // along x, at the four edges
    for (uint edge = 0u; edge < 4u; ++edge) {
        uvec2 yz = uvec2(edge & 1u, edge >> 1);
        vec3 offset = t - vec3(0.0, yz);
        float values[2];
        for (uint x = 0u; x < 2u; ++x) {
            uint hash = permuted(permuted(permuted(cell.x + x) + cell.y + yz.x) + cell.z + yz.y);
            values[x] = along_gradient(hash, offset - vec3(x, 0.0, 0.0));
        }
        edges[edge] = mix(values[0], values[1], fade.x);
    }
    vec2 faces = mix(edges.xz, edges.yw, fade.y);
    return mix(faces.x, faces.y, fade.z);
}

#endif
