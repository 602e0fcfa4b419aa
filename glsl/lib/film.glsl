// Exact sums of samples.
#ifndef FILM_GLSL
#define FILM_GLSL

// Sums over the samples of a pixel, in steps of 1/STEPS.
struct Pixel {
    int64_t radiance[3];   // times the exposure
    int64_t odd[3];        // the same of every other sample: what the noise is judged by
    int64_t albedo[3];
    int64_t normal[3];
    int64_t position[3];   // metres
    int64_t depth;         // metres
    uint covered;          // samples that met something
    uint object;           // of the first sample
};

const float STEPS = 16777216.0;
// 2^38: more than 2^24 samples of it are below the largest sum.
const float LARGEST = 274877906944.0;

// A sample in steps. What is not a number is none.
int64_t rounded(float value) {
    if (isnan(value)) return 0l;
    // Beyond 2^24 steps a float has no fraction left to round.
    return int64_t(roundEven(clamp(value, -LARGEST / STEPS, LARGEST / STEPS) * STEPS));
}

#endif
