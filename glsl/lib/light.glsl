// What arrives on the ground.
#ifndef LIGHT_GLSL
#define LIGHT_GLSL

// How fast the ray towards the sun rises: the tangent of its elevation, finite even in the zenith.
float sun_rise() {
    return max(frame.sun_direction.y, 0.0) / max(length(frame.sun_direction.xz), 1e-4);
}

// Share of the sun's disc that shows above the ground's shadow: `shade` is its height and its distance (shadow.comp) and
// `cell` the distance of its samples; `blur` is a length in metres below which the edge shall not be sharp.
float sun_visibility(float y, vec2 shade, float cell, float blur) {
    float rise = sun_rise();
    // From the disc's centre to its lower edge, tan e − tan(e − r). The nearest sample only continues the ground, and
    // an edge blurred by more than its distance would darken what nothing hides.
    float t = tan(frame.sun_radius);
    float penumbra = max(shade.y - 1.5 * cell, 0.0) * t * (1.0 + rise * rise) / (1.0 + rise * t)
                   + rise * min(blur, cell) + 1e-3;
    return smoothstep(-penumbra, penumbra, y - shade.x);
}

// Light that the ground throws back on itself where it hides the sky: about what it receives in the open, once.
vec3 bounced(vec3 albedo, float openness) {
    vec3 open = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
    return (1.0 - openness) * 0.6 * albedo * open;
}

#endif
