// Exact sums of samples.
#ifndef FILM_GLSL
#define FILM_GLSL

// Sums over the samples of a pixel, in steps of 1/STEPS; of lengths, of 1/STEPS_IN_METRE.
struct Pixel {
    int64_t radiance[3];   // times the exposure
    int64_t odd[3];        // the same of every other sample: what the noise is judged by
    int64_t albedo[3];
    int64_t normal[3];
    int64_t position[3];   // metres
    int64_t depth;         // metres
    uint covered;          // samples that met something
    uint object;           // of sample 0
};

// How many samples of a block were not what they should have been.
struct Flawed {
    uint not_finite;       // not a number, or infinite: they count as black
    uint cut_off;          // too bright for the sums
};

const float STEPS = 16777216.0;
// A float of a kilometre or more is no finer.
const float STEPS_IN_METRE = 4096.0;
// Of a sample in steps, 2^42: 2^20 of them are below the largest sum. That is 262144 times white, or a million kilometres.
const float LARGEST = 4398046511104.0;

// A sample in steps. Where a float has more than 24 bits before the point it has no fraction left to round.
int64_t rounded(float value, float steps) {
    return int64_t(roundEven(clamp(value * steps, -LARGEST, LARGEST)));
}

#endif
