// Procedural texture: gradient noise that fades out before it becomes finer than what can be resolved.
#ifndef TEXTURE_GLSL
#define TEXTURE_GLSL

// Two random words from two (Jarzynski & Olano 2020, pcg2d).
uvec2 scatter(uvec2 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> 16u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    return v ^ (v >> 16u);
}

vec2 scatter_unit(ivec2 cell, uint stream) {
    return vec2(scatter(uvec2(cell) + uvec2(stream * 0x9e3779b9u, stream)) >> 8u) / 16777216.0;
}

// A gradient whose two parts have mean 0 and variance 1/2.
vec2 lattice_gradient(ivec2 cell, uint stream) {
    return (scatter_unit(cell, stream) - 0.5) * 2.449;
}

// Gradient noise (Perlin 2002) with its derivative: (value, d/dx, d/dy), of standard deviation about 0.4.
vec3 noise(vec2 at, uint stream) {
    vec2 corner = floor(at);
    ivec2 cell = ivec2(corner);
    vec2 t = at - corner;
    vec2 g00 = lattice_gradient(cell, stream);
    vec2 g10 = lattice_gradient(cell + ivec2(1, 0), stream);
    vec2 g01 = lattice_gradient(cell + ivec2(0, 1), stream);
    vec2 g11 = lattice_gradient(cell + ivec2(1, 1), stream);
    float v00 = dot(g00, t);
    float v10 = dot(g10, t - vec2(1.0, 0.0));
    float v01 = dot(g01, t - vec2(0.0, 1.0));
    float v11 = dot(g11, t - vec2(1.0, 1.0));
    vec2 u = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    vec2 du = 30.0 * t * t * (t * (t - 2.0) + 1.0);
    float twist = v00 - v10 - v01 + v11;
    float value = v00 + u.x * (v10 - v00) + u.y * (v01 - v00) + u.x * u.y * twist;
    vec2 derivative = g00 + u.x * (g10 - g00) + u.y * (g01 - g00) + u.x * u.y * (g00 - g10 - g01 + g11)
                    + du * (u.yx * twist + vec2(v10, v01) - v00);
    return vec3(value, derivative);
}

// How much of a pattern of this wavelength a footprint of this size can resolve.
float resolved(float wavelength, float footprint) {
    return smoothstep(1.5, 4.0, wavelength / footprint);
}

// Sum of octaves from `wavelength` downwards, each `gain` times the one before, none finer than `footprint` resolves:
// (value, slope along x and z), value of standard deviation about 0.5, slope per metre. Each octave is turned, so that
// the lattices never line up. With `billow` 1 the octaves are domes that meet in sharp creases.
vec3 octave_sum(vec2 xz, float wavelength, int octaves, float gain, float footprint, uint stream, float billow) {
    const mat2 turn = mat2(0.8, 0.6, -0.6, 0.8);
    mat2 octave_frame = mat2(1.0);
    vec3 sum = vec3(0.0);
    float amplitude = 1.0;
    for (int octave = 0; octave < octaves; ++octave) {
        float weight = resolved(wavelength, footprint);
        if (weight == 0.0) break;
        vec3 part = noise(octave_frame * xz / wavelength, stream + uint(octave));
        part.yz = part.yz * octave_frame / wavelength;
        // A dome is 2 (|noise| − its mean): as large as the noise and centred like it.
        vec3 dome = 2.0 * vec3(abs(part.x) - 0.3, sign(part.x) * part.yz);
        sum += amplitude * weight * mix(part, dome, billow);
        amplitude *= gain;
        wavelength *= 0.5;
        octave_frame = turn * octave_frame;
    }
    return sum;
}

vec3 mottle(vec2 xz, float wavelength, int octaves, float gain, float footprint, uint stream) {
    return octave_sum(xz, wavelength, octaves, gain, footprint, stream, 0.0);
}

// Like the crowns of a forest.
vec3 billows(vec2 xz, float wavelength, int octaves, float gain, float footprint, uint stream) {
    return octave_sum(xz, wavelength, octaves, gain, footprint, stream, 1.0);
}

#endif
