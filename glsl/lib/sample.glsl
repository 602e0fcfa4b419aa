// Where a cell of the grid falls in a raster that is stretched over the same square, samples at vertices.
#ifndef SAMPLE_GLSL
#define SAMPLE_GLSL

struct Place {
    ivec2 texel;
    vec2 fraction;
};

// In integers, so that a raster of the grid's own size is met exactly.
Place place(ivec2 cell, ivec2 cells, ivec2 size) {
    ivec2 scaled = cell * (size - 1);
    ivec2 texel = min(scaled / (cells - 1), max(size - 2, ivec2(0)));
    return Place(texel, vec2(scaled - texel * (cells - 1)) / vec2(cells - 1));
}

// Catmull–Rom: the weights of the texels −1, 0, 1, 2.
vec4 cubic(float f) {
    return vec4(((-0.5 * f + 1.0) * f - 0.5) * f, (1.5 * f - 2.5) * f * f + 1.0, ((-1.5 * f + 2.0) * f + 0.5) * f,
                (0.5 * f - 0.5) * f * f);
}

#endif
