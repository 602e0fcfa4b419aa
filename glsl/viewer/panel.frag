#version 460
#extension GL_EXT_scalar_block_layout : require

// Colours are blended as they are stored, in sRGB, which is what the user interface is designed for.

layout(binding = 1, rgba8) uniform readonly image2D picture;

layout(location = 0) in vec2 uv;
layout(location = 1) in vec4 colour;
layout(location = 0) out vec4 shown;

vec4 texel(ivec2 at) {
    return imageLoad(picture, clamp(at, ivec2(0), imageSize(picture) - 1));
}

void main() {
    vec2 place = uv * vec2(imageSize(picture)) - 0.5;
    ivec2 at = ivec2(floor(place));
    vec2 part = place - vec2(at);
    vec4 upper = mix(texel(at), texel(at + ivec2(1, 0)), part.x);
    vec4 lower = mix(texel(at + ivec2(0, 1)), texel(at + ivec2(1, 1)), part.x);
    shown = colour * mix(upper, lower, part.y);
}
