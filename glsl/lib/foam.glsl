// White water. `lib/heightfield.glsl` and `lib/texture.glsl` stand before.
#ifndef FOAM_GLSL
#define FOAM_GLSL

// White water where waves from the open sea break: lines along the depth contours, lace behind them, and a fringe of
// swash at the shore.
float foam(vec2 xz, float depth, float exposure, float footprint) {
    float surge = smoothstep(0.1, 0.7, exposure);
    if (surge == 0.0 || depth > 6.0) return 0.0;
    vec3 torn = mottle(xz, 90.0, 7, 0.7, footprint, 301u);
    vec3 lace = billows(xz, 14.0, 4, 0.7, footprint, 321u);
    float run = depth + 1.1 * torn.x;
    // Three waves are breaking at a time; where a sample covers several of them only their mean is left.
    float fineness = resolved(1.1, length(height_slope(xz)) * footprint);
    float lines = mix(0.42, smoothstep(0.1, 0.9, sin(2.0 * PI * run / 1.1)), fineness);
    float breakers = (1.0 - smoothstep(2.2, 4.2, run)) * smoothstep(0.5, 1.3, run) * lines;
    float behind = 0.55 * (1.0 - smoothstep(0.8, 2.4, run)) * (1.0 - smoothstep(-0.35, 0.15, lace.x))
                 * smoothstep(-0.3, 0.4, torn.x);
    float swash = 0.8 * (1.0 - smoothstep(0.1, 0.45, depth + 0.25 * torn.x));
    return clamp(surge * max(max(breakers, behind), swash), 0.0, 1.0);
}

#endif
