// What arrives on the ground.
#ifndef LIGHT_GLSL
#define LIGHT_GLSL

// Share of the sun's disc that shows above the ground's shadow: `shade` is its height and its distance (shadow.comp),
// `blur` a length in metres below which the edge shall not be sharp.
float sun_visibility(float y, vec2 shade, float blur) {
    float level = max(length(frame.sun_direction.xz), 1e-4);
    float rise = frame.sun_direction.y / level;
    float penumbra = shade.y * frame.sun_radius * (1.0 + rise * rise) + rise * blur + 1e-3;
    return smoothstep(-penumbra, penumbra, y - shade.x);
}

// Light that the ground throws back on itself where it hides the sky: about what it receives in the open, once.
vec3 bounced(vec3 albedo, float openness) {
    vec3 open = frame.sun_irradiance * max(frame.sun_direction.y, 0.0) + sky_irradiance(vec3(0.0, 1.0, 0.0));
    return (1.0 - openness) * 0.6 * albedo * open;
}

#endif
