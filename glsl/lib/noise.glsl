// Simplex noise in the plane (Perlin 2002, in the layout of Gustavson 2005) and its octaves.
#ifndef NOISE_GLSL
#define NOISE_GLSL

#include "lib/hash.glsl"

// The 16 gradients are unit vectors at odd multiples of π/16.
vec2 gradient_of(uint bits) {
    uint k = bits >> 28;
    const float c[4] = float[4](0.98078528, 0.83146961, 0.55557023, 0.19509032);
    uint i = k & 3u;
    vec2 g = vec2(c[i], c[3u - i]);
    // Quadrants follow each other by a quarter turn.
    switch (k >> 2) {
        case 0u: return g;
        case 1u: return vec2(-g.y, g.x);
        case 2u: return -g;
        default: return vec2(g.y, -g.x);
    }
}

float corner(uint seed, ivec2 lattice, vec2 offset) {
    float reach = max(0.0, 0.5 - dot(offset, offset));
    reach *= reach;
    return reach * reach * dot(gradient_of(hash(seed, lattice)), offset);
}

// About −1 … 1.
float simplex(vec2 p, uint seed) {
    const float SKEW = 0.36602540;   // (√3 − 1)/2
    const float UNSKEW = 0.21132487; // (3 − √3)/6
    vec2 base = floor(p + (p.x + p.y) * SKEW);
    vec2 offset0 = p - (base - (base.x + base.y) * UNSKEW);
    vec2 middle = offset0.x > offset0.y ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    vec2 offset1 = offset0 - middle + UNSKEW;
    vec2 offset2 = offset0 - 1.0 + 2.0 * UNSKEW;
    ivec2 lattice = ivec2(base);
    return 92.07
        * (corner(seed, lattice, offset0) + corner(seed, lattice + ivec2(middle), offset1)
           + corner(seed, lattice + 1, offset2));
}

// Σ η(p·2^i/wavelength)/2^i (Korošec & Lebar Bajec (3)). Each octave is shifted, so that they share no lattice point.
float octaves(vec2 p, float wavelength, uint count, uint seed) {
    float total = 0.0;
    float scale = 1.0;
    for (uint octave = 0u; octave < count; ++octave) {
        uint octave_seed = mix_bits(seed + octave);
        uvec2 shift = uvec2(mix_bits(octave_seed + 0x68bc21ebu), mix_bits(octave_seed + 0x02e5be93u)) >> 8;
        total += simplex(p * (scale / wavelength) + vec2(shift) * exp2(-20.0), octave_seed) / scale;
        scale *= 2.0;
    }
    return total;
}

#endif
