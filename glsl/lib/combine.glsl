// How a layer of the base terrain joins the height so far.
#ifndef COMBINE_GLSL
#define COMBINE_GLSL

// Add, multiply, power, max, min.
layout(constant_id = 0) const uint COMBINE = 0;

float combine(float height, float value, float reference) {
    switch (COMBINE) {
        case 0u: return height + value;
        case 1u: return height * value;
        // On normalised height (Korošec & Lebar Bajec (4)).
        case 2u: return height > 0.0 ? reference * pow(height / reference, max(0.05, 1.0 + value)) : 0.0;
        case 3u: return max(height, value);
        default: return min(height, value);
    }
}

#endif
