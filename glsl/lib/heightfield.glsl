// The ground between its samples. The includer declares `height`, the r32f image of metres above the datum.
#ifndef HEIGHTFIELD_GLSL
#define HEIGHTFIELD_GLSL

// Column and row, in samples, of a world position.
vec2 grid_position(vec2 xz) {
    return (xz + 0.5 * frame.extent) / frame.cell_size;
}

ivec2 clamp_to_grid(ivec2 cell) {
    return clamp(cell, ivec2(0), ivec2(frame.cells - 1));
}

float height_at(ivec2 cell) {
    return imageLoad(height, clamp_to_grid(cell)).x;
}

// How far outside the grid a position lies, metres.
float outside(vec2 xz) {
    return length(max(abs(xz) - 0.5 * frame.extent, 0.0));
}

// Bilinear height; outside the grid the bottom falls away by half the distance.
float height_bilinear(vec2 xz) {
    vec2 at = clamp(grid_position(xz), vec2(0.0), vec2(frame.cells - 1));
    ivec2 cell = ivec2(at);
    vec2 t = at - vec2(cell);
    float north = mix(height_at(cell), height_at(cell + ivec2(1, 0)), t.x);
    float south = mix(height_at(cell + ivec2(0, 1)), height_at(cell + ivec2(1, 1)), t.x);
    return mix(north, south, t.y) - 0.5 * outside(xz);
}

// Weights of four samples at -1, 0, 1 and 2 for an interpolating cubic (Catmull & Rom 1974).
vec4 catmull_rom(float t) {
    float t2 = t * t;
    float t3 = t2 * t;
    return 0.5 * vec4(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2);
}

// The same for the uniform cubic B-spline: smoother, not interpolating.
vec4 b_spline(float t) {
    float s = 1.0 - t;
    return vec4(s * s * s, 4.0 - 6.0 * t * t + 3.0 * t * t * t, 4.0 - 6.0 * s * s + 3.0 * s * s * s, t * t * t) / 6.0;
}

vec4 b_spline_derivative(float t) {
    float s = 1.0 - t;
    return 0.5 * vec4(-s * s, 3.0 * t * t - 4.0 * t, 3.0 * t - 3.0 * t * t + s, t * t);
}

vec4 height_row(ivec2 cell) {
    return vec4(height_at(cell + ivec2(-1, 0)), height_at(cell), height_at(cell + ivec2(1, 0)),
                height_at(cell + ivec2(2, 0)));
}

// The ground as it is drawn: through every sample, with a continuous slope.
float height_cubic(vec2 xz) {
    vec2 at = clamp(grid_position(xz), vec2(0.0), vec2(frame.cells - 1));
    ivec2 cell = ivec2(at);
    vec2 t = at - vec2(cell);
    vec4 across = catmull_rom(t.x);
    vec4 down = catmull_rom(t.y);
    float sum = 0.0;
    for (int row = 0; row < 4; ++row) {
        sum += down[row] * dot(across, height_row(cell + ivec2(0, row - 1)));
    }
    return sum;
}

// Slope (dh/dx, dh/dz) of the B-spline through the same samples: its curvature is continuous, so that shading shows
// no trace of the grid.
vec2 height_slope(vec2 xz) {
    vec2 at = clamp(grid_position(xz), vec2(0.0), vec2(frame.cells - 1));
    ivec2 cell = ivec2(at);
    vec2 t = at - vec2(cell);
    vec4 across = b_spline(t.x);
    vec4 across_derivative = b_spline_derivative(t.x);
    vec4 down = b_spline(t.y);
    vec4 down_derivative = b_spline_derivative(t.y);
    vec2 slope = vec2(0.0);
    for (int row = 0; row < 4; ++row) {
        vec4 samples = height_row(cell + ivec2(0, row - 1));
        slope += vec2(down[row] * dot(across_derivative, samples), down_derivative[row] * dot(across, samples));
    }
    return slope / frame.cell_size;
}

vec3 normal_from_slope(vec2 slope) {
    return normalize(vec3(-slope.x, 1.0, -slope.y));
}

#endif
