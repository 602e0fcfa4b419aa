// Sample `index` of a pixel, two dimensions at a time: the (0, 2)-sequence of Sobol, scrambled and shuffled for each pair of
// dimensions by nested uniform permutations (Owen 1995; Burley 2020, "Practical Hash-based Owen Scrambling"). Every pair
// of dimensions is stratified at each power of two, and the sequence has no end.
#ifndef SAMPLER_GLSL
#define SAMPLER_GLSL

#include "lib/hash.glsl"

// Takes random numbers that know nothing of each other instead: to measure what the sequence is worth.
layout(constant_id = 0) const bool INDEPENDENT = false;

struct Sampler {
    uint seed;    // of the pixel
    uint index;   // of the sample
};

// Depends on the seed of the picture, the pixel's place in all of it, and the sample's number: on nothing else.
Sampler sampler_of(uint seed, ivec2 pixel, uint index) {
    return Sampler(hash(seed, pixel), index);
}

// A permutation in which a bit is flipped by what is below it alone (Laine & Karras 2011, with the constants that Vegdahl
// found in 2021).
uint nested_permutation(uint value, uint seed) {
    value ^= value * 0x3d20adeau;
    value += seed;
    value *= (seed >> 16) | 1u;
    value ^= value * 0x05526c56u;
    value ^= value * 0x53a22864u;
    return value;
}

// Owen's scrambling: the same from the highest bit down.
uint scrambled(uint value, uint seed) {
    return bitfieldReverse(nested_permutation(bitfieldReverse(value), seed));
}

// Digits of Sobol's second dimension, lowest first: its generator is Pascal's triangle modulo 2, a product of five sparse
// matrices.
uint pascal(uint digits) {
    digits ^= (digits >> 1) & 0x55555555u;
    digits ^= (digits >> 2) & 0x33333333u;
    digits ^= (digits >> 4) & 0x0f0f0f0fu;
    digits ^= (digits >> 8) & 0x00ff00ffu;
    digits ^= (digits >> 16) & 0x0000ffffu;
    return digits;
}

// Uniform in [0, 1), with 24 bits.
float unit(uint bits) {
    return float(bits >> 8) * exp2(-24.0);
}

// Two numbers in [0, 1) that belong to this pair of dimensions.
vec2 sampled(Sampler from, uint pair) {
    uint seed = mix_bits(from.seed + mix_bits(pair));
    if (INDEPENDENT) {
        uint first = mix_bits(seed + mix_bits(from.index));
        return vec2(unit(first), unit(mix_bits(first ^ 0x68bc21ebu)));
    }
    uint index = scrambled(from.index, seed);
    uint second = mix_bits(seed);
    return vec2(unit(scrambled(bitfieldReverse(index), second)),
                unit(scrambled(bitfieldReverse(pascal(index)), mix_bits(second))));
}

#endif
