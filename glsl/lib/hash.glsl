// Integer hashing, the twin of core/hash.rs.
#ifndef HASH_GLSL
#define HASH_GLSL

// PCG-RXS-M-XS (O'Neill 2014; Jarzynski & Olano 2020): a bijection that scatters neighbouring inputs.
uint mix_bits(uint value) {
    uint state = value * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uint hash(uint seed, ivec2 at) {
    return mix_bits(uint(at.x) + mix_bits(uint(at.y) + seed));
}

// Uniform in [−1, 1).
float signed_unit(uint bits) {
    return float(bits >> 8) * exp2(-23.0) - 1.0;
}

#endif
